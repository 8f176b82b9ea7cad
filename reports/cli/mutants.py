"""`minirt mutants`: whether the checks notice every mistake in the catalogue."""

from __future__ import annotations

from typing import Annotated

import typer

from reports.cli.options import CORES, ClusterOption, Json
from reports.inputs import names_in
from reports.terminal.console import print_json, progress


def mutants(
    only: Annotated[
        str,
        typer.Option(metavar="NAMES", help="Mutants to run, separated by commas; all without it."),
    ] = "",
    jobs: Annotated[int, typer.Option("--jobs", "-j", min=1, help="Processes.")] = CORES,
    cluster: ClusterOption = None,
    json: Json = False,
) -> None:
    """Show that the checks notice wrong versions of the lecture's rules.

    Runs every wrong version, and the right one, through the checks that renderers go through:
    each must fail, first in the stage that it breaks, and the right one must not.
    """
    from reference.mutants.floor import sensitivity_floor
    from reference.mutants.run import chosen_mutants, run_mutants
    from reports.inputs import cluster_at
    from reports.results.mutants import mutants_document, mutants_status

    chosen = chosen_mutants(names_in(only))
    with cluster_at(cluster) as workers, progress("mutants") as tell:
        found = run_mutants(chosen, jobs, workers, tell)
    floor = sensitivity_floor()
    if json:
        print_json(mutants_document(found, floor))
    else:
        from reports.terminal.mutants import print_mutants

        print_mutants(found, floor)
    raise typer.Exit(mutants_status(found))
