"""A run of the mutants in the terminal: one row for each, and what was caught."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from minirt.quantities import STAGES
from reference.mutants.floor import Floor
from reference.mutants.run import MutationRun
from reports.results.mutants import mutants_sentence
from reports.terminal.console import stdout_console


def print_mutants(run: MutationRun, floor: Floor) -> None:
    """Print the pixels that each mutant changes, by stage, and what was caught."""
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
    lines = [
        "",
        "Pixels charged to each stage, the first one in which they are wrong.",
        f"{mutants_sentence(run)}.",
        f"Smallest errors caught: {floor.pixels} pixel of a mask; relative {floor.depth:.1e} in "
        f"depth, {floor.angle:.1e} rad in a normal, relative {floor.colour:.1e} in colour.",
    ]
    lines += [f"Not noticed: {', '.join(run.survivors)}"] if run.survivors else []
    return [*lines, *(f"{name} crashed: {reason}" for name, reason in run.crashed.items())]
