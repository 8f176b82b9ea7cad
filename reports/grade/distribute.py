"""Distribute the students of a class over threads of this process, or over a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from minirt.errors import MinirtError
from reference.cache import usual_folder
from reference.jobs.cluster import Cluster, Job
from reference.jobs.isolate import Workers
from reports.grade.judging.judge import JudgingContext
from reports.grade.judging.score import RelevantParts
from reports.grade.record import Student
from reports.grade.student import (
    GradingPool,
    StudentTask,
    grade_student,
    graded_anew,
    scratch_folder,
    without_grading,
)
from reports.grade.submission.transfer import SubmissionBytes, read_submission

#: Called with the numbers of students done and of all.
Progress = Callable[[int, int], None]


def graded_here(
    pool: GradingPool, tasks: Sequence[StudentTask], jobs: int, progress: Progress | None
) -> Iterator[Student]:
    """Every student in order; at most `jobs` submissions are in progress at a time."""
    with ThreadPoolExecutor(jobs) as threads:
        started = [threads.submit(grade_student, pool, task) for task in tasks]
        try:
            for k, future in enumerate(started, start=1):
                yield future.result()
                if progress is not None:
                    progress(k, len(started))
        finally:
            threads.shutdown(wait=False, cancel_futures=True)


def graded_on_cluster(
    cluster: Cluster, pool: GradingPool, tasks: Sequence[StudentTask], progress: Progress | None
) -> tuple[list[Student], list[str]]:
    """Every student in order, and the names of those whose job crashed.

    Submissions that will be refused, and those that an earlier run graded, are not sent.
    """
    found: dict[str, Student] = {}
    crashed: list[str] = []
    sent: list[StudentTask] = []

    def jobs() -> Iterator[Job]:
        for task in tasks:
            content = None if task.earlier() else read_submission(task.path)
            if content is None:
                found[task.name] = grade_student(pool, task)
                continue
            sent.append(task)
            yield _grade_on_worker, (pool.context, pool.relevant, task, content)

    for number, outcome in cluster.outcomes(jobs()):
        task = sent[number]
        if isinstance(outcome.value, MinirtError):
            raise outcome.value
        if outcome.state == "done":
            found[task.name] = task.save(*outcome.value)
        else:
            found[task.name] = without_grading(pool, task, f"crashed: {outcome.reason}")
            crashed.append(task.name)
        if progress is not None:
            progress(len(found), len(tasks))
    return [found[task.name] for task in tasks], crashed


def _grade_on_worker(
    context: JudgingContext, relevant: RelevantParts, task: StudentTask, content: SubmissionBytes
) -> tuple[Student, dict[str, bytes]]:
    """Grade one student with the worker's own cache; the record, and the student's files."""
    context = replace(context, cache=replace(context.cache, folder=usual_folder()))
    with scratch_folder() as scratch, Workers(1) as workers:
        path = content.write_into(_created(scratch / "submitted"))
        task = replace(task, path=path, folder=_created(scratch / "files") / "own")
        student = graded_anew(GradingPool(context, workers, relevant), task)
        return student, {each.name: each.read_bytes() for each in sorted(task.folder.iterdir())}


def _created(folder: Path) -> Path:
    folder.mkdir()
    return folder
