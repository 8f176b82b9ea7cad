"""`minirt grade`: marks for a class."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from reports.cli.options import CORES, ClusterOption, Json
from reports.inputs import cluster_at
from reports.terminal.console import print_json, progress, stderr_console, stdout_console


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
    ] = CORES,
    cluster: ClusterOption = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Grade a class by a rubric, with a page for each student and one for staff.

    Each submission is judged as the gate judges, in a sandbox, whatever the others do. A run that
    was ended goes on where it was. Exit status 0: graded, whatever the marks.
    """
    from reports.grade.files import GradeFiles, grade_files
    from reports.terminal.grades import print_class

    files = GradeFiles(submissions, rubric, out, times)
    with cluster_at(cluster) as workers, progress("grade") as tell:
        record = grade_files(files, not no_sandbox, jobs, workers, tell)
    print_class(record, out, stderr_console() if json else stdout_console())
    if json:
        print_json(record.model_dump(mode="json"))
