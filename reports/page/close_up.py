"""What the page's inspector shows of one scene against one reference, made where the arrays are.

A reference that fails on a scene leaves its arrays and minirt's, rounded and exact, and
explanations of its worst pixels; one that passes leaves explanations of a few typical pixels.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from minirt.explain.pixel import explain
from minirt.frame import Frame
from minirt.quantities import QUANTITIES, STAGES
from minirt.scene import Scene
from minirt.vectors import Floats
from reference.compare.check import Check
from reference.verify.results import Evidence
from reports.explain.second_opinion import Row, rows_at
from reports.explain.space import lines_of
from reports.page.arrays import Packed, pack, pack_ratio
from reports.page.pictures import Span, picture_span
from reports.results.clusters import (
    MOST,
    Cluster,
    Spread,
    WrongPixel,
    clusters_of,
    spread,
    worst_pixels,
)

#: Bytes that the arrays of one reference on one scene may take, before base64 adds a third.
ROOM = 1_550_000
#: Pixels of an image beyond which no arrays are kept: they would not fit.
MOST_PIXELS = 2**19
#: Seconds after which no further pixel of a scene is explained.
PATIENCE = 10.0
#: Pixels of a passing scene that are explained.
_TYPICAL = 3

Pixel = tuple[int, int]


@dataclass(frozen=True)
class Kept:
    """The arrays of one quantity.

    Attributes
    ----------
    ours, theirs : Packed
        Theirs packed beside ours.
    ratio : Packed
        Error over tolerance, with the sign of theirs − ours where that is one number.
    tolerance : Packed or None
        None for a discrete quantity.
    span : Span
        The values at the ends of its picture's colours.
    """

    ours: Packed
    theirs: Packed
    ratio: Packed
    tolerance: Packed | None
    span: Span

    @property
    def size(self) -> int:
        """Bytes."""
        parts = (self.ours, self.theirs, self.ratio, self.tolerance)
        return sum(len(packed.data) for packed in parts if packed is not None)


@dataclass(frozen=True)
class CloseUp:
    """One scene against one reference, close up.

    Attributes
    ----------
    arrays, exact : dict of str to Kept
        By quantity, what fails first first; empty where nothing fails. `exact` has float64 where
        `arrays` is rounded: it takes up to four times the room.
    first_stage : Packed or None
        Number of the first wrong stage; None where nothing fails.
    clusters : tuple of Cluster
        The `MOST` first of them.
    clustered : int
        How many there are.
    worst : tuple of WrongPixel
    rows : dict of (column, row) to tuple of Row
        Both's values at the pixels that are explained.
    stories : dict of (column, row) to str
        Explanations of those pixels, as JSON: steps and lines.
    spreads : dict of str to Spread
        By quantity.
    """

    arrays: dict[str, Kept] = field(default_factory=dict)
    exact: dict[str, Kept] = field(default_factory=dict)
    first_stage: Packed | None = None
    clusters: tuple[Cluster, ...] = ()
    clustered: int = 0
    worst: tuple[WrongPixel, ...] = ()
    rows: dict[Pixel, tuple[Row, ...]] = field(default_factory=dict)
    stories: dict[Pixel, str] = field(default_factory=dict)
    spreads: dict[str, Spread] = field(default_factory=dict)


def close_up_of(evidence: Evidence) -> CloseUp:
    """All that the inspector needs of the evidence."""
    comparison = evidence.comparison
    ratios = comparison.ratio
    spreads = {name: spread(ratio, comparison.error[name]) for name, ratio in ratios.items()}
    failed = [check for check in comparison.checks if check.state == "failed"]
    pixels = pixels_of(evidence)
    rows = {pixel: rows_at(pixel[1], pixel[0], evidence) for pixel in pixels}
    stories = _stories(evidence.scene, pixels)
    if not failed or not ratios:
        return CloseUp(rows=rows, stories=stories, spreads=spreads)
    clusters = clusters_of(comparison.first_stage, ratios)
    return CloseUp(
        **_kept(evidence),
        first_stage=pack(comparison.first_stage),
        clusters=clusters[:MOST],
        clustered=len(clusters),
        worst=worst_pixels(comparison.first_stage, ratios),
        rows=rows,
        stories=stories,
        spreads=spreads,
    )


def pixels_of(evidence: Evidence) -> tuple[Pixel, ...]:
    """The pixels of a scene that are explained, whoever it is that fails there."""
    wrong: list[Pixel] = []
    for comparison in (evidence.companions or {"": evidence.comparison}).values():
        if (comparison.first_stage >= 0).any():
            first, ratios = comparison.first_stage, comparison.ratio
            wrong += [(each.column, each.row) for each in clusters_of(first, ratios)[:MOST]]
            wrong += [(each.column, each.row) for each in worst_pixels(first, ratios)]
    return tuple(dict.fromkeys(wrong)) or typical_pixels(evidence.ours)


def _stories(scene: Scene, pixels: Iterable[Pixel]) -> dict[Pixel, str]:
    """Explanations by pixel, as many as there is time for: deep trees of rays take long."""
    end = time.perf_counter() + PATIENCE
    stories: dict[Pixel, str] = {}
    for pixel in pixels:
        stories[pixel] = _story(scene, *pixel)
        if time.perf_counter() > end:
            break
    return stories


@lru_cache(maxsize=256)
def _story(scene: Scene, column: int, row: int) -> str:
    """Steps and lines of a pixel, as JSON; references of one scene share them."""
    return story_json(scene, column, row)


def story_json(scene: Scene, column: int, row: int) -> str:
    """The steps and lines of a pixel, as JSON."""
    explanation = explain(scene, column, row)
    lines = [vars(line) for line in lines_of(scene, explanation)]
    return json.dumps({**explanation.to_dict(), "lines": lines}, allow_nan=False)


def typical_pixels(frame: Frame) -> tuple[Pixel, ...]:
    """A pixel in the midst of each of the objects that cover most of the image."""
    objects = frame["object"]
    seen, counts = np.unique(objects[objects >= 0], return_counts=True)
    largest = seen[np.argsort(-counts, kind="stable")][:_TYPICAL]
    chosen = []
    for index in largest if len(largest) else [-1]:
        rows, columns = np.nonzero(objects == index)
        away = (rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2
        middle = int(away.argmin())
        chosen.append((int(columns[middle]), int(rows[middle])))
    return tuple(chosen)


def _kept(evidence: Evidence) -> dict[str, dict[str, Kept]]:
    """Arrays of all quantities as float32, as long as there is room; and what is exact instead."""
    arrays: dict[str, Kept] = {}
    exact: dict[str, Kept] = {}
    room = ROOM if evidence.ours["hit"].size <= MOST_PIXELS else 0
    for name in _by_weight(evidence) if room else ():
        each = _keep(name, evidence, True)
        if each.size <= room:
            arrays[name] = each
            room -= each.size
            if not (each.ours.exact and each.theirs.exact):
                exact[name] = _keep(name, evidence, False)
    return {"arrays": arrays, "exact": exact}


def _by_weight(evidence: Evidence) -> list[str]:
    """Quantities in the order in which they get room: what fails first comes first."""
    compared = [c for c in evidence.comparison.checks if c.quantity in evidence.comparison.ratio]

    def weight(check: Check) -> tuple[bool, bool, bool, int]:
        discrete = QUANTITIES[check.quantity].discrete
        return (
            not check.first_wrong, not discrete, check.state != "failed",
            STAGES.index(check.stage),
        )  # fmt: skip

    return [check.quantity for check in sorted(compared, key=weight)]


def _keep(name: str, evidence: Evidence, rounded: bool) -> Kept:
    ours, theirs = evidence.ours[name], evidence.theirs[name]
    tolerance = evidence.stability.tolerance.get(name)
    return Kept(
        pack(ours, rounded=rounded),
        pack(theirs, ours, rounded=rounded),
        pack_ratio(_signed(name, evidence)),
        None if tolerance is None else pack_ratio(tolerance),
        picture_span(name, ours, theirs),
    )


def _signed(name: str, evidence: Evidence) -> Floats:
    """Error over tolerance, negative where theirs is a smaller number than ours."""
    ratio = evidence.comparison.ratio[name]
    if QUANTITIES[name].components > 1:
        return ratio
    with np.errstate(invalid="ignore"):
        smaller = evidence.theirs[name].astype(np.float64) < evidence.ours[name]
    return np.where(smaller, -ratio, ratio)
