"""`minirt grade`: marks for a class."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.cli.options import ClusterOption, Json
from reports.terminal.console import print_json, progress, stderr_console, stdout_console

if TYPE_CHECKING:
    from rich.console import Console

    from reports.grade.record import ClassRecord


def grade(
    submissions: Annotated[
        Path,
        typer.Argument(
            metavar="SUBMISSIONS",
            help="A folder with a folder, .zip or .tar.gz a student: frames by their scenes' "
            "names, or a program with minirt.toml.",
        ),
    ],
    rubric: Annotated[
        Path, typer.Option(metavar="FILE", help="What earns points: rubric.toml.")
    ],
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where marks and pages go.")
    ],
    times: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", show_default=False,
            help="When each was handed in: a CSV with the columns student and submitted.",
        ),
    ] = None,
    no_sandbox: Annotated[
        bool,
        typer.Option(
            "--no-sandbox",
            help="Run programs with limits only: they can read what you can, hidden scenes too.",
        ),
    ] = False,
    jobs: Annotated[
        int, typer.Option("--jobs", "-j", min=1, help="Submissions at a time; all processors.")
    ] = len(os.sched_getaffinity(0)),
    cluster: ClusterOption = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Grade a class by a rubric, with a page for each student and one for staff.

    Each submission is judged as the gate judges, in a sandbox, whatever the others do. A run that
    was ended goes on where it was. Exit status 0: graded, whatever the marks.
    """
    from minirt.errors import InputError
    from reports.grade.assignment import read_assignment
    from reports.grade.files import write_class
    from reports.grade.judge import Desk
    from reports.grade.kit import write_kit
    from reports.grade.run import grade_class
    from reports.grade.submission import left_aside, students_in
    from reports.grade.times import read_times
    from reports.inputs import cluster_at, usual_cache
    from reports.results.words import listed, one_line

    assignment = read_assignment(rubric)
    students = students_in(submissions)
    if out.resolve().is_relative_to(submissions.resolve()):
        raise InputError("the marks would lie among the submissions", where=str(out))
    known = read_times(times) if times is not None else {}
    desk = Desk(assignment, usual_cache(), not no_sandbox)
    with cluster_at(cluster) as workers, progress("grade") as tell:
        record = grade_class(students, desk, out, jobs, known, tell, workers)
    aside = [one_line(name, 60) for name in left_aside(submissions)]
    if aside:
        note = f"not graded, for they are no folders and no archives that we read: {listed(aside)}"
        record = record.model_copy(update={"remarks": (*record.remarks, note)})
    write_class(record, out)
    write_kit(assignment, rubric, out / "staff" / "gradescope")
    _print(record, out, stderr_console() if json else stdout_console())
    if json:
        print_json(record.model_dump(mode="json"))


def _print(record: ClassRecord, out: Path, console: Console) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from reports.grade.words import about, points
    from reports.results.words import count, one_line

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("student", overflow="fold")
    table.add_column("points", justify="right", no_wrap=True)
    table.add_column("first wrong stage, likely mistake", overflow="fold")
    for student in record.students:
        told = Text(one_line(about(student), 160))
        table.add_row(Text(student.name), points(student.marks.points), told)
    console.print(table)
    for each in record.copies:
        console.print(f"looks copied: {each.sentence}", soft_wrap=True)
    for remark in record.remarks:
        console.print(f"note: {remark}", soft_wrap=True)
    number = count(len(record.students), "student")
    console.print(f"{out}: {number} graded, of {points(record.of)} points", soft_wrap=True)
