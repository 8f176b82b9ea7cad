"""`report.html`: everything in one file that opens without a server or a network."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

from minirt.quantities import QUANTITIES
from reference.compare import CERTAIN_FLOOR, Check
from reference.exact import Judgement
from reference.quorum import Quorum
from reference.source import AlongRay, Declared, NormalOffset
from reference.stability import KAPPA
from reference.verify import ReferenceResult, SceneResult
from reports.colors import HATCH, RING, SOURCES, css, viridis
from reports.coverage import (
    RuleCoverage,
    RuleState,
    gap_in_words,
    gaps,
    not_checked,
    not_compared,
    rule_coverage,
)
from reports.digest import Agreement, Pictures, Seen, deserves_full
from reports.findings import (
    SceneState,
    answer_state,
    checks_of,
    counts,
    failing,
    first_wrong_stage,
    least_certain,
    scene_counts,
    scene_state,
    silent,
    worst_check,
)
from reports.judgement import MOST_LISTED, judgement_in_words, opinion_in_words
from reports.legends import bands, legend_of
from reports.page_cells import (
    CAUSAL,
    anchor,
    facts,
    kind,
    matrix_row,
    scene_headline,
    stage_columns,
)
from reports.page_data import Pool, page_data
from reports.page_template import template
from reports.pictures import has_scale
from reports.record import Run, programs
from reports.rule_names import RULE_NAMES
from reports.words import UNANSWERED, count, figure, icon, number, plain, worst_in_words

#: Pixels of a picture to each side of the worst one in its enlargement, and CSS pixels to each.
_AROUND, _ENLARGED = 7, 10
#: Least width, in CSS pixels, to which small pictures are enlarged, by a whole number.
_LEAST_WIDTH = 128

#: The parts of the page's script, in the order in which they need each other.
_SCRIPT = (
    "dom", "state", "report", "arrays", "colors", "load", "stage", "overlays", "steps",
    "inspector", "clusters", "space", "controls", "filter", "start",
)  # fmt: skip

#: Worst scenes first; scenes of the same state stay in the order in which they ran.
_ORDER: tuple[SceneState, ...] = ("failed", "incomplete", "passed", "not compared")

_RULE_ICONS: dict[RuleState, str] = {
    "failed": "✗", "passed": "✓", "partly checked": "◐", "not checked": "–", "no scene": "–",
}  # fmt: skip


def report_html(run: Run) -> str:
    """The page of a run."""
    pool = Pool()
    ordered = _ordered(run.results)
    page = template("report.html.j2")
    scenes = [_scene(run, number, result, pool) for number, result in ordered]
    sections = [(anchor(number, result), result) for number, result in ordered]
    return page.render(
        run=run,
        names=_names(run),
        stages=stage_columns(_names(run)),
        quantities=QUANTITIES,
        counts=counts(run.results),
        scene_counts=scene_counts(run.results),
        not_checked=not_checked(run.results),
        not_compared=not_compared(run.results),
        gaps=[(gap, gap_in_words(gap)) for gap in gaps(run.results)],
        failing=_failing(run),
        silent=silent(run.results),
        scenes=scenes,
        data=page_data(run, sections, pool),
        script=[f"{part}.js" for part in _SCRIPT],
        compared=any(isinstance(a.digest, Seen) for r in run.results for a in r.references),
        filters=[("failed", "did not pass"), ("uncertain", "have uncertain pixels")],
        rules=_rules(run),
        programs=programs(run),
        bands=bands(),
        hatch=[css(color) for color in HATCH],
        ring=css(RING[0]),
        sources=[css(color) for color in SOURCES],
        viridis=[css(color) for color in viridis(16)],
        kappa=f"{KAPPA:g}",
        floor=f"{CERTAIN_FLOOR:.0%}",
        pool=pool,
        count=count,
    )


def _names(run: Run) -> list[str]:
    """The quantities that the run compared, in causal order."""
    used = {check.quantity for check in checks_of(run.results)}
    return [name for name in CAUSAL if name in used]


def _failing(run: Run) -> list[dict[str, Any]]:
    """A line for each failing check, faults before what follows from them."""
    anchors = {id(result): anchor(k, result) for k, result in enumerate(run.results, start=1)}
    return [
        {
            "href": f"#{anchors[id(result)]}-{check.quantity}",
            "scene": result.scene.name,
            "reference": answer.reference,
            "quantity": check.quantity,
            "kind": kind(check),
            "what": f"{icon(check)} {figure(check)}",
            "detail": worst_in_words(check) if check.wrong else check.reason,
            "look": _look(anchors[id(result)], answer, check),
        }
        for result, answer, check in failing(run.results)
    ]


def _look(section: str, answer: ReferenceResult, check: Check) -> str:
    """What the stage is to show of a check, as JSON; empty where it has nothing to show."""
    if not (isinstance(answer.digest, Seen) and check.quantity in answer.digest.pictures):
        return ""
    return json.dumps([section, plain(answer.reference), check.quantity])


def _ordered(results: Sequence[SceneResult]) -> list[tuple[int, SceneResult]]:
    numbered = list(enumerate(results, start=1))
    return sorted(numbered, key=lambda entry: _ORDER.index(scene_state(entry[1])))


def _scene(run: Run, number_: int, result: SceneResult, pool: Pool) -> dict[str, Any]:
    """What the template needs to know of one scene."""
    section = anchor(number_, result)
    names = _names(run)
    stage = first_wrong_stage(checks_of([result]))
    return {
        "id": section,
        "scene": result.scene,
        "state": scene_state(result),
        "headline": scene_headline(result) + (f"; first wrong stage: {stage}" if stage else ""),
        "rows": [matrix_row(answer, names, section) for answer in result.references],
        "tags": " ".join(tags_of(result)),
        "worst": _worst(result),
        "certain": _certain(result),
        "search": " ".join([result.scene.name, *result.scene.rules, result.scene.about]).lower(),
        "portrait": _portrait(run, number_, pool),
        "answers": [_answer(answer) for answer in result.references],
        "quantities": _quantities(result, section, pool),
        "silent": _not_compared(result),
        "judgement": result.judgement and _judgement(result.judgement),
        "quorum": [(q, _agreement(q, pool)) for q in result.quorum if q.sources],
        "sources": max((len(q.sources) for q in result.quorum), default=0),
        "seconds": result.seconds,
        "memory": result.peak_memory / 2**20,
    }


def tags_of(result: SceneResult) -> list[str]:
    """By what a scene can be filtered."""
    checks = list(checks_of([result]))
    found = ["failed"] if scene_state(result) in ("failed", "incomplete") else []
    return [*found, *(["uncertain"] if any(c.certain < c.pixels for c in checks) else [])]


def _worst(result: SceneResult) -> str:
    """The worst error over tolerance as JavaScript reads it; −1 where nothing was compared."""
    worst = worst_check(checks_of([result]))
    ratio = -1.0 if worst is None else worst.ratio or 0.0
    return "Infinity" if math.isinf(ratio) else f"{ratio:.6g}"


def _certain(result: SceneResult) -> str:
    """The least share of certain pixels; 2 where nothing was compared."""
    least = least_certain(checks_of([result]))
    return "2" if least is None else f"{least.certain / least.pixels:.6f}"


def _portrait(run: Run, number_: int, pool: Pool) -> tuple[str, int, str] | None:
    """Class, width and proportions of minirt's own picture of scene number `number_`, from 1."""
    portrait = run.portraits[number_ - 1] if run.portraits else None
    if portrait is None:
        return None
    return pool.name(portrait.png), portrait.width, f"{portrait.width} / {portrait.height}"


def _agreement(quorum: Quorum, pool: Pool) -> tuple[str, int, str] | None:
    """Class, width and proportions of the map of who agrees; None where it was not drawn."""
    drawn = quorum.drawn
    if not isinstance(drawn, Agreement):
        return None
    return pool.name(drawn.png), drawn.width, f"{drawn.width} / {drawn.height}"


def _judgement(judgement: Judgement) -> dict[str, Any]:
    """What the template needs to know of minirt before the judge."""
    return {
        "words": judgement_in_words(judgement),
        "convictions": [opinion_in_words(each) for each in judgement.convictions[:MOST_LISTED]],
        "counts": [
            (each, "" if each.ulps is None else number(each.ulps))
            for each in judgement.counts
            if each.judged
        ],
    }


def _answer(answer: ReferenceResult) -> dict[str, Any]:
    state = answer_state(answer)
    declared = answer.declared
    return {
        "name": answer.reference,
        "program": answer.program,
        "state": state,
        "silent": state in UNANSWERED,
        "reason": answer.checks[0].reason if state in UNANSWERED else "",
        "output": answer.output.strip(),
        "diagnosis": "" if answer.diagnosis is None else _diagnosis(answer),
        "seconds": answer.seconds,
        "declared": declared,
        "errors": [] if declared is None else _errors(declared),
    }


def _diagnosis(answer: ReferenceResult) -> str:
    named = [each.sentence for each in answer.diagnosis or ()]
    return "; or it ".join(named) or "none of the known mistakes explains it"


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
            _entry(section, answer, check, pool)
            for answer in result.references
            for check in answer.checks
            if check.quantity == name and answer.digest and name in answer.digest.pictures
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


def _entry(section: str, answer: ReferenceResult, check: Check, pool: Pool) -> dict[str, Any]:
    pictures: Pictures = answer.digest.pictures[check.quantity]
    kinds = ("failed", "follows", "known", "passed", "empty")
    shown = ((answer.reference, pictures.theirs), ("error ÷ tolerance", pictures.ratio))
    return {
        "reference": answer.reference,
        "look": _look(section, answer, check),
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
        "zoom": _zoom(check, pictures) if deserves_full(check) and check.wrong else None,
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


def _not_compared(result: SceneResult) -> list[tuple[str, str, str, str]]:
    """Quantities that were not compared: their names by reference, state and reason."""
    found: dict[tuple[str, str, str], list[str]] = {}
    for answer in result.references:
        for check in answer.checks:
            if check.state in ("not given", "not supported"):
                key = (answer.reference, check.state, check.reason)
                found.setdefault(key, []).append(check.quantity)
    return [(*key, ", ".join(names)) for key, names in found.items()]


def _rules(run: Run) -> list[dict[str, Any]]:
    """A row for each rule: the scenes that list it, what was compared on how many of them."""
    covered = rule_coverage(run.results)
    return [_rule(run, rule, name, covered.get(rule)) for rule, name in RULE_NAMES.items()]


def _rule(run: Run, rule: str, name: str, covered: RuleCoverage | None) -> dict[str, Any]:
    """One row; a rule that no quantity judges says so."""
    scenes = [(k, r) for k, r in enumerate(run.results, start=1) if rule in r.scene.rules]
    failed = covered.failed if covered else ()
    return {
        "rule": rule,
        "name": name,
        "scenes": [(anchor(k, r), r.scene.name, r.scene.name in failed) for k, r in scenes],
        "quantities": list(covered.trace.checked.items()) if covered else [],
        "compared": list(covered.trace.compared.items()) if covered else [],
        "passed": covered.passed if covered else 0,
        "state": covered.state if covered else "documented; unit tests",
        "icon": _RULE_ICONS[covered.state] if covered else "–",
    }
