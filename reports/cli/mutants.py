"""`minirt mutants`: whether the checks notice every mistake in the catalogue."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Annotated

import typer

from reports.cli.options import ClusterOption, Json
from reports.inputs import names_in
from reports.terminal.console import print_json, progress, stdout_console

if TYPE_CHECKING:
    from reference.mutants.floor import Floor
    from reference.mutants.run import MutationRun


def mutants(
    only: Annotated[
        str,
        typer.Option(metavar="NAMES", help="Mutants to run, separated by commas; all without it."),
    ] = "",
    jobs: Annotated[int, typer.Option("--jobs", "-j", min=1, help="Processes.")] = len(
        os.sched_getaffinity(0)
    ),
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
        _print(found, floor)
    raise typer.Exit(mutants_status(found))


def _print(run: MutationRun, floor: Floor) -> None:
    from rich.table import Table
    from rich.text import Text

    from minirt.quantities import STAGES

    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    shown = {"reflection": "refl", "refraction": "refr", "secondary": "next", "normal": "norm"}
    table.add_column("mutant", no_wrap=True)
    for stage in STAGES:
        table.add_column(shown.get(stage, stage), justify="right", no_wrap=True)
    rows = [("the lecture's own rules", run.original, run.original.killed)]
    rows += [
        (f"{row.rule:3} {row.mutant}", row, not (row.killed and row.right_stage))
        for row in run.mutants
    ]
    for name, row, wrong in rows:
        cells = [str(row.charged[stage] or "·") for stage in STAGES]
        table.add_row(Text(name, style="bold red" if wrong else ""), *cells)
    console = stdout_console()
    console.print(table)
    for line in _summary(run, floor):
        console.print(line, soft_wrap=True)


def _summary(run: MutationRun, floor: Floor) -> list[str]:
    from reports.results.mutants import mutants_sentence

    lines = [
        "",
        "Pixels charged to each stage, the first one in which they are wrong.",
        f"{mutants_sentence(run)}.",
        f"Smallest errors caught: {floor.pixels} pixel of a mask; relative {floor.depth:.1e} in "
        f"depth, {floor.angle:.1e} rad in a normal, relative {floor.colour:.1e} in colour.",
    ]
    lines += [f"Not noticed: {', '.join(run.survivors)}"] if run.survivors else []
    return [*lines, *(f"{name} crashed: {reason}" for name, reason in run.crashed.items())]
