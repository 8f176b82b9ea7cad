"""What a run has not checked, and why; and what it has, rule by rule."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from minirt.quantities import QUANTITIES
from reference.compare.check import COMPARED
from reference.traceability import RuleTrace, passed_in, trace_rules, without_camera
from reference.verify.results import SceneResult
from reports.results.cells import cells_of, scene_state
from reports.results.words import count, one_line

RuleState = Literal["failed", "partly checked", "not checked", "passed", "no scene"]

#: Names in a reason, which differ from scene to scene.
_NAMES = re.compile(r"(?<= )'[^']*'(, '[^']*')*")


@dataclass(frozen=True)
class Gap:
    """Checks that one reference does not make, for the same reason.

    Attributes
    ----------
    reference, reason : str
        Names of materials in it are left out.
    quantities : tuple of str
    scenes, checks : int
        Of a run; a check that has two reasons counts for both.
    """

    reference: str
    reason: str
    quantities: tuple[str, ...]
    scenes: int
    checks: int


@dataclass(frozen=True)
class RuleCoverage:
    """One rule in a run.

    Attributes
    ----------
    trace : RuleTrace
    passed : int
        Scenes that list it where one of its quantities at least was compared, and none failed.
    failed : tuple of str
        Names of those where one failed.
    state : str
        passed: nothing failed, and each of its quantities was compared on one of them at least.
    """

    trace: RuleTrace
    passed: int
    failed: tuple[str, ...]
    state: RuleState


def rule_coverage(results: Sequence[SceneResult]) -> dict[str, RuleCoverage]:
    """Every rule of a run: what it was compared in, and how that ended."""
    traced = trace_rules([r.scene for r in results], passed_in(results))
    return {row.rule: _coverage(row, results) for row in traced}


def _coverage(row: RuleTrace, results: Sequence[SceneResult]) -> RuleCoverage:
    listing = [r for r in results if row.rule in r.scene.rules]
    ended = [_rule_in_scene(row, result) for result in listing]
    failed = tuple(
        result.scene.name for result, state in zip(listing, ended, strict=True) if state == "failed"
    )
    state: RuleState = "passed"
    if failed:
        state = "failed"
    elif not listing:
        state = "no scene"
    elif not any(row.checked.values()):
        state = "not checked"
    elif not all(row.checked.values()):
        state = "partly checked"
    return RuleCoverage(row, ended.count("passed"), failed, state)


def _rule_in_scene(row: RuleTrace, result: SceneResult) -> str:
    checks = [
        check
        for answer in result.references
        for check in answer.checks
        if check.quantity in row.quantities and not without_camera(row.rule, answer.reference)
    ]
    convictions = result.judgement.convictions if result.judgement else ()
    convicted = {each.quantity for each in convictions}.intersection(row.quantities)
    if convicted or any(c.state == "failed" for c in checks):
        return "failed"
    return "passed" if any(c.state == "passed" and c.compared for c in checks) else "not checked"


def not_checked(results: Sequence[SceneResult]) -> str:
    """Quantities that no reference compared, everywhere or somewhere; empty where there is none.

    Scenes on which nothing at all was compared are not counted: `not_compared` names them.
    """
    some = [r for r in results if scene_state(r) != "not compared"]
    used = {cell.check.quantity for cell in cells_of(results)}
    open_: dict[int, list[str]] = {}
    for name in (n for n in QUANTITIES if n in used):
        left = sum(not _was_compared(name, result) for result in some)
        if left:
            open_.setdefault(left, []).append(name)
    worst_first = sorted(open_.items(), reverse=True)
    return "; ".join(f"{', '.join(names)} on {_of(left, len(some))}" for left, names in worst_first)


def _of(some: int, all_: int) -> str:
    if some < all_:
        return f"{some} of {count(all_, 'scene')}"
    return f"all {all_} scenes" if all_ > 1 else "the scene"


def _was_compared(name: str, result: SceneResult) -> bool:
    checks = (check for answer in result.references for check in answer.checks)
    return any(check.quantity == name and check.state in COMPARED for check in checks)


def not_compared(results: Sequence[SceneResult]) -> list[str]:
    """Scenes on which no reference compared anything, each reason in a line with its scenes."""
    found: dict[str, list[str]] = {}
    for result in results:
        if scene_state(result) == "not compared":
            found.setdefault(why_not(result), []).append(one_line(result.scene.name, 60))
    return [f"{', '.join(names)}: {why}" for why, names in found.items()]


def why_not(result: SceneResult) -> str:
    """Why nothing was compared on a scene, with the references that say so."""
    found: dict[str, list[str]] = {}
    for answer in result.references:
        for check in answer.checks[:1]:
            found.setdefault(one_line(check.reason, 160), []).append(answer.reference)
    parts = (f"{reason} ({', '.join(names)})" for reason, names in found.items())
    return "; ".join(parts) or "no reference was chosen"


def gaps(results: Sequence[SceneResult]) -> list[Gap]:
    """What references did not give of scenes, by reference and reason; the most frequent first.

    Scenes on which nothing at all was compared are not counted: `not_compared` names them.
    """
    found: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for result in (r for r in results if scene_state(r) != "not compared"):
        for answer in result.references:
            for check in answer.checks:
                if check.state in ("not supported", "not given"):
                    for reason in check.reason.split("; "):
                        key = (answer.reference, _NAMES.sub("…", one_line(reason)))
                        found.setdefault(key, []).append((result.scene.sha256, check.quantity))
    made = [
        Gap(
            *key,
            tuple(name for name in QUANTITIES if name in {q for _, q in cells}),
            len({scene for scene, _ in cells}),
            len(cells),
        )
        for key, cells in found.items()
    ]
    return sorted(made, key=lambda gap: -gap.checks)


def gap_in_words(gap: Gap) -> str:
    """What is missing: alpha on 39 scenes; 8 quantities on 39 scenes."""
    many = len(gap.quantities) > 3
    what = count(len(gap.quantities), "quantity", "quantities") if many else ""
    return f"{what or ', '.join(gap.quantities)} on {count(gap.scenes, 'scene')}"
