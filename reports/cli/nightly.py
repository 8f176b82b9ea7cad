"""`minirt nightly`: all that a night should try, and a page of how it went from night to night."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.cli.options import (
    CORES,
    ClusterOption,
    HistoryOption,
    JobsOption,
    Json,
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

if TYPE_CHECKING:
    from reference.jobs.cluster import Cluster
    from reports.nightly.options import NightlyOptions


def nightly(
    scenes: ScenesArgument = None,
    reference: Annotated[
        str, typer.Option(metavar="NAMES", help="Renderers to compare with, as for verify.")
    ] = "",
    require: RequireOption = "",
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where all nights go.")
    ] = Path("nights"),
    budget: Annotated[
        str, typer.Option(metavar="TIME", help="For random scenes, with a new seed: 90s, 20m, 2h.")
    ] = "20m",
    mutants: Annotated[
        str, typer.Option(metavar="NAMES", help="Mutants to run, separated by commas; all.")
    ] = "",
    keep: Annotated[int, typer.Option(min=1, metavar="N", help="Nights whose folders stay.")] = 30,
    notify: Annotated[
        str,
        typer.Option(
            metavar="'CMD'",
            help="A command that gets the summary on its standard input; MINIRT_EXIT_STATUS and "
            "MINIRT_NIGHT, the night's folder, are in its environment.",
        ),
    ] = "",
    jobs: JobsOption = CORES,
    timeout: Annotated[
        int, typer.Option(min=1, metavar="SECONDS", help="For a reference and a scene.")
    ] = 300,
    history: HistoryOption = "",
    cluster: ClusterOption = None,
    json: Json = False,
) -> None:
    """Verify, fuzz with a new seed, run the mutants; keep the history and a landing page.

    Each night has a folder, DIR/index.html shows them all. A night that was killed goes on with
    what is missing when the same command runs again within a day.
    """
    from reference.mutants.run import chosen_mutants
    from reports.inputs import (
        chosen_scenes,
        cluster_at,
        command_words,
        references_of,
        seconds_in,
    )
    from reports.nightly.options import NightlyOptions

    seconds, command = seconds_in(budget, "--budget"), command_words(notify, "--notify")
    chosen, required = references_of(names_in(reference), names_in(require))
    named = names_in(mutants)
    chosen_mutants(named)
    options = NightlyOptions(
        chosen_scenes(scenes), chosen, required, seconds, tuple(named), jobs, timeout, out,
        history, keep, command,
    )  # fmt: skip
    with cluster_at(cluster) as workers:
        raise typer.Exit(_run(options, workers, json))


def _run(options: NightlyOptions, cluster: Cluster | None, json: bool) -> int:
    """Run what a night should try, and print how it went; the exit status."""
    from reports.nightly.run import finish, nightly_run, run_lines
    from reports.nightly.steps import run_steps

    with nightly_run(options) as (night, kept):
        print_lines([f"night: {night.folder}"], stderr_console())
        with progress("nightly") as tell:
            on_cluster = replace(options, cluster=cluster)
            run_steps(night, on_cluster, kept, lambda _, done, total: tell(int(done), int(total)))
        status, lines = finish(night, options, kept)
        print_lines(lines, stderr_console())
        if json:
            record = night.record.model_dump(mode="json")
            print_json({**record, "folder": str(night.folder), "exit_status": status})
        else:
            print_lines(run_lines(night, options), stdout_console())
    return status
