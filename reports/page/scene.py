"""What the page shows of one scene: its matrix rows, its pictures, declared errors."""

from __future__ import annotations

import json
import math
from typing import Any

from minirt.quantities import QUANTITIES
from reference.compare.check import UNANSWERED, Check
from reference.compare.quorum import Quorum
from reference.exact import Judgement
from reference.source import AlongRay, Declared, NormalOffset
from reference.verify.results import ReferenceResult, SceneResult
from reports.page.changes import RunChanges, change_tags, trend_of, with_arrow
from reports.page.colors import legend_of
from reports.page.data import Pool
from reports.page.inspector.details import Details, Pictures, deserves_full_size
from reports.page.matrix import (
    CAUSAL,
    MatrixRow,
    anchor,
    facts,
    in_causal_order,
    kind,
    matrix_row,
    scene_headline,
)
from reports.page.pictures import has_scale
from reports.page.thumbnails import Thumbnail
from reports.results.findings import AnswerFindings, SceneFindings
from reports.results.record import Run
from reports.results.schema import MOST_LISTED
from reports.results.words import (
    count,
    figure,
    icon,
    judgement_in_words,
    number,
    opinion_in_words,
    plain,
)

#: Pixels of a picture to each side of the worst one in its enlargement, and CSS pixels to each.
_AROUND, _ENLARGED = 7, 10
#: Least width, in CSS pixels, to which small pictures are enlarged, by a whole number.
_LEAST_WIDTH = 128


def look_at(section: str, answer: ReferenceResult, check: Check) -> str:
    """What the stage is to show of a check, as JSON; empty where it has nothing to show."""
    if not (isinstance(answer.details, Details) and check.quantity in answer.details.pictures):
        return ""
    return json.dumps([section, plain(answer.reference), check.quantity])


def scene_entry(
    run: Run, changes: RunChanges | None, place: int, scene: SceneFindings, pool: Pool
) -> dict[str, Any]:
    """What the template needs to know of one scene.

    Parameters
    ----------
    run : Run
    changes : RunChanges or None
        Since the previous run.
    place : int
        Of the scene in the run, from 1.
    scene : SceneFindings
    pool : Pool
        Pictures are put into it.
    """
    result = scene.result
    section = anchor(place, result)
    names = in_causal_order(run.findings.quantities)
    tags = [] if changes is None else change_tags(changes, result.scene.name)
    return {
        "id": section,
        "scene": result.scene,
        "state": scene.state,
        "headline": scene_headline(scene),
        "rows": [_row(run, result, answer, names, section) for answer in result.references],
        "trend": run.previous and trend_of(run.previous, scene, run.provenance.commit),
        "tags": " ".join([*_tags(scene), *tags]),
        "worst": _worst(scene),
        "certain": _certain(scene),
        "search": " ".join([result.scene.name, *result.scene.rules, result.scene.about]).lower(),
        "thumbnail": _thumbnail(result, pool),
        "answers": [_answer(answer) for answer in scene.answers],
        "quantities": _quantities(result, section, pool),
        "gaps": _gaps(result),
        "judgement": result.judgement and _judgement(result.judgement),
        "quorum": [(q, _agreement(q, pool)) for q in result.quorum if len(q.sources) > 1],
        "sources": max((len(q.sources) for q in result.quorum), default=0),
        "seconds": result.seconds,
        "memory": result.peak_memory / 2**20,
    }


def _row(
    run: Run, result: SceneResult, answer: ReferenceResult, names: list[str], section: str
) -> MatrixRow:
    """A row of the matrix, with arrows where cells have changed."""
    row = matrix_row(answer, names, section)
    if run.previous is None or len(row.cells) != len(names):
        return row
    checks = {check.quantity: check for check in answer.checks}
    cells = (
        with_arrow(
            cell, checks[name], run.previous.cells.get((result.scene.name, answer.reference, name))
        )
        for name, cell in zip(names, row.cells, strict=True)
    )
    return MatrixRow(row.reference, tuple(cells))


def _tags(scene: SceneFindings) -> list[str]:
    """By what a scene can be filtered."""
    found = ["failed"] if scene.state in ("failed", "incomplete") else []
    uncertain = any(check.certain < check.pixels for check in scene.checks)
    return [*found, *(["uncertain"] if uncertain else [])]


def _worst(scene: SceneFindings) -> str:
    """The worst error over tolerance as JavaScript reads it; −1 where nothing was compared."""
    ratio = -1.0 if scene.worst is None else scene.worst.ratio or 0.0
    return "Infinity" if math.isinf(ratio) else f"{ratio:.6g}"


def _certain(scene: SceneFindings) -> str:
    """The least share of certain pixels; 2 where nothing was compared."""
    least = scene.least_certain
    return "2" if least is None else f"{least.certain / least.pixels:.6f}"


def _thumbnail(result: SceneResult, pool: Pool) -> tuple[str, int, str] | None:
    """Class, width and proportions of minirt's own picture of a scene."""
    thumbnail = result.thumbnail
    if thumbnail is None:
        return None
    return pool.name(thumbnail.png), thumbnail.width, f"{thumbnail.width} / {thumbnail.height}"


def _agreement(quorum: Quorum, pool: Pool) -> tuple[str, int, str] | None:
    """Class, width and proportions of the map of who agrees; None where it was not drawn."""
    drawn = quorum.drawn
    if not isinstance(drawn, Thumbnail):
        return None
    return pool.name(drawn.png), drawn.width, f"{drawn.width} / {drawn.height}"


def _judgement(judgement: Judgement) -> dict[str, Any]:
    """What the template needs to know of minirt against exact arithmetic."""
    return {
        "words": judgement_in_words(judgement),
        "convictions": [opinion_in_words(each) for each in judgement.convictions[:MOST_LISTED]],
        "counts": [
            (each, "" if each.ulps is None else number(each.ulps))
            for each in judgement.counts
            if each.judged
        ],
    }


def _answer(found: AnswerFindings) -> dict[str, Any]:
    answer, state = found.answer, found.state
    declared = answer.declared
    return {
        "name": answer.reference,
        "program": answer.program,
        "state": state,
        "unanswered": state in UNANSWERED,
        "reason": answer.checks[0].reason if state in UNANSWERED else "",
        "output": answer.output.strip(),
        "diagnosis": "" if answer.diagnosis is None else _diagnosis(answer),
        "seconds": answer.seconds,
        "declared": declared,
        "errors": [] if declared is None else _errors(declared),
    }


def _diagnosis(answer: ReferenceResult) -> str:
    named = [each.sentence for each in answer.diagnosis or ()]
    if not named:
        return f"none of the known mistakes explains what {answer.reference} gives"
    return f"{answer.reference} {'; or it '.join(named)}"


def _errors(declared: Declared) -> list[tuple[str, str]]:
    """A reference's declared error, name by value."""
    return [
        ("δ", number(declared.delta)),
        *([("per distance", number(declared.slope))] if declared.slope else []),
        *([("steps of depth", f"{number(declared.grain)} of it")] if declared.grain else []),
        ("vertices", number(declared.vertex)),
        ("unit vectors", number(declared.angle)),
        ("colour", number(declared.color) if declared.color else "gives none"),
        *((f"steps of {name}", number(step)) for name, step in declared.steps),
        ("secondary rays start", _start(declared.start)),
    ]


def _start(start: NormalOffset | AlongRay | None) -> str:
    if start is None:
        return "as minirt's, at ε"
    if isinstance(start, AlongRay):
        return f"on the surface, at {number(start.length)} along the ray"
    return f"off the surface, {number(start.factor)}·(1 + max|p|) along the normal"


def _quantities(result: SceneResult, section: str, pool: Pool) -> list[dict[str, Any]]:
    """The quantities of which there are pictures, failing ones first, faults before the rest."""
    shown = []
    for name in CAUSAL:
        entries = [
            _entry(answer, check, pool)
            for answer in result.references
            for check in answer.checks
            if check.quantity == name and answer.details and name in answer.details.pictures
        ]
        if entries:
            rank = min(entry["rank"] for entry in entries)
            shown.append(
                {
                    "id": f"{section}-{name}",
                    "quantity": QUANTITIES[name],
                    "entries": sorted(entries, key=lambda entry: entry["rank"]),
                    "rank": rank,
                    "legend": legend_of(name),
                }
            )
    return sorted(shown, key=lambda entry: entry["rank"])


def _entry(answer: ReferenceResult, check: Check, pool: Pool) -> dict[str, Any]:
    pictures: Pictures = answer.details.pictures[check.quantity]
    kinds = ("failed", "follows", "known", "passed", "empty")
    shown = ((answer.reference, pictures.theirs), ("error ÷ tolerance", pictures.ratio))
    return {
        "reference": answer.reference,
        "kind": kind(check),
        "rank": kinds.index(kind(check)),
        "icon": icon(check),
        "figure": figure(check),
        "state": check.state,
        "facts": facts(check),
        "pictures": [
            (caption, pool.name(png), _alternative(caption, check))
            for caption, png in (("minirt", pictures.ours), *shown)
        ],
        "width": pictures.width * max(1, _LEAST_WIDTH // pictures.width),
        "ratio": f"{pictures.width} / {pictures.height}",
        "scale": _scale(pictures) if has_scale(check.quantity) else None,
        "zoom": _zoom(check, pictures) if deserves_full_size(check) and check.wrong else None,
    }


def _alternative(caption: str, check: Check) -> str:
    if caption == "error ÷ tolerance" and check.wrong and check.worst:
        at = f"({check.worst.column}, {check.worst.row})"
        return f"{check.quantity}: {count(check.wrong, 'wrong pixel')}, the worst at {at}"
    return f"{check.quantity}, {caption}"


def _scale(pictures: Pictures) -> tuple[str, str]:
    low, high = number(pictures.low or 0.0), number(pictures.high or 0.0)
    return low, f"≥ {high}" if pictures.clipped else high


def _zoom(check: Check, pictures: Pictures) -> dict[str, Any] | None:
    """How CSS enlarges the surroundings of the worst pixel, without a second picture."""
    if check.worst is None:
        return None
    column, row = (value // pictures.factor for value in (check.worst.column, check.worst.row))
    return {
        "at": f"({check.worst.column}, {check.worst.row})",
        "side": (2 * _AROUND + 1) * _ENLARGED,
        "size": f"{pictures.width * _ENLARGED}px {pictures.height * _ENLARGED}px",
        "position": f"{(_AROUND - column) * _ENLARGED}px {(_AROUND - row) * _ENLARGED}px",
        "pixels": 2 * _AROUND + 1,
    }


def _gaps(result: SceneResult) -> list[tuple[str, str, str, str]]:
    """Quantities that were not compared: their names by reference, state and reason."""
    found: dict[tuple[str, str, str], list[str]] = {}
    for answer in result.references:
        for check in answer.checks:
            if check.state in ("not given", "not supported"):
                key = (answer.reference, check.state, check.reason)
                found.setdefault(key, []).append(check.quantity)
    return [(*key, ", ".join(names)) for key, names in found.items()]
