"""What the page's script works on: one JSON document, and arrays in base64 beside it."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from minirt.quantities import QUANTITIES, STAGES
from reference.verify.results import ReferenceResult, SceneResult
from reports.explain.second_opinion import Row, SecondOpinion
from reports.explain.space import surroundings
from reports.page.colors import (
    BANDS,
    BOUNDS,
    CATEGORIES,
    DIVERGING,
    HATCH,
    MASKS,
    NOTHING,
    RING,
    STAGE_COLORS,
    css,
    legend_of,
    viridis,
)
from reports.page.inspector.arrays import PackedArrays, arrays_within
from reports.page.inspector.details import Details, Pictures, Pixel
from reports.page.inspector.packing import Packed
from reports.page.matrix import CAUSAL
from reports.page.rerun import ready_test, rerun_command
from reports.results.cells import answer_state, scene_state
from reports.results.json_model import spelled
from reports.results.record import Run
from reports.results.words import RULE_NAMES, figure, plain

Arrays = dict[str, PackedArrays]


@dataclass
class Pool:
    """Pictures and arrays of a page, each stored once however often it is used.

    Attributes
    ----------
    pictures, blobs : dict of bytes to str
        Their names.
    """

    pictures: dict[bytes, str] = field(default_factory=dict)
    blobs: dict[bytes, str] = field(default_factory=dict)

    def name(self, png: bytes) -> str:
        """The CSS class that shows a picture."""
        return self.pictures.setdefault(png, f"p{len(self.pictures)}")

    def blob(self, data: bytes) -> str:
        """The element that holds some bytes."""
        return self.blobs.setdefault(data, f"b{len(self.blobs)}")

    def rules(self) -> Iterator[tuple[str, str]]:
        """CSS classes with their pictures as base64."""
        return ((name, base64.b64encode(png).decode()) for png, name in self.pictures.items())

    def texts(self) -> Iterator[tuple[str, str]]:
        """Elements with their bytes as base64."""
        return ((name, base64.b64encode(data).decode()) for data, name in self.blobs.items())


def page_data(run: Run, ordered: Iterable[tuple[str, SceneResult]], pool: Pool) -> str:
    """The document, fit to stand inside a script element.

    Parameters
    ----------
    run : Run
    ordered : iterable of (str, SceneResult)
        Scenes with the names of their sections, in the page's order.
    pool : Pool
        Arrays are put into it.
    """
    given = [(section, result, _answers(result)) for section, result in ordered]
    arrays = iter(arrays_within([a.details for _, _, answers in given for a in answers]))
    scenes = [
        _scene(run, section, result, [(a, next(arrays)) for a in answers], pool)
        for section, result, answers in given
    ]
    return inside_script({**_constants(), "scenes": scenes})


def has_pictures(answer: ReferenceResult) -> bool:
    """Whether there is anything of a reference to look at."""
    return isinstance(answer.details, Details) and bool(answer.details.pictures)


def inside_script(document: Any) -> str:
    """JSON that no browser takes for the end of a script element or for a comment."""
    return json.dumps(_plain(document), allow_nan=False, separators=(",", ":")).replace(
        "<", "\\u003c"
    )


def _constants() -> dict[str, Any]:
    """Quantities, stages, rules and colours, for the script."""
    return {
        "quantities": {
            name: {
                "discrete": q.discrete,
                "components": q.components,
                "kind": q.kind,
                "stage": q.stage,
                "rule": q.rules[0],
                "type": {"bool": "bool", "float64": "float"}.get(q.dtype, "int"),
                "mask": [css(color) for color in MASKS[name]] if name in MASKS else None,
                "legend": legend_of(name),
            }
            for name, q in ((name, QUANTITIES[name]) for name in CAUSAL)
        },
        "stages": list(STAGES),
        "stageColors": [css(color) for color in STAGE_COLORS],
        "rules": RULE_NAMES,
        "bands": [css(color) for color in BANDS],
        "bounds": list(BOUNDS),
        "hatch": [css(color) for color in HATCH],
        "diverging": [css(color) for color in DIVERGING],
        "ring": css(RING[0]),
        "nothing": css(NOTHING),
        "categories": [css(color) for color in CATEGORIES],
        "viridis": [css(color) for color in viridis(64)],
    }


def _plain(value: Any) -> Any:
    """JSON data whose texts and numbers every browser shows."""
    if isinstance(value, str):
        return plain(value)
    if isinstance(value, dict):
        return {plain(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return spelled(value)


def _answers(result: SceneResult) -> list[ReferenceResult]:
    return [answer for answer in result.references if has_pictures(answer)]


def _scene(
    run: Run, section: str, result: SceneResult, seen: list[tuple[ReferenceResult, Arrays]],
    pool: Pool,
) -> dict[str, Any]:  # fmt: skip
    scene = result.scene
    explanations: dict[Pixel, str] = {}
    for answer, _ in seen:
        explanations |= answer.details.explanations
    return {
        "id": section,
        "name": scene.name,
        "state": scene_state(result),
        "nx": scene.screen.nx,
        "ny": scene.screen.ny,
        "command": rerun_command(run, scene),
        "objects": [thing.name for thing in scene.objects],
        "pixels": [list(pixel) for pixel in explanations],
        "more": pool.blob(_more(result, [answer for answer, _ in seen], explanations)),
        "references": [_reference(run, result, a, arrays, pool) for a, arrays in seen],
    }


def _more(
    result: SceneResult, answers: list[ReferenceResult], explanations: dict[Pixel, str]
) -> bytes:
    """What is read when a pixel of the scene is looked at: JSON, deflated."""
    document = {
        "space": surroundings(result.scene),
        "explanations": {_key(pixel): json.loads(text) for pixel, text in explanations.items()},
        "rows": {
            answer.reference: {
                _key(pixel): _opinion(answer, rows) for pixel, rows in answer.details.rows.items()
            }
            for answer in answers
        },
    }
    return zlib.compress(json.dumps(_plain(document), allow_nan=False).encode(), 9)


def _opinion(answer: ReferenceResult, rows: tuple[Row, ...]) -> dict[str, Any]:
    """The values of both at a pixel, and the sentence about them."""
    return {
        "sentence": SecondOpinion(answer.reference, rows).sentence,
        "rows": {
            row.quantity: [row.ours, row.theirs, row.tolerance, row.ratio, row.error]
            for row in rows
        },
    }


def _key(pixel: Pixel) -> str:
    return f"{pixel[0]},{pixel[1]}"


def _reference(
    run: Run, result: SceneResult, answer: ReferenceResult, arrays: Arrays, pool: Pool
) -> dict[str, Any]:
    details: Details = answer.details
    checks = {check.quantity: check for check in answer.checks}
    return {
        "name": answer.reference,
        "state": answer_state(answer),
        "test": ready_test(run, result.scene, answer.reference),
        "quantities": {
            name: {
                "state": checks[name].state,
                "wrong": checks[name].wrong,
                "figure": figure(checks[name]),
                "histogram": vars(details.histograms[name]),
                "picture": _picture(pictures, pool),
                "arrays": _arrays(arrays[name], pool) if name in arrays else None,
            }
            for name, pictures in sorted(
                details.pictures.items(), key=lambda item: CAUSAL.index(item[0])
            )
        },
        "full": bool(arrays),
        "first": _packed(details.first_stage, pool) if details.first_stage and arrays else None,
        "clusters": [vars(cluster) for cluster in details.clusters],
        "clusterCount": details.cluster_count,
        "worst": [vars(each) for each in details.worst],
    }


def _picture(pictures: Pictures, pool: Pool) -> dict[str, Any]:
    return {
        "ours": pool.name(pictures.ours),
        "theirs": pool.name(pictures.theirs),
        "ratio": pool.name(pictures.ratio),
        "factor": pictures.factor,
        "low": pictures.low,
        "high": pictures.high,
        "clipped": pictures.clipped,
    }


def _arrays(arrays: PackedArrays, pool: Pool) -> dict[str, Any]:
    return {
        "ours": _packed(arrays.ours, pool),
        "theirs": _packed(arrays.theirs, pool),
        "ratio": _packed(arrays.ratio, pool),
        "tolerance": None if arrays.tolerance is None else _packed(arrays.tolerance, pool),
        "low": arrays.span.low.tolist(),
        "high": arrays.span.high.tolist(),
    }


def _packed(packed: Packed, pool: Pool) -> dict[str, Any]:
    return {
        "kind": packed.kind,
        "components": packed.components,
        "exact": packed.exact,
        "predictors": packed.predictors,
        "blob": pool.blob(packed.data),
    }
