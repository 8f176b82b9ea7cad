"""What a page shows of one scene against one reference, made while its arrays are at hand.

Of every quantity that was compared: small pictures. A reference that fails on a scene leaves its
arrays and minirt's, rounded and exact, and explanations of its worst pixels; one that passes
leaves explanations of a few typical pixels.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from minirt.explain.pixel import explain
from minirt.frame import Frame
from minirt.scene import Scene
from reference.compare.check import Check
from reference.verify.results import Evidence
from reports.explain.second_opinion import Row, rows_at
from reports.explain.space import lines_of
from reports.page.inspector.arrays import PackedArrays, packed_arrays
from reports.page.inspector.clusters import (
    MOST_LISTED,
    Cluster,
    Histogram,
    WrongPixel,
    clusters_of,
    histogram,
    worst_pixels,
)
from reports.page.inspector.packing import Packed, pack
from reports.page.pictures import (
    has_scale,
    picture_span,
    ratio_png,
    shrink_factor,
    shrunk,
    value_png,
)
from reports.page.thumbnails import SMALL

#: Largest sides, in pixels, of a failing quantity's pictures.
FULL = (512, 512)
#: Seconds after which no further pixel of a scene is explained.
TIME_LIMIT = 10.0
#: Pixels of a passing scene that are explained.
_TYPICAL = 3

Pixel = tuple[int, int]


@dataclass(frozen=True)
class Pictures:
    """One quantity of one scene against one reference, as PNG files.

    Attributes
    ----------
    ours, theirs, ratio : bytes
        Values on one scale, and error over tolerance.
    width, height : int
        Of each picture, in pixels.
    factor : int
        Pixels of the image to one of the pictures, each way.
    low, high : float or None
        What the ends of the scale stand for, where it is one of lengths.
    clipped : bool
        Whether larger values than `high` occur.
    """

    ours: bytes
    theirs: bytes
    ratio: bytes
    width: int
    height: int
    factor: int
    low: float | None
    high: float | None
    clipped: bool


@dataclass(frozen=True)
class Details:
    """One scene against one reference, as the page shows it.

    Attributes
    ----------
    pictures : dict of str to Pictures
        By quantity, of every quantity that was compared.
    arrays, exact : dict of str to PackedArrays
        By quantity, what fails first first; empty where nothing fails. `exact` has float64 where
        `arrays` is rounded: it takes up to four times the bytes.
    first_stage : Packed or None
        Number of the first wrong stage; None where nothing fails.
    clusters : tuple of Cluster
        The `MOST_LISTED` first of them.
    cluster_count : int
        How many there are.
    worst : tuple of WrongPixel
    rows : dict of (column, row) to tuple of Row
        The values of both at the pixels that are explained.
    explanations : dict of (column, row) to str
        Explanations of those pixels, as JSON: steps and lines.
    histograms : dict of str to Histogram
        Of the errors, by quantity.
    """

    pictures: dict[str, Pictures] = field(default_factory=dict)
    arrays: dict[str, PackedArrays] = field(default_factory=dict)
    exact: dict[str, PackedArrays] = field(default_factory=dict)
    first_stage: Packed | None = None
    clusters: tuple[Cluster, ...] = ()
    cluster_count: int = 0
    worst: tuple[WrongPixel, ...] = ()
    rows: dict[Pixel, tuple[Row, ...]] = field(default_factory=dict)
    explanations: dict[Pixel, str] = field(default_factory=dict)
    histograms: dict[str, Histogram] = field(default_factory=dict)


def details_of(evidence: Evidence) -> Details:
    """Pictures, and all that the inspector shows. A `MakeDetails`."""
    comparison = evidence.comparison
    ratios = comparison.ratio
    pixels = pixels_of(evidence)
    always = Details(
        pictures={
            check.quantity: _pictures(check, evidence)
            for check in comparison.checks
            if check.quantity in ratios
        },
        rows={pixel: rows_at(pixel[1], pixel[0], evidence) for pixel in pixels},
        explanations=_explanations(evidence.scene, pixels),
        histograms={name: histogram(r, comparison.error[name]) for name, r in ratios.items()},
    )
    if not ratios or not any(check.state == "failed" for check in comparison.checks):
        return always
    clusters = clusters_of(comparison.first_stage, ratios)
    rounded, exact = packed_arrays(evidence)
    return replace(
        always,
        arrays=rounded,
        exact=exact,
        first_stage=pack(comparison.first_stage),
        clusters=clusters[:MOST_LISTED],
        cluster_count=len(clusters),
        worst=worst_pixels(comparison.first_stage, ratios),
    )


def deserves_full_size(check: Check) -> bool:
    """A failing quantity is shown pixel by pixel, unless an earlier stage is the one to look at."""
    return check.state == "failed" and (check.first_wrong > 0 or check.wrong == 0)


def _pictures(check: Check, evidence: Evidence) -> Pictures:
    name = check.quantity
    ours, theirs = evidence.ours[name], evidence.theirs[name]
    ny, nx = evidence.ours.size
    factor = shrink_factor(nx, ny, FULL if deserves_full_size(check) else SMALL)
    scaled = has_scale(name)
    span = picture_span(name, ours, theirs)
    small = shrunk(ours, factor)
    return Pictures(
        ours=value_png(name, small, span),
        theirs=value_png(name, shrunk(theirs, factor), span),
        ratio=ratio_png(evidence.comparison.ratio[name], factor),
        width=small.shape[1],
        height=small.shape[0],
        factor=factor,
        low=float(span.low[0]) if scaled else None,
        high=float(span.high[0]) if scaled else None,
        clipped=span.clipped,
    )


def pixels_of(evidence: Evidence) -> tuple[Pixel, ...]:
    """The pixels of a scene that are explained: where any reference is wrong, or typical ones."""
    wrong: list[Pixel] = []
    for comparison in (evidence.companions or {"": evidence.comparison}).values():
        if (comparison.first_stage >= 0).any():
            first, ratios = comparison.first_stage, comparison.ratio
            wrong += [(each.column, each.row) for each in clusters_of(first, ratios)[:MOST_LISTED]]
            wrong += [(each.column, each.row) for each in worst_pixels(first, ratios)]
    return tuple(dict.fromkeys(wrong)) or typical_pixels(evidence.ours)


def typical_pixels(frame: Frame) -> tuple[Pixel, ...]:
    """A pixel in the middle of each of the objects that cover most of the image."""
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


def explanation_json(scene: Scene, column: int, row: int) -> str:
    """The steps and lines of a pixel, as JSON."""
    explanation = explain(scene, column, row)
    lines = [vars(line) for line in lines_of(scene, explanation)]
    return json.dumps({**explanation.to_dict(), "lines": lines}, allow_nan=False)


def _explanations(scene: Scene, pixels: Iterable[Pixel]) -> dict[Pixel, str]:
    """Explanations by pixel, as many as there is time for: deep trees of rays take long."""
    end = time.perf_counter() + TIME_LIMIT
    found: dict[Pixel, str] = {}
    for pixel in pixels:
        found[pixel] = _shared_explanation(scene, *pixel)
        if time.perf_counter() > end:
            break
    return found


#: References of one scene share its explanations.
_shared_explanation = lru_cache(maxsize=256)(explanation_json)
