"""One submission on one scene, through the gate's comparison; runs in child processes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from converters.frames.io import read_frame, write_frame
from minirt.errors import MinirtError
from minirt.quantities import QUANTITIES, STAGES
from reference.cache import Cache
from reference.compare.check import CERTAIN_FLOOR
from reference.compare.comparison import Comparison, compare
from reference.compare.precision import Claim, Precision, declared
from reference.jobs.isolate import Outcome
from reference.jobs.scratch_folders import remove
from reference.source import Crashed, Rendering, Unsupported
from reference.verify.results import Evidence
from reports.grade.assignment.assignment import AssignedScene, Assignment
from reports.grade.judging.fingerprint import fingerprint, is_rounded
from reports.grade.judging.relevance import is_relevant
from reports.grade.judging.tally import Tally, charged_pixels, tally
from reports.grade.judging.thumbnails import write_thumbnails
from reports.grade.submission.submission import Submission, subject_of
from reports.results.json_model import Model, Natural

#: The formats in which numbers come: of .npz, and of everything else.
_HANDED: tuple[Precision, ...] = ("float64", "float32")
#: Characters of a program's last output that are kept.
_OUTPUT = 2000
#: A program's frame with a wrong pixel in it, kept for `judge_again`.
_FRAME = "frame.npz"

State = Literal["judged", "no frame", "crashed", "timed out"]


class MarkSheet(Model):
    """What one scene was judged to be worth."""

    scene: str
    number: Natural = Field(description="0: public; 1 and more: its hidden variants")
    state: State
    reason: str = ""
    output: str = Field(default="", description="a program's last output where it gave no answer")
    tallies: dict[int, tuple[Natural, Natural, Natural, Natural]] = Field(
        default={}, description="by part: pixels judged and right, quantities given and asked for"
    )
    stage: str = Field(default="", description="first stage at which any pixel is wrong")
    quantity: str = Field(default="", description="the first that is wrong there")
    wrong: Natural = Field(default=0, description="pixels at which anything is wrong")
    certain: Natural = 0
    pixel: tuple[Natural, Natural] | None = Field(default=None, description="the worst one")
    numbers: str = Field(
        default="", description="hash of its numbers; empty where they identify nobody"
    )
    ours: bool = Field(default=False, description="whether they are minirt's own, bit for bit")

    def tally(self, part: int) -> Tally | None:
        """What a part is judged by; None where the part is not judged on the scene."""
        found = self.tallies.get(part)
        return None if found is None else Tally(*found)


@dataclass(frozen=True, eq=False)
class JudgingContext:
    """What judging any submission needs: the assignment, the cache, whether to use a sandbox."""

    assignment: Assignment
    cache: Cache
    sandbox: bool


def prepare_scene(context: JudgingContext, assigned: AssignedScene) -> tuple[bool, ...]:
    """Compute minirt's own answer to a scene once; which parts the scene is relevant for."""
    rubric = context.assignment.rubric
    exact = context.cache.exact(assigned.scene)
    for handed in _HANDED:
        error = replace(
            declared(assigned.scene, Claim(rubric.precision, handed=handed)), derivation=""
        )
        context.cache.stability(exact, error, rubric.quantities)
    return tuple(
        assigned.scene.name in scenes and is_relevant(part, assigned.scene, exact.frame)
        for part, (scenes, _) in zip(rubric.part, context.assignment.parts, strict=True)
    )


def judge_scene(
    context: JudgingContext, assigned: AssignedScene, submission: Submission, folder: Path
) -> MarkSheet:
    """Judge a submission on a scene.

    For a public scene the folder keeps the pictures, and a program's frame where it is wrong.

    Raises
    ------
    MinirtError, Unsupported
        There is no frame that could be judged, and why.
    """
    scene, rubric = assigned.scene, context.assignment.rubric
    subject = subject_of(submission, scene, rubric.limits, context.sandbox)
    folder.mkdir(parents=True)
    try:
        rendering = subject.render(scene, folder)
    finally:
        remove(folder / "room")
    seen = compare_frame(context, assigned, submission, rendering)
    result = _result(context, assigned, submission, seen)
    if assigned.public:
        write_thumbnails(seen, result.quantity, folder)
        if result.wrong and submission.is_program:
            write_frame(rendering.frame, folder / _FRAME)
    return result


def judge_again(
    context: JudgingContext, assigned: AssignedScene, submission: Submission, folder: Path
) -> Evidence:
    """The evidence of `judge_scene` on a public scene again, without running the program."""
    scene = assigned.scene
    if submission.is_program:
        frame = read_frame(folder / _FRAME, (scene.screen.ny, scene.screen.nx))
        return compare_frame(context, assigned, submission, Rendering(frame))
    subject = subject_of(submission, scene, context.assignment.rubric.limits, context.sandbox)
    return compare_frame(context, assigned, submission, subject.render(scene, folder))


def without_frame(assigned: AssignedScene, submission: Submission, outcome: Outcome) -> MarkSheet:
    """The mark sheet of a scene on which `judge_scene` raised an error, or crashed."""
    found = outcome.value
    state: State = "crashed"
    if "timed out" in (outcome.state, getattr(found, "state", "")):
        state = "timed out"
    elif isinstance(found, MinirtError | Unsupported) and not isinstance(found, Crashed):
        state = "no frame"
    said = isinstance(found, MinirtError | Unsupported)
    reason = str(found) if said else outcome.reason
    return MarkSheet(
        scene=assigned.scene.name, number=assigned.number, state=state,
        reason=reason.replace(str(submission.folder), "the submission"),
        output=outcome.output[-_OUTPUT:] if assigned.public else "",
    )  # fmt: skip


def compare_frame(
    context: JudgingContext, assigned: AssignedScene, submission: Submission, rendering: Rendering
) -> Evidence:
    """Compare a submission's frame with minirt's, under the precision that it claims."""
    scene, rubric = assigned.scene, context.assignment.rubric
    subject = subject_of(submission, scene, rubric.limits, context.sandbox)
    if is_rounded(rendering.frame):
        subject = replace(subject, claim=replace(subject.claim, handed="float32"))
    exact = context.cache.exact(scene)
    error = replace(subject.declare(scene), derivation="")
    stability = context.cache.stability(exact, error, rubric.quantities)
    comparison = compare(
        scene, exact.frame, stability, rendering.frame, rendering.unsupported, rubric.quantities,
        pictures=False,
    )  # fmt: skip
    return Evidence(scene, subject.name, exact.frame, rendering.frame, stability, comparison)


def _result(
    context: JudgingContext, assigned: AssignedScene, submission: Submission, seen: Evidence
) -> MarkSheet:
    scene, rubric, comparison = assigned.scene, context.assignment.rubric, seen.comparison
    vague = submission.precision != rubric.precision and _too_vague(assigned, comparison)
    parts = list(zip(rubric.part, context.assignment.parts, strict=True))
    excused = charged_pixels([(part, names) for part, (_, names) in parts], seen)
    tallies = {}
    for k, (part, (scenes, names)) in enumerate(parts):
        if scene.name in scenes:
            counted = tally(part, names, seen, excused)
            right = 0 if vague else counted.right
            tallies[k] = (counted.judged, right, counted.given, counted.asked)
    first = comparison.first_stage
    stage = STAGES[int(first[first >= 0].min())] if (first >= 0).any() else ""
    worst = next((c for c in comparison.checks if c.stage == stage and c.first_wrong), None)
    numbers, own = fingerprint(seen.ours, seen.theirs)
    return MarkSheet(
        scene=scene.name, number=assigned.number, state="judged",
        reason="the precision that it claims leaves too many pixels uncertain" if vague else "",
        tallies=tallies, stage=stage, quantity=worst.quantity if worst else "",
        wrong=int((first >= 0).sum()),
        certain=max((c.certain for c in comparison.checks), default=0),
        pixel=_worst_pixel(comparison, stage), numbers=numbers,
        ours=own,
    )  # fmt: skip


def _too_vague(assigned: AssignedScene, comparison: Comparison) -> bool:
    """Whether the claimed errors leave fewer pixels certain than the floor."""
    floor = assigned.scene.floor[0] if assigned.scene.floor else CERTAIN_FLOOR
    return any(check.certain < floor * check.pixels for check in comparison.checks if check.pixels)


def _worst_pixel(comparison: Comparison, stage: str) -> tuple[int, int] | None:
    """Column and row of the worst pixel among those that are first wrong at a stage."""
    if not stage:
        return None
    here = comparison.first_stage == STAGES.index(stage)
    names = [n for n in comparison.ratio if QUANTITIES[n].stage == stage]
    worst = np.max([np.nan_to_num(comparison.ratio[n], posinf=1e300) for n in names], axis=0)
    row, column = np.unravel_index(int(np.where(here, worst, -1.0).argmax()), here.shape)
    return int(column), int(row)
