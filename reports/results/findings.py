"""What a run found, summed up once: every report takes its counts and lists from here."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from minirt.quantities import QUANTITIES
from reference.compare.check import COMPARED, UNANSWERED, Check, State
from reference.verify.results import ReferenceResult, SceneResult
from reports.results.cells import (
    Cell,
    SceneState,
    answer_state,
    cells_of,
    first_wrong_stage,
    least_certain,
    scene_state,
    worst_check,
)
from reports.results.coverage import (
    Gap,
    RuleCoverage,
    gaps,
    not_checked,
    not_compared,
    rule_coverage,
)
from reports.results.words import STATES, is_consequence, share, times

#: Every state a scene can have, in the order in which they are counted.
SCENE_STATES: tuple[SceneState, ...] = ("failed", "incomplete", "passed", "not compared")


@dataclass(frozen=True, eq=False)
class AnswerFindings:
    """One scene against one reference, summed up.

    Attributes
    ----------
    answer : ReferenceResult
    state : str
        The worst of its checks' states.
    first_wrong_stage : str
        Empty where nothing is wrong.
    worst, least_certain : Check or None
        The one with the largest error over its tolerance, and the one with the smallest share of
        certain pixels; None where nothing was compared.
    """

    answer: ReferenceResult
    state: State
    first_wrong_stage: str
    worst: Check | None
    least_certain: Check | None

    def count(self, state: State) -> int:
        """How many of its checks are in a state."""
        return sum(check.state == state for check in self.answer.checks)


@dataclass(frozen=True, eq=False)
class SceneFindings:
    """One scene against every reference, summed up; fields as in `AnswerFindings`."""

    result: SceneResult
    state: SceneState
    first_wrong_stage: str
    worst: Check | None
    least_certain: Check | None
    answers: tuple[AnswerFindings, ...]

    @property
    def checks(self) -> Iterator[Check]:
        """Every check of the scene."""
        for answer in self.result.references:
            yield from answer.checks


@dataclass(frozen=True)
class Unanswered:
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


@dataclass(frozen=True)
class Diagnosis:
    """What explains a failure that a diagnosis was asked for, in a clause."""

    scene: str
    reference: str
    words: str


@dataclass(frozen=True, eq=False)
class Findings:
    """All scenes of a run, summed up.

    Attributes
    ----------
    scenes : tuple of SceneFindings
        In the order in which they were given.
    checks, scene_states : dict of str to int
        Numbers of checks and of scenes in each state.
    first_wrong_stage : str
    failing : tuple of Cell
        Faults before what only follows from them.
    contradicted : tuple of SceneResult
        Scenes on which exact arithmetic contradicts minirt.
    unanswered : tuple of Unanswered
    diagnoses : tuple of Diagnosis
    likeliest : str
        The mistake that explains most failures, in a clause; empty where none was looked for.
    quantities : tuple of str
        That the run was asked to compare, in the order of the table.
    gaps : tuple of Gap
    not_checked : str
        Quantities that no reference compared, in a clause.
    not_compared : tuple of str
        Scenes that no reference compared, with the reasons, a line each.
    rules : dict of str to RuleCoverage
    programs : dict of str to list of str
        What really ran, by reference: usually one program each; none where it never answered.
    """

    scenes: tuple[SceneFindings, ...]
    checks: dict[State, int]
    scene_states: dict[SceneState, int]
    first_wrong_stage: str
    failing: tuple[Cell, ...]
    contradicted: tuple[SceneResult, ...]
    unanswered: tuple[Unanswered, ...]
    diagnoses: tuple[Diagnosis, ...]
    likeliest: str
    quantities: tuple[str, ...]
    gaps: tuple[Gap, ...]
    not_checked: str
    not_compared: tuple[str, ...]
    rules: dict[str, RuleCoverage]
    programs: dict[str, list[str]]

    @property
    def every_check(self) -> Iterator[Check]:
        """The checks of all scenes and references."""
        for scene in self.scenes:
            yield from scene.checks

    @property
    def results(self) -> tuple[SceneResult, ...]:
        """The results that are summed up."""
        return tuple(scene.result for scene in self.scenes)


def findings_of(results: Sequence[SceneResult], references: Iterable[str] = ()) -> Findings:
    """Sum up the results of a run.

    Parameters
    ----------
    results : sequence of SceneResult
    references : iterable of str
        Names of those that were chosen.
    """
    scenes = tuple(map(_scene, results))
    cells = list(cells_of(results))
    states = [cell.check.state for cell in cells]
    ended = [scene.state for scene in scenes]
    failing = [cell for cell in cells if cell.check.state == "failed"]
    used = {cell.check.quantity for cell in cells}
    return Findings(
        scenes=scenes,
        checks={state: states.count(state) for state in STATES},
        scene_states={state: ended.count(state) for state in SCENE_STATES},
        first_wrong_stage=first_wrong_stage(cell.check for cell in cells),
        failing=tuple(sorted(failing, key=lambda cell: is_consequence(cell.check))),
        contradicted=tuple(r for r in results if r.judgement and r.judgement.convictions),
        unanswered=tuple(_unanswered(results)),
        diagnoses=tuple(_diagnoses(results)),
        likeliest=_likeliest(results),
        quantities=tuple(name for name in QUANTITIES if name in used),
        gaps=tuple(gaps(results)),
        not_checked=not_checked(results),
        not_compared=tuple(not_compared(results)),
        rules=rule_coverage(results),
        programs=_programs(results, references),
    )


def _scene(result: SceneResult) -> SceneFindings:
    checks = [check for answer in result.references for check in answer.checks]
    answers = tuple(map(_answer, result.references))
    return SceneFindings(
        result, scene_state(result), first_wrong_stage(checks), worst_check(checks),
        least_certain(checks), answers,
    )  # fmt: skip


def _answer(answer: ReferenceResult) -> AnswerFindings:
    checks = answer.checks
    return AnswerFindings(
        answer, answer_state(answer), first_wrong_stage(checks), worst_check(checks),
        least_certain(checks),
    )  # fmt: skip


def _unanswered(results: Iterable[SceneResult]) -> Iterator[Unanswered]:
    """Every reference that gave no answer somewhere, grouped by the reason."""
    found: dict[tuple[str, State, str], list[tuple[str, str]]] = {}
    for result in results:
        for answer in result.references:
            for check in answer.checks[:1]:
                if check.state in UNANSWERED:
                    key = (answer.reference, check.state, check.reason)
                    found.setdefault(key, []).append((result.scene.name, answer.output))
    for key, where in found.items():
        yield Unanswered(*key, tuple(name for name, _ in where), where[0][1])


def _diagnoses(results: Iterable[SceneResult]) -> Iterator[Diagnosis]:
    for result in results:
        for answer in result.references:
            if answer.diagnosis is not None:
                named = [each.sentence for each in answer.diagnosis]
                none = "none of the known mistakes explains it"
                yield Diagnosis(result.scene.name, answer.reference, "".join(named[:1]) or none)


def _likeliest(results: Iterable[SceneResult]) -> str:
    found = [a.diagnosis for r in results for a in r.references if a.diagnosis is not None]
    first = [named[0] for named in found if named]
    if not first:
        return "none of the known mistakes explains it" if found else ""
    most = max(first, key=lambda each: sum(other.name == each.name for other in first))
    number = sum(other.name == most.name for other in first)
    if 2 * number < len(found):
        return "no one mistake explains most of it"
    where = f" ({number} of {len(found)} failing scenes)" if len(found) > 1 else ""
    return f"{most.sentence}{where}"


def _programs(results: Iterable[SceneResult], references: Iterable[str]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {name: [] for name in references}
    for result in results:
        for answer in result.references:
            names = found.setdefault(answer.reference, [])
            if answer.declared is not None and answer.program not in names:
                names.append(answer.program)
    return found


def answer_in_words(found: AnswerFindings) -> str:
    """One reference on one scene: 0.42×, 99.80 % certain; or 3 failed from shadow on."""
    if found.state not in COMPARED:
        return found.state
    certain = found.least_certain
    tail = "" if certain is None else f", {share(certain.certain, certain.pixels)} certain"
    if found.state == "failed":
        stage = found.first_wrong_stage
        return f"{found.count('failed')} failed" + (f" from {stage} on" if stage else tail)
    if found.state == "known":
        return f"{found.count('known')} known"
    return ("" if found.worst is None else times(found.worst.ratio or 0.0)) + tail
