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
from reports.grade.assignment import Assignment, Sheet
from reports.grade.draw import draw
from reports.grade.fingerprint import fingerprint, is_rounded
from reports.grade.parts import Tally, charged, speaks_of, tally
from reports.grade.submission import Opened, subject_of
from reports.results.json_model import Model, Natural

#: The formats in which numbers come: of .npz, and of everything else.
_HANDED: tuple[Precision, ...] = ("float64", "float32")
#: Characters of a program's last output that are kept.
_OUTPUT = 2000
#: Where a program's frame with a wrong pixel in it waits for whoever looks closer.
_FRAME = "frame.npz"

State = Literal["judged", "no frame", "crashed", "timed out"]


class SheetResult(Model):
    """What came of one scene."""

    scene: str
    number: Natural = Field(description="0: public; 1 and more: its hidden variants")
    state: State
    reason: str = ""
    output: str = Field(default="", description="a program's last words where it gave no answer")
    tallies: dict[int, tuple[Natural, Natural, Natural, Natural]] = Field(
        default={}, description="by part: pixels judged and right, quantities given and asked for"
    )
    stage: str = Field(default="", description="first stage at which any pixel is wrong")
    quantity: str = Field(default="", description="the first that is wrong there")
    wrong: Natural = Field(default=0, description="pixels at which anything is wrong")
    certain: Natural = 0
    pixel: tuple[Natural, Natural] | None = Field(default=None, description="the worst one")
    numbers: str = Field(
        default="", description="hash of its numbers; empty where they tell nothing"
    )
    ours: bool = Field(default=False, description="whether they are minirt's own, bit for bit")

    def tally(self, part: int) -> Tally | None:
        """What a part is judged by; None where nothing was judged."""
        found = self.tallies.get(part)
        return None if found is None else Tally(*found)


@dataclass(frozen=True, eq=False)
class Desk:
    """What the judging of any submission takes: the assignment, the cache, whether to sandbox."""

    assignment: Assignment
    cache: Cache
    sandbox: bool


def prepare(desk: Desk, sheet: Sheet) -> tuple[bool, ...]:
    """Compute minirt's own answer to a scene once, and say which parts it speaks of."""
    rubric = desk.assignment.rubric
    exact = desk.cache.exact(sheet.scene)
    for handed in _HANDED:
        error = replace(
            declared(sheet.scene, Claim(rubric.precision, handed=handed)), derivation=""
        )
        desk.cache.stability(exact, error, rubric.quantities)
    return tuple(
        sheet.scene.name in scenes and speaks_of(part, sheet.scene, exact.frame)
        for part, (scenes, _) in zip(rubric.part, desk.assignment.parts, strict=True)
    )


def judge_sheet(desk: Desk, sheet: Sheet, opened: Opened, room: Path) -> SheetResult:
    """Judge a submission on a scene.

    Of a public scene, pictures stay in the room, and a program's frame where it is wrong.

    Raises
    ------
    MinirtError, Unsupported
        There is no frame that could be judged, and why.
    """
    scene, rubric = sheet.scene, desk.assignment.rubric
    subject = subject_of(opened, scene, rubric.limits, desk.sandbox)
    room.mkdir(parents=True)
    try:
        rendering = subject.render(scene, room)
    finally:
        remove(room / "room")
    seen = compared(desk, sheet, opened, rendering)
    result = _result(desk, sheet, opened, seen)
    if sheet.public:
        draw(seen, result.quantity, room)
        if result.wrong and opened.is_program:
            write_frame(rendering.frame, room / _FRAME)
    return result


def judged_again(desk: Desk, sheet: Sheet, opened: Opened, room: Path) -> Evidence:
    """What `judge_sheet` has seen of a public scene where something is wrong; runs no program."""
    scene = sheet.scene
    if opened.is_program:
        frame = read_frame(room / _FRAME, (scene.screen.ny, scene.screen.nx))
        return compared(desk, sheet, opened, Rendering(frame))
    subject = subject_of(opened, scene, desk.assignment.rubric.limits, desk.sandbox)
    return compared(desk, sheet, opened, subject.render(scene, room))


def without_frame(sheet: Sheet, opened: Opened, outcome: Outcome) -> SheetResult:
    """What came of a scene that `judge_sheet` has raised on, or not survived."""
    found = outcome.value
    state: State = "crashed"
    if "timed out" in (outcome.state, getattr(found, "state", "")):
        state = "timed out"
    elif isinstance(found, MinirtError | Unsupported) and not isinstance(found, Crashed):
        state = "no frame"
    said = isinstance(found, MinirtError | Unsupported)
    reason = str(found) if said else outcome.reason
    return SheetResult(
        scene=sheet.scene.name, number=sheet.number, state=state,
        reason=reason.replace(str(opened.folder), "the submission"),
        output=outcome.output[-_OUTPUT:] if sheet.public else "",
    )  # fmt: skip


def compared(desk: Desk, sheet: Sheet, opened: Opened, rendering: Rendering) -> Evidence:
    """What a submission has rendered beside minirt's answer, under what it claims."""
    scene, rubric = sheet.scene, desk.assignment.rubric
    subject = subject_of(opened, scene, rubric.limits, desk.sandbox)
    if is_rounded(rendering.frame):
        subject = replace(subject, claim=replace(subject.claim, handed="float32"))
    exact = desk.cache.exact(scene)
    error = replace(subject.declare(scene), derivation="")
    stability = desk.cache.stability(exact, error, rubric.quantities)
    comparison = compare(
        scene, exact.frame, stability, rendering.frame, rendering.unsupported, rubric.quantities,
        pictures=False,
    )  # fmt: skip
    return Evidence(scene, subject.name, exact.frame, rendering.frame, stability, comparison)


def _result(desk: Desk, sheet: Sheet, opened: Opened, seen: Evidence) -> SheetResult:
    scene, rubric, comparison = sheet.scene, desk.assignment.rubric, seen.comparison
    vague = opened.precision != rubric.precision and _too_vague(sheet, comparison)
    parts = list(zip(rubric.part, desk.assignment.parts, strict=True))
    excused = charged([(part, names) for part, (_, names) in parts], seen)
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
    return SheetResult(
        scene=scene.name, number=sheet.number, state="judged",
        reason="the precision that it claims leaves too many pixels uncertain" if vague else "",
        tallies=tallies, stage=stage, quantity=worst.quantity if worst else "",
        wrong=int((first >= 0).sum()),
        certain=max((c.certain for c in comparison.checks), default=0),
        pixel=_worst_pixel(comparison, stage), numbers=numbers,
        ours=own,
    )  # fmt: skip


def _too_vague(sheet: Sheet, comparison: Comparison) -> bool:
    """Whether a claim other than the assignment's own leaves less certain than the floor."""
    floor = sheet.scene.floor[0] if sheet.scene.floor else CERTAIN_FLOOR
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
