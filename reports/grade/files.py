"""Grade a folder of submissions by the file of a rubric, and write all files of the class."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from minirt.errors import InputError
from reference.jobs.cluster import Cluster
from reports.grade.assignment.assignment import read_assignment
from reports.grade.assignment.times import read_times
from reports.grade.judging.judge import JudgingContext
from reports.grade.pages.class_files import write_class
from reports.grade.pages.gradescope import write_autograder
from reports.grade.record import ClassRecord
from reports.grade.run import GradeOptions, grade_class
from reports.grade.submission.students import ignored_files, students_in
from reports.inputs import usual_cache
from reports.results.words import listed, one_line


@dataclass(frozen=True)
class GradeFiles:
    """The files that a class is graded from and into.

    Attributes
    ----------
    submissions : Path
        A folder with a folder or an archive for each student.
    rubric : Path
    out : Path
    times : Path or None
        The CSV of the submission times.
    """

    submissions: Path
    rubric: Path
    out: Path
    times: Path | None = None


def grade_files(
    files: GradeFiles,
    sandbox: bool,
    jobs: int,
    cluster: Cluster | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> ClassRecord:
    """Grade a class, and write its marks, its pages and the folder for Gradescope.

    Raises
    ------
    InputError, SceneError, ReferenceError
        As for `read_assignment` and `grade_class`.
    """
    out, submissions = files.out, files.submissions
    assignment = read_assignment(files.rubric)
    students = students_in(submissions)
    if out.resolve().is_relative_to(submissions.resolve()):
        raise InputError("the marks would lie among the submissions", where=str(out))
    times = read_times(files.times) if files.times is not None else {}
    context = JudgingContext(assignment, usual_cache(), sandbox)
    record = grade_class(GradeOptions(students, context, out, jobs, times, cluster), progress)
    ignored = [one_line(name, 60) for name in ignored_files(submissions)]
    if ignored:
        note = f"not graded, for they are neither folders nor known archives: {listed(ignored)}"
        record = record.model_copy(update={"remarks": (*record.remarks, note)})
    write_class(record, out)
    write_autograder(assignment, files.rubric, out / "staff" / "gradescope")
    return record
