"""`minirt verify`: minirt against reference renderers, on many scenes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.cli.history_options import (
    HistoryOption,
    NoHistoryOption,
    known_before,
    opened,
    recorded,
)
from reports.terminal.console import (
    CORES,
    ClusterOption,
    JobsOption,
    Json,
    MutantsOption,
    NoCacheOption,
    RequireOption,
    ScenesArgument,
    names_in,
    print_json,
    progress,
    stderr_console,
    stdout_console,
)

if TYPE_CHECKING:
    from reference.source import Reference


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
    from reports.cli.scene_options import cache_unless, chosen_scenes, cluster_at
    from reports.results.kills import read_kills
    from reports.results.record import results_document
    from reports.run import run_verify
    from reports.terminal.results import print_run

    chosen, required = references_of(names_in(reference), names_in(require))
    loaded = chosen_scenes(scenes)
    kills = None if mutants is None else read_kills(mutants)
    with cluster_at(cluster) as workers, opened(history, no_history, out) as kept:
        before = known_before(kept, loaded, chosen)
        with progress("verify") as tell:
            done = iter(range(1, len(loaded) + 1))
            run = run_verify(
                loaded, chosen, out, jobs, required,
                lambda _, total: tell(next(done), total), timeout=timeout,
                cache=cache_unless(no_cache), before=before, mutants=kills, cluster=workers,
            )  # fmt: skip
        status = recorded(run, kept)
    print_run(run, stderr_console() if json else stdout_console())
    if json:
        print_json(results_document(run))
    raise typer.Exit(status)


def references_of(
    named: list[str], required: list[str]
) -> tuple[tuple[Reference, ...], tuple[str, ...]]:
    """Whom to compare with, and the names of those that must answer."""
    from reference.registry import USUAL, choose_references

    must = tuple(each.name for each in choose_references([*named, *required]))
    return choose_references([*(named or USUAL), *must]), must
