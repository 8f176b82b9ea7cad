"""`minirt verify`: minirt against reference renderers, on many scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from reports.cli.options import (
    CORES,
    ClusterOption,
    HistoryOption,
    JobsOption,
    Json,
    MutantsOption,
    NoCacheOption,
    NoHistoryOption,
    RequireOption,
    ScenesArgument,
)
from reports.inputs import names_in
from reports.terminal.console import (
    print_json,
    print_lines,
    progress,
    stderr_console,
    stdout_console,
)


def verify(
    scenes: ScenesArgument = None,
    reference: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help="Renderers to compare with, separated by commas: mitsuba-llvm, mitsuba-scalar "
            "(or mitsuba for the first that works), mitsuba-cli, pyrender, embree, povray; "
            "without it all but mitsuba-scalar. What is named here is required.",
        ),
    ] = "",
    require: RequireOption = "",
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where the reports go.")
    ] = Path("report"),
    jobs: JobsOption = CORES,
    timeout: Annotated[
        int, typer.Option(min=1, metavar="SECONDS", help="For a reference and a scene.")
    ] = 300,
    mutants: MutantsOption = None,
    no_cache: NoCacheOption = False,
    history: HistoryOption = "",
    no_history: NoHistoryOption = False,
    cluster: ClusterOption = None,
    json: Json = False,
) -> None:
    """Compare minirt with reference renderers.

    Renders every scene here and there, compares every quantity and leaves a report.
    """
    from reference.jobs.isolate import get_ready

    get_ready("reports.run")
    from reference.verify.options import Options
    from reports.history.recording import HistoryTarget, recorded_run
    from reports.inputs import cache_unless, chosen_scenes, cluster_at, references_of
    from reports.results.mutants import read_kill_matrix
    from reports.results.record import results_document
    from reports.run import RunOptions
    from reports.terminal.results import print_run

    chosen, required = references_of(names_in(reference), names_in(require))
    loaded = chosen_scenes(scenes)
    matrix = None if mutants is None else read_kill_matrix(mutants)
    comparison = Options(timeout=timeout, jobs=jobs, cache=cache_unless(no_cache))
    options = RunOptions(comparison, required, mutants=matrix)
    target = HistoryTarget(history, not no_history)
    with cluster_at(cluster) as workers, progress("verify") as tell:
        found = recorded_run(loaded, chosen, out, options, target, tell, workers)
    print_lines(found.remarks, stderr_console())
    print_run(found.run, stderr_console() if json else stdout_console())
    if json:
        print_json(results_document(found.run))
    raise typer.Exit(found.exit_status)
