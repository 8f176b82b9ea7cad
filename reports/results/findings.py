"""Questions to a run's results that several reports ask."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

from reference.compare.check import COMPARED, UNANSWERED, Check, State
from reference.verify.results import ReferenceResult, SceneResult
from reports.results.cells import Cell, cells_of, first_wrong_stage, least_certain, worst_check
from reports.results.words import STATES, is_consequence, share, times

SceneState = Literal["failed", "incomplete", "passed", "not compared"]


def scene_state(result: SceneResult) -> SceneState:
    """How one scene ended over all its references, and before the judge."""
    states = {check.state for check in checks_of([result])}
    if "failed" in states or (result.judgement is not None and result.judgement.convictions):
        return "failed"
    if states & {"crashed", "timed out"}:
        return "incomplete"
    return "passed" if states & {"passed", "known"} else "not compared"


def checks_of(results: Iterable[SceneResult]) -> Iterator[Check]:
    """Every check of every scene and reference."""
    for result in results:
        for answer in result.references:
            yield from answer.checks


def counts(results: Iterable[SceneResult]) -> dict[State, int]:
    """Number of checks in each state."""
    found = [check.state for check in checks_of(results)]
    return {state: found.count(state) for state in STATES}


def scene_counts(results: Iterable[SceneResult]) -> dict[SceneState, int]:
    """Number of scenes in each state."""
    found = [scene_state(result) for result in results]
    states: tuple[SceneState, ...] = ("failed", "incomplete", "passed", "not compared")
    return {state: found.count(state) for state in states}


def answer_state(answer: ReferenceResult) -> State:
    """How one reference did on one scene: its worst news."""
    found = {check.state for check in answer.checks}
    return next((state for state in STATES if state in found), "not given")


def failing(results: Iterable[SceneResult]) -> Iterator[Cell]:
    """Every cell that failed, faults before what only follows from them."""
    cells = [cell for cell in cells_of(results) if cell.check.state == "failed"]
    yield from sorted(cells, key=lambda cell: is_consequence(cell.check))


def diagnosed(results: Iterable[SceneResult]) -> Iterator[tuple[SceneResult, ReferenceResult, str]]:
    """What explains each failure that a diagnosis was asked for, best first, in a clause."""
    for result in results:
        for answer in result.references:
            if answer.diagnosis is not None:
                named = [each.sentence for each in answer.diagnosis]
                none = "none of the known mistakes explains it"
                yield result, answer, "; or ".join(named[:1]) or none


def likeliest(results: Iterable[SceneResult]) -> str:
    """The mistake that explains most failures, in a clause; empty where none was looked for."""
    found = [answer.diagnosis for _, answer, _ in diagnosed(results)]
    first = [named[0] for named in found if named]
    if not first:
        return "none of the known mistakes explains it" if found else ""
    most = max(first, key=lambda each: sum(other.name == each.name for other in first))
    number = sum(other.name == most.name for other in first)
    if 2 * number < len(found):
        return "no one mistake explains most of it"
    where = f" ({number} of {len(found)} failing scenes)" if len(found) > 1 else ""
    return f"{most.sentence}{where}"


@dataclass(frozen=True)
class Silence:
    """A reference that gave no answer, for the same reason on one scene or more.

    Attributes
    ----------
    reference, state, reason : str
    scenes : tuple of str
        Names of the scenes.
    output : str
        The reference's last output on the first of them.
    """

    reference: str
    state: State
    reason: str
    scenes: tuple[str, ...]
    output: str


def silent(results: Iterable[SceneResult]) -> list[Silence]:
    """Every reference that gave no answer somewhere, grouped by the reason."""
    found: dict[tuple[str, State, str], list[tuple[str, str]]] = {}
    for result in results:
        for answer in result.references:
            for check in answer.checks[:1]:
                if check.state in UNANSWERED:
                    key = (answer.reference, check.state, check.reason)
                    found.setdefault(key, []).append((result.scene.name, answer.output))
    return [
        Silence(*key, tuple(name for name, _ in where), where[0][1]) for key, where in found.items()
    ]


def answer_in_words(answer: ReferenceResult) -> str:
    """One reference on one scene: 0.42×, 99.80 % certain; or 3 failed from shadow on."""
    state = answer_state(answer)
    if state not in COMPARED:
        return state
    certain = least_certain(answer.checks)
    tail = "" if certain is None else f", {share(certain.certain, certain.pixels)} certain"
    if state == "failed":
        failed = sum(check.state == "failed" for check in answer.checks)
        stage = first_wrong_stage(answer.checks)
        return f"{failed} failed" + (f" from {stage} on" if stage else tail)
    if state == "known":
        return f"{sum(check.state == 'known' for check in answer.checks)} known"
    worst = worst_check(answer.checks)
    return ("" if worst is None else times(worst.ratio or 0.0)) + tail
