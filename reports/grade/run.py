"""Grade a class: every submission on its own, in child processes, whatever the others do."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

import numpy as np

from minirt.errors import InputError, ReferenceError
from reference.jobs.cluster import Cluster
from reference.jobs.identity import PACKAGES, source_digest
from reference.jobs.isolate import Workers
from reports.grade.assignment.rubric import Rubric
from reports.grade.copies import find_copies
from reports.grade.distribute import graded_here, graded_on_cluster
from reports.grade.judging.judge import JudgingContext, prepare_scene
from reports.grade.judging.score import RelevantParts
from reports.grade.record import ClassRecord, Student, folder_name, shown_name
from reports.grade.student import GradingPool, StudentTask
from reports.grade.submission.students import digest_of
from reports.results.words import count, listed
from reports.run import made_folder

#: Students whose names a remark lists.
_MOST_NAMES = 10


@dataclass(frozen=True, eq=False)
class GradeOptions:
    """What is graded, and where.

    Attributes
    ----------
    students : mapping of str to Path
        Submissions by student.
    context : JudgingContext
    out : Path
        Created where it does not exist.
    jobs : int
        Child processes, and submissions in progress at a time.
    times : mapping of str to datetime
        When they were submitted.
    cluster : Cluster or None
        Its workers grade one student each in place of this machine, with their own cache.
    """

    students: Mapping[str, Path]
    context: JudgingContext
    out: Path
    jobs: int = 2
    times: Mapping[str, datetime] = field(default_factory=dict)
    cluster: Cluster | None = None


def grade_class(
    options: GradeOptions, progress: Callable[[int, int], None] | None = None
) -> ClassRecord:
    """Grade every submission, and write each student's files as soon as they are known.

    A run that was interrupted continues: what an earlier run graded is taken over where the
    rubric, the submission and minirt are the same.

    Parameters
    ----------
    options : GradeOptions
    progress : callable, optional
        Called with the numbers of students done and of all.

    Raises
    ------
    InputError
        No pixel shows what a part of the rubric is about, or a folder cannot be written.
    ReferenceError
        minirt itself failed, or a program was submitted and there is no sandbox.
    """
    for name in ("students", "staff/state"):
        made_folder(options.out / name)
    context, crashed = options.context, list[str]()
    tasks = [_task(options, name) for name in sorted(options.students)]
    with Workers(options.jobs) as workers:
        pool = GradingPool(context, workers, _relevant_parts(context, workers))
        if options.cluster is None:
            graded = list(graded_here(pool, tasks, options.jobs, progress))
        else:
            graded, crashed = graded_on_cluster(options.cluster, pool, tasks, progress)
    rubric = context.assignment.rubric
    strangers = sorted(options.times.keys() - options.students.keys())
    remarks = list(_remarks(rubric, graded, strangers))
    if crashed:
        remarks.append(f"not graded, for it crashed; another run tries again: {_some(crashed)}")
    return ClassRecord(
        title=rubric.title, of=rubric.points, students=tuple(graded),
        copies=find_copies(graded), remarks=tuple(remarks),
    )  # fmt: skip


def _relevant_parts(context: JudgingContext, workers: Workers) -> RelevantParts:
    """Compute minirt's own answers once, and find the parts for which each scene is relevant."""
    scenes = context.assignment.scenes
    started = [workers.submit(None, prepare_scene, context, assigned) for assigned in scenes]
    relevant: dict[tuple[str, int], tuple[bool, ...]] = {}
    for assigned, job in zip(scenes, started, strict=True):
        outcome = job.outcome()
        if outcome.state != "done":
            name = assigned.scene.name
            raise ReferenceError("minirt itself failed", where=name, got=outcome.reason)
        relevant[assigned.scene.name, assigned.number] = outcome.value
    for k, part in enumerate(context.assignment.rubric.part):
        if not any(parts[k] for (_, number), parts in relevant.items() if number == 0):
            raise InputError("no pixel of its scenes shows what a part is about", where=part.name)
    return relevant


def _task(options: GradeOptions, name: str) -> StudentTask:
    path, submitted, folder = options.students[name], options.times.get(name), folder_name(name)
    return StudentTask(
        name, path, submitted, _key(options.context, path, name, submitted),
        options.out / "staff" / "state" / f"{folder}.json", options.out / "students" / folder,
    )  # fmt: skip


def _key(context: JudgingContext, path: Path, name: str, submitted: datetime | None) -> str:
    """A hash of everything that a student's marks depend on."""
    digest = hashlib.sha256()
    program = (np.__version__, source_digest(*PACKAGES))
    submission = (name, digest_of(path), submitted)
    for part in (*program, context.assignment.sha256, *submission, context.sandbox):
        digest.update(str(part).encode(errors="surrogateescape") + b"\0")
    return digest.hexdigest()


def _remarks(
    rubric: Rubric, students: Sequence[Student], strangers: Sequence[str]
) -> Iterator[str]:
    if rubric.late is not None:
        unknown = [student.name for student in students if student.submitted is None]
        if len(unknown) == len(students):
            yield "no time is known of any submission, so none is late: --times takes a table"
        elif unknown:
            number = f"{len(unknown)} of {count(len(students), 'submission')}"
            yield f"no time is known of {number}, on time therefore: {_some(unknown)}"
    if strangers:
        yield f"times of students without a submission: {_some(strangers)}"
    if rubric.hidden is not None and any(s.kind == "frames" for s in students):
        frames = sum(s.kind == "frames" for s in students)
        hold = count(frames, "submission holds", "submissions hold")
        yield f"{hold} frames, which earn nothing on hidden scenes"


def _some(names: Sequence[str]) -> str:
    """The first few names in a sentence, and how many others there are."""
    few = [shown_name(name) for name in names[:_MOST_NAMES]]
    more = len(names) - len(few)
    return listed([*few, count(more, "other")] if more else few)
