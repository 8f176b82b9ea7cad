"""Try one scene by one reference: in which stage it is wrong first, and at which pixel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import numpy as np

from converters.frames.io import read_frame
from minirt.frame import Frame
from minirt.quantities import QUANTITIES, STAGES
from minirt.scene import Scene
from reference.compare.check import Check
from reference.compare.comparison import Comparison, compare
from reference.compare.stability import Stability, exact_answer, stability_of
from reference.jobs.isolate import Job, Outcome, Workers
from reference.source import Reference, Unsupported
from reference.verify.options import TIMEOUT
from reference.verify.rendering import RenderedFrame, render_to_file


@dataclass(frozen=True)
class Trial:
    """The outcome of one scene tried by one reference.

    Attributes
    ----------
    state : str
        passed; failed; not supported; missing; or unjudged, if minirt itself gave no answer.
    stage : str
        Of a failure: the first wrong stage of `STAGES`, or crashed, timed out, wrong size.
    quantity : str
        The quantity of that stage with the largest error; empty if no pixel is wrong.
    column, row : int
        The pixel, from the left and from the TOP.
    reason : str
        In a sentence; empty if it passed.
    certain, judged : int
        Certain pixels, and all pixels, summed over the quantities compared.
    program, output : str
        What really ran, and its last output if it gave no answer.
    """

    state: Literal["passed", "failed", "not supported", "missing", "unjudged"]
    stage: str = ""
    quantity: str = ""
    column: int = 0
    row: int = 0
    reason: str = ""
    certain: int = 0
    judged: int = 0
    program: str = ""
    output: str = ""


class TrialWorkers:
    """Worker processes for references, and others for minirt, which are kept from scene to scene.

    Use as a context manager; leaving it ends every process.

    Parameters
    ----------
    jobs : int
        Processes of each kind.
    timeout : float
        Seconds that a reference may take for one scene.
    """

    def __init__(self, jobs: int = 1, timeout: float = TIMEOUT) -> None:
        self.timeout = timeout
        self._renderers, self._ours = Workers(jobs), Workers(jobs)
        self._numbers = count()

    def __enter__(self) -> TrialWorkers:
        self._scratch = TemporaryDirectory(prefix="minirt-")
        self._renderers.__enter__()
        self._ours.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._ours.__exit__(*error)
        self._renderers.__exit__(*error)
        self._scratch.cleanup()

    def trial(self, scene: Scene, reference: Reference) -> Trial:
        """Try a scene by a reference."""
        return self.trials(scene, [reference])[0]

    def trials(self, scene: Scene, references: Sequence[Reference]) -> list[Trial]:
        """Try a scene by each reference."""
        started = [(reference, self._start(scene, reference)) for reference in references]
        answers = [_answer(reference, job) for reference, job in started]
        given = [
            (reference, answer)
            for reference, answer in zip(references, answers, strict=True)
            if isinstance(answer, RenderedFrame)
        ]
        compared = iter(self._compared(scene, given))
        return [a if isinstance(a, Trial) else next(compared) for a in answers]

    def _start(self, scene: Scene, reference: Reference) -> Job | None:
        if reference.missing():
            return None
        folder = Path(self._scratch.name) / str(next(self._numbers))
        folder.mkdir()
        return self._renderers.submit(self.timeout, render_to_file, reference, scene, folder)

    def _compared(self, scene: Scene, given: list[tuple[Reference, RenderedFrame]]) -> list[Trial]:
        if not given:
            return []
        outcome = self._ours.submit(None, compare_all, scene, given).outcome()
        for _, answer in given:
            Path(answer.frame).unlink(missing_ok=True)
        if outcome.state == "done":
            trials: list[Trial] = outcome.value
            return trials
        reason = f"minirt itself failed: {outcome.reason}"
        return [Trial("unjudged", reason=reason, output=outcome.output)] * len(given)


def try_once(scene: Scene, reference: Reference) -> Trial:
    """Try a scene by a reference, in processes of its own."""
    with TrialWorkers() as workers:
        return workers.trial(scene, reference)


def compare_all(scene: Scene, answers: Sequence[tuple[Reference, RenderedFrame]]) -> list[Trial]:
    """Compare references' frames of one scene with minirt's. Runs in a child process.

    What they declare is asked here, where no renderer's code has run.
    """
    exact = exact_answer(scene)
    trials = []
    for reference, answer in answers:
        theirs, stability = Frame({}), Stability({}, {})
        if answer.given:
            theirs = read_frame(answer.frame)
            stability = stability_of(exact, reference.declare(scene), answer.given)
        comparison = compare(scene, exact.frame, stability, theirs, answer.unsupported)
        trials.append(_trial_of(comparison, answer.program))
    return trials


def _answer(reference: Reference, job: Job | None) -> RenderedFrame | Trial:
    """What a reference gave, or the trial that says why there is nothing."""
    if job is None:
        return Trial("missing", reason=reference.missing() or "")
    outcome = job.outcome()
    if outcome.state == "done":
        rendered: RenderedFrame = outcome.value
        return rendered
    return _without_frame(outcome)


def _without_frame(outcome: Outcome) -> Trial:
    if isinstance(outcome.value, Unsupported):
        return Trial("not supported", reason=str(outcome.value))
    stage = "timed out" if outcome.state == "timed out" else "crashed"
    return Trial("failed", stage, reason=outcome.reason, output=outcome.output)


def _trial_of(comparison: Comparison, program: str) -> Trial:
    """The first wrong stage of a comparison. Only wrong certain pixels count as a failure."""
    compared = [check for check in comparison.checks if check.pixels]
    certain, judged = (sum(getattr(c, name) for c in compared) for name in ("certain", "pixels"))
    for check in comparison.checks:
        if check.state == "failed" and not check.pixels:
            return Trial("failed", "wrong size", check.quantity, reason=check.reason)
    wrong = [check for check in compared if check.first_wrong]
    if not compared:
        return Trial("not supported", reason="no quantity of the scene is given", program=program)
    if not wrong:
        return Trial("passed", certain=certain, judged=judged, program=program)
    first = min(wrong, key=lambda check: STAGES.index(check.stage))
    column, row, name = _worst_pixel(comparison, first)
    return Trial(
        "failed", first.stage, name, column, row, f"{name}: {first.reason}",
        certain, judged, program,
    )  # fmt: skip


def _worst_pixel(comparison: Comparison, first: Check) -> tuple[int, int, str]:
    """Column, row and quantity of the largest ratio among pixels first wrong in this stage."""
    here = comparison.first_stage == STAGES.index(first.stage)
    worst = (-1.0, 0, 0, first.quantity)
    for name, ratio in comparison.ratio.items():
        if QUANTITIES[name].stage == first.stage:
            off = np.where(here & (ratio > 1), ratio, -1.0)
            row, column = np.unravel_index(int(off.argmax()), off.shape)
            worst = max(worst, (float(off[row, column]), int(column), int(row), name))
    return worst[1], worst[2], worst[3]
