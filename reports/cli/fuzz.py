"""`minirt fuzz`: random scenes against references; what fails is shrunk and written down."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from reports.cli.options import ClusterOption, Json
from reports.cli.subject_options import takes_subject
from reports.gate.subject import Subject
from reports.inputs import names_in
from reports.terminal.console import (
    print_json,
    print_lines,
    progress,
    stderr_console,
    stdout_console,
)


@takes_subject
def fuzz(
    reference: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help="Renderers to judge, separated by commas, as for verify; all are required. Those "
            "that verify uses, unless an implementation is named.",
        ),
    ] = "",
    *,
    subject: Subject,
    seed: Annotated[
        int, typer.Option(min=0, max=2**32 - 1, help="Scene k of a seed is always the same.")
    ] = 0,
    scenes: Annotated[int, typer.Option(min=1, help="At most so many scenes.")] = 100,
    time: Annotated[
        float, typer.Option(min=1, metavar="SECONDS", help="After which no scene is begun.")
    ] = 600,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where failures are written.")
    ] = Path("fuzz"),
    cluster: ClusterOption = None,
    json: Json = False,
) -> None:
    """Judge renderers, or another implementation, on random scenes.

    A failure is shrunk to the smallest scene that fails in the same first stage, and written as a
    scene file, an explanation of its pixel, and a test in Python and in C++.
    """
    from reports.fuzz.campaign import (
        campaign_document,
        campaign_remarks,
        campaign_summary,
        exit_status,
    )
    from reports.fuzz.run import FuzzOptions, run_fuzz
    from reports.inputs import cluster_at

    options = FuzzOptions(names_in(reference), subject, seed, scenes, time, out)
    console = stderr_console()

    def remark(line: str) -> None:
        print_lines([line], console)

    with cluster_at(cluster) as workers, progress("fuzz") as tell:
        found, cases = run_fuzz(options, workers, tell, remark)
    print_lines(campaign_remarks(found), console)
    if json:
        print_json(campaign_document(found, cases))
    else:
        print_lines([campaign_summary(found)], stdout_console())
    raise typer.Exit(exit_status(found))
