"""Grade one student: unpack and build the submission, judge every scene, explain what fails."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from tempfile import mkdtemp

from converters.atomic import atomic_folder
from minirt.errors import MinirtError, ReferenceError
from reference.jobs.isolate import Workers
from reference.jobs.program import sandbox_missing
from reference.jobs.scratch_folders import remove
from reports.gate.subject import GRACE
from reports.grade.assignment.assignment import AssignedScene
from reports.grade.judging.explained import FailureExplanation, explain_failure
from reports.grade.judging.judge import JudgingContext, MarkSheet, judge_scene, without_frame
from reports.grade.judging.score import RelevantParts, days_late, marks_of
from reports.grade.pages.student_files import write_student
from reports.grade.record import Student, earlier_record, folder_name, shown_name, write_json
from reports.grade.submission.submission import Submission, build, open_submission

#: Failing scenes of a student that are explained: the first, and the next of another stage.
_EXPLAINED = 2
#: Seconds for minirt's own work on one submission, or on one of its scenes.
_TIME_LIMIT = 300.0


@dataclass(frozen=True, eq=False)
class GradingPool:
    """The child processes that grade students, and what is known before the first of them."""

    context: JudgingContext
    workers: Workers
    relevant: RelevantParts

    @property
    def public(self) -> list[AssignedScene]:
        """The scenes that students may see."""
        return [assigned for assigned in self.context.assignment.scenes if assigned.public]


@dataclass(frozen=True)
class StudentTask:
    """One student to be graded.

    Attributes
    ----------
    name : str
    path : Path
        The submission.
    submitted : datetime or None
        When it was submitted, where that is known.
    key : str
        Hash of everything that the marks depend on.
    state : Path
        The file of the record.
    folder : Path
        Of the student's own files.
    """

    name: str
    path: Path
    submitted: datetime | None
    key: str
    state: Path
    folder: Path

    def earlier(self) -> Student | None:
        """What an earlier run found, if nothing has changed since."""
        return earlier_record(self.state, self.key) if self.folder.is_dir() else None

    def save(self, student: Student, files: Mapping[str, bytes]) -> Student:
        """Write the record and the student's files as another process made them."""
        with atomic_folder(self.folder) as staging:
            for name, content in files.items():
                (staging / name).write_bytes(content)
        write_json(student, self.state)
        return student


def grade_student(pool: GradingPool, task: StudentTask) -> Student:
    """Grade one student, unless an earlier run did."""
    student = task.earlier()
    if student is None:
        student = graded_anew(pool, task)
        write_json(student, task.state)
    return student


def graded_anew(pool: GradingPool, task: StudentTask) -> Student:
    """Grade one student, and write the student's own files."""
    with scratch_folder() as scratch:
        submission, message = opened(pool, task.path, scratch)
        if submission is None:
            return without_grading(pool, task, message)
        results = _judged(pool, submission, scratch)
        explained = _explained(pool, submission, scratch, results)
        student = _record(pool, task, submission, results=results, explained=explained)
        pictures = {each.scene.name: _scene_folder(scratch, each) for each in pool.public}
        _write_files(pool, task, student, pictures)
    return student


def without_grading(pool: GradingPool, task: StudentTask, message: str) -> Student:
    """Give no marks to a student, say why, and write the student's own files."""
    student = _record(pool, task, None, message)
    _write_files(pool, task, student, {})
    return student


def _write_files(
    pool: GradingPool, task: StudentTask, student: Student, pictures: Mapping[str, Path]
) -> None:
    with atomic_folder(task.folder) as staging:
        write_student(student, pool.context.assignment.rubric.title, pictures, staging)


def _record(
    pool: GradingPool,
    task: StudentTask,
    submission: Submission | None,
    message: str = "",
    results: tuple[MarkSheet, ...] = (),
    explained: tuple[FailureExplanation, ...] = (),
) -> Student:
    assignment = pool.context.assignment
    late = days_late(assignment.rubric.late, task.submitted)
    return Student(
        name=shown_name(task.name), folder=folder_name(task.name), key=task.key, message=message,
        kind="nothing" if submission is None else "program" if submission.is_program else "frames",
        submitted=task.submitted.isoformat() if task.submitted else None,
        marks=marks_of(assignment, pool.relevant, results, late),
        results=results, closer=explained,
    )  # fmt: skip


def opened(pool: GradingPool, path: Path, scratch: Path) -> tuple[Submission | None, str]:
    """The submission's files, built in a scratch folder; or why there is nothing to grade."""
    folder = scratch / "submission"
    folder.mkdir()
    rubric, names = pool.context.assignment.rubric, [each.scene.name for each in pool.public]
    outcome = pool.workers.submit(
        _TIME_LIMIT, open_submission, path.absolute(), folder, names, rubric
    ).outcome()
    if outcome.state != "done":
        said = str(outcome.value) if isinstance(outcome.value, MinirtError) else outcome.reason
        shown = said.replace(f"{path.absolute()}", path.name)
        return None, shown.replace(f"{folder}", "submission")
    submission: Submission = outcome.value
    if not submission.is_program:
        return submission, ""
    _require_sandbox(pool, path)
    limits, sandbox = rubric.limits, pool.context.sandbox
    seconds = limits.build_seconds + GRACE
    built = pool.workers.submit(seconds, build, submission, limits, sandbox).outcome()
    failure = built.value if built.state == "done" else f"the build: {built.reason}"
    return (None, failure) if failure else (submission, "")


def _require_sandbox(pool: GradingPool, path: Path) -> None:
    reason = sandbox_missing() if pool.context.sandbox else None
    if reason:
        raise ReferenceError(
            "no sandbox for the programs that were handed in", where=shown_name(path.name),
            got=reason, expected="bubblewrap, or --no-sandbox where every submission is trusted",
        )  # fmt: skip


def _judged(pool: GradingPool, submission: Submission, scratch: Path) -> tuple[MarkSheet, ...]:
    """Every scene; where its worker died, how it ended."""
    context = pool.context
    scenes = [s for s in context.assignment.scenes if s.public or submission.is_program]
    seconds = context.assignment.rubric.limits.seconds + GRACE
    started = [
        pool.workers.submit(
            seconds, judge_scene, context, assigned, submission, _scene_folder(scratch, assigned)
        )
        for assigned in scenes
    ]
    ended = zip(scenes, [job.outcome() for job in started], strict=True)
    return tuple(
        outcome.value if outcome.state == "done" else without_frame(assigned, submission, outcome)
        for assigned, outcome in ended
    )


def _explained(
    pool: GradingPool, submission: Submission, scratch: Path, results: Sequence[MarkSheet]
) -> tuple[FailureExplanation, ...]:
    """The first failing public scenes, one a stage, explained."""
    scenes = {assigned.scene.name: assigned for assigned in pool.public}
    wrong: dict[str, MarkSheet] = {}
    for result in results:
        if result.number == 0 and result.wrong:
            wrong.setdefault(result.stage, result)
    started = [
        pool.workers.submit(
            _TIME_LIMIT, explain_failure, pool.context, scenes[result.scene], submission,
            _scene_folder(scratch, scenes[result.scene]), result,
        )
        for result in list(wrong.values())[:_EXPLAINED]
    ]  # fmt: skip
    ended = [job.outcome() for job in started]
    return tuple(outcome.value for outcome in ended if outcome.state == "done")


def _scene_folder(scratch: Path, assigned: AssignedScene) -> Path:
    """Where a scene's pictures and frame are kept while the student is graded."""
    return scratch / "scenes" / f"{assigned.number}-{assigned.scene.name}"


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """A folder for one submission, removed at the end with all that a program left in it."""
    folder = Path(mkdtemp(prefix="minirt-")).resolve()
    try:
        yield folder
    finally:
        remove(folder)
