"""`report.html`: everything in one file that opens without a server or a network."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from minirt.quantities import QUANTITIES, STAGES
from reference.compare.check import CERTAIN_FLOOR
from reference.compare.stability import KAPPA
from reference.verify.results import ReferenceResult
from reports.page.changes import changes_in_words, run_changes
from reports.page.colors import HATCH, RING, SOURCES, band_legend, css, viridis
from reports.page.data import Pool, has_pictures, page_data
from reports.page.matrix import anchor, in_causal_order, kind, stage_columns
from reports.page.scene import look_at, scene_entry
from reports.page.template import template
from reports.results.cells import SceneState
from reports.results.coverage import RuleCoverage, RuleState, gap_in_words
from reports.results.findings import SceneFindings
from reports.results.record import Run
from reports.results.words import RULE_NAMES, count, figure, icon, worst_in_words
from reports.speed import table
from reports.speed.plot import plot_of
from reports.speed.results import measured

#: The parts of the page's script, in the order in which they need each other.
_SCRIPT = (
    "dom", "state", "report", "arrays", "colors", "load", "stage", "overlays",
    "inspector", "clusters", "space", "controls", "filter",
)  # fmt: skip

#: Worst scenes first; scenes of the same state stay in the order in which they ran.
_ORDER: tuple[SceneState, ...] = ("failed", "incomplete", "passed", "not compared")

_RULE_ICONS: dict[RuleState, str] = {
    "failed": "✗", "passed": "✓", "partly checked": "◐", "not checked": "–", "no scene": "–",
}  # fmt: skip


def report_html(run: Run) -> str:
    """The page of a run."""
    pool = Pool()
    findings = run.findings
    changes = None if run.previous is None else run_changes(run.previous, run.results)
    changed = [] if changes is None else changes_in_words(changes)
    names = in_causal_order(findings.quantities)
    ordered = _ordered(findings.scenes)
    page = template("report.html.j2")
    scenes = [scene_entry(run, changes, place, scene, pool) for place, scene in ordered]
    sections = [(anchor(place, scene.result), scene.result) for place, scene in ordered]
    return page.render(
        run=run,
        names=names,
        stages=stage_columns(names),
        quantities=QUANTITIES,
        counts=findings.checks,
        scene_counts=findings.scene_states,
        not_checked=findings.not_checked,
        not_compared=findings.not_compared,
        gaps=[(gap, gap_in_words(gap)) for gap in findings.gaps],
        failing=_failing(run),
        unanswered=findings.unanswered,
        scenes=scenes,
        data=page_data(run, sections, pool),
        script=[f"scripts/{part}.js" for part in _SCRIPT],
        compared=any(has_pictures(a) for r in run.results for a in r.references),
        filters=_filters(compared_before=bool(changed)),
        changes=changed,
        stage_names=list(STAGES),
        rules=_rules(run),
        programs=findings.programs,
        bands=band_legend(),
        hatch=[css(color) for color in HATCH],
        ring=css(RING[0]),
        sources=[css(color) for color in SOURCES],
        viridis=[css(color) for color in viridis(16)],
        kappa=f"{KAPPA:g}",
        floor=f"{CERTAIN_FLOOR:.0%}",
        speed=None if run.judged else _speed(),
        pool=pool,
        count=count,
    )


def _failing(run: Run) -> list[dict[str, Any]]:
    """A line for each failing check, faults before what follows from them."""
    sections: dict[str, str] = {}
    answers: dict[tuple[str, str], ReferenceResult] = {}
    for k, result in enumerate(run.results, start=1):
        sections[result.scene.name] = anchor(k, result)
        answers |= {(result.scene.name, answer.reference): answer for answer in result.references}
    return [
        {
            "href": f"#{sections[cell.scene]}-{cell.check.quantity}",
            "scene": cell.scene,
            "reference": cell.reference,
            "quantity": cell.check.quantity,
            "kind": kind(cell.check),
            "what": f"{icon(cell.check)} {figure(cell.check)}",
            "detail": worst_in_words(cell.check) if cell.check.wrong else cell.check.reason,
            "look": look_at(sections[cell.scene], answers[cell.scene, cell.reference], cell.check),
        }
        for cell in run.findings.failing
    ]


def _ordered(scenes: Sequence[SceneFindings]) -> list[tuple[int, SceneFindings]]:
    """Scenes with their places in the run, worst first."""
    numbered = list(enumerate(scenes, start=1))
    return sorted(numbered, key=lambda entry: _ORDER.index(entry[1].state))


def _speed() -> dict[str, Any]:
    """What ships of `make bench`, which is not this run's."""
    speed = measured()
    return {
        "plot": plot_of(speed),
        "heading": table.heading(speed),
        "rows": table.rows(speed),
        "sentences": list(table.sentences(speed)),
        "origin": table.origin(speed),
        "versions": table.versions(speed),
    }


def _filters(compared_before: bool) -> list[tuple[str, str]]:
    """Tags that scenes can be filtered by, and what they say."""
    changes = [("new", "are new"), ("changed", "have changed")] if compared_before else []
    return [("failed", "did not pass"), *changes, ("uncertain", "have uncertain pixels")]


def _rules(run: Run) -> list[dict[str, Any]]:
    """A row for each rule: the scenes that list it, what was compared on how many of them."""
    covered = run.findings.rules
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
