"""`minirt mutants`: whether the checks notice every mistake in the catalogue."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.cli.options import ClusterOption, Json
from reports.inputs import names_in
from reports.terminal.console import print_json, progress, stdout_console

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from reference.jobs.cluster import Cluster
    from reference.mutants.floor import Floor
    from reference.mutants.matrix import Kill


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
    from reports.inputs import cluster_at

    chosen = chosen_mutants(names_in(only))
    with cluster_at(cluster) as workers:
        kills, crashed = run_mutants(chosen, jobs, workers)
    honest, wrong = kills[0], kills[1:]
    floor = sensitivity_floor()
    if json:
        print_json(mutants_document(honest, wrong, floor, crashed))
    else:
        _print(honest, wrong, floor, crashed)
    raise typer.Exit(mutants_status(honest, wrong, crashed))


def chosen_mutants(names: Sequence[str]) -> list[str]:
    """The lecture's own rules, and the mutants of these names or all.

    Raises
    ------
    InputError
        An unknown name.
    """
    from minirt.errors import InputError
    from reference.mutants import CATALOGUE, HONEST

    unknown = [name for name in names if name not in CATALOGUE]
    if unknown:
        raise InputError(
            "no such mutant",
            got=", ".join(unknown)[:200],
            expected="a name that minirt mutants prints",
        )
    return [HONEST.name, *(names or CATALOGUE)]


def run_mutants(
    names: Sequence[str], jobs: int, cluster: Cluster | None = None
) -> tuple[list[Kill], dict[str, str]]:
    """The rows, in order, each in a child process or on a cluster; and those that crashed there.

    Raises
    ------
    ReferenceError
        The first of them, the lecture's own rules, crashed on the cluster.
    """
    with progress("mutants") as tell:
        if cluster is None:
            return _rows_here(names, jobs, tell), {}
        return _rows_on(cluster, names, tell)


def _rows_here(names: Sequence[str], jobs: int, tell: Callable[[int, int], None]) -> list[Kill]:
    from reference.jobs.isolate import Workers
    from reference.mutants.matrix import kill

    rows: list[Kill] = []
    with Workers(min(jobs, len(names))) as workers:
        started = [workers.submit(None, kill, name) for name in names]
        for job in started:
            outcome = job.outcome()
            if outcome.state != "done":
                raise RuntimeError(f"a mutant could not be run: {outcome.reason}")
            rows.append(outcome.value)
            tell(len(rows), len(names))
    return rows


def _rows_on(
    cluster: Cluster, names: Sequence[str], tell: Callable[[int, int], None]
) -> tuple[list[Kill], dict[str, str]]:
    from minirt.errors import ReferenceError
    from reference.mutants.matrix import kill

    ended = {}
    for number, outcome in cluster.outcomes((kill, (name,)) for name in names):
        ended[names[number]] = outcome
        tell(len(ended), len(names))
    rows = [ended[name].value for name in names if ended[name].state == "done"]
    crashed = {name: ended[name].reason for name in names if ended[name].state != "done"}
    if names[0] in crashed:
        raise ReferenceError("the lecture's own rules could not be run", got=crashed[names[0]])
    return rows, crashed


def mutants_status(honest: Kill, wrong: Sequence[Kill], crashed: Mapping[str, str]) -> int:
    """1 where one is not noticed or the right one is accused; else 3 where one crashed; else 0."""
    if honest.killed or not all(row.killed for row in wrong):
        return 1
    return 3 if crashed else 0


def mutants_document(
    honest: Kill, wrong: Sequence[Kill], floor: Floor, crashed: Mapping[str, str]
) -> dict[str, Any]:
    """The kill matrix as JSON data."""
    from reports.results.json_model import spelled

    rows = [
        vars(row) | {"failed": list(row.failed), "killed": row.killed, "found": row.found}
        for row in wrong
    ]
    return {
        "mutants": rows,
        "killed": sum(row.killed for row in wrong),
        "right_stage": sum(row.right_stage for row in wrong),
        "false_alarms": len(honest.failed),
        "floor": {name: spelled(value) for name, value in vars(floor).items()},
        **({"crashed": dict(crashed)} if crashed else {}),
    }


def _print(honest: Kill, wrong: Sequence[Kill], floor: Floor, crashed: Mapping[str, str]) -> None:
    from rich.table import Table
    from rich.text import Text

    from minirt.quantities import STAGES

    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    shown = {"reflection": "refl", "refraction": "refr", "secondary": "next", "normal": "norm"}
    table.add_column("mutant", no_wrap=True)
    for stage in STAGES:
        table.add_column(shown.get(stage, stage), justify="right", no_wrap=True)
    for row in (honest, *wrong):
        name = f"{row.rule:3} {row.mutant}" if row is not honest else "the lecture's own rules"
        cells = [str(row.charged[stage] or "·") for stage in STAGES]
        table.add_row(Text(name, style="bold red" if _odd(row, honest) else ""), *cells)
    console = stdout_console()
    console.print(table)
    for line in _summary(honest, wrong, floor, crashed):
        console.print(line, soft_wrap=True)


def _odd(row: Kill, honest: Kill) -> bool:
    """Whether a row is not as it should be."""
    return row.killed if row is honest else not (row.killed and row.right_stage)


def mutants_sentence(honest: Kill, wrong: Sequence[Kill], crashed: Mapping[str, str]) -> str:
    """How many were killed, by which stage, and how many could not be run."""
    killed, right = sum(row.killed for row in wrong), sum(row.right_stage for row in wrong)
    return (
        f"{killed} of {len(wrong)} mutants killed, {right} by the stage that they really break; "
        f"false alarms on the lecture's own rules: {len(honest.failed)} of {honest.scenes} scenes"
        + (f"; {len(crashed)} crashed" if crashed else "")
    )


def _summary(
    honest: Kill, wrong: Sequence[Kill], floor: Floor, crashed: Mapping[str, str]
) -> list[str]:
    survivors = [row.mutant for row in wrong if not row.killed]
    lines = [
        "",
        "Pixels charged to each stage, the first one in which they are wrong.",
        f"{mutants_sentence(honest, wrong, crashed)}.",
        f"Smallest errors caught: {floor.pixels} pixel of a mask; relative {floor.depth:.1e} in "
        f"depth, {floor.angle:.1e} rad in a normal, relative {floor.colour:.1e} in colour.",
    ]
    lines += [f"Not noticed: {', '.join(survivors)}"] if survivors else []
    return [*lines, *(f"{name} crashed: {reason}" for name, reason in crashed.items())]
