"""`minirt rules`: from each rule to its code, its scenes, its checks and who compared it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.cli.options import Json
from reports.terminal.console import print_json, stdout_console

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from reference.traceability import Passed, RuleTrace


def rules(
    results: Annotated[
        Path | None,
        typer.Option(
            "--results",
            metavar="FILE",
            help="A results.json of minirt verify: adds who compared each rule, and where.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Show what proves each of the lecture's rules.

    The entries of minirt.SLIDES, the scenes of the atlas and the quantities, made from the code.
    """
    from minirt import load_scene
    from minirt.scene_file.atlas import atlas_names
    from reference.traceability import trace_rules

    passed = list(_passed(results)) if results else []
    traced = trace_rules([load_scene(f"atlas:{name}") for name in atlas_names()], passed)
    if json:
        print_json({"rules": [vars(row) for row in traced]})
    else:
        _print(traced, with_references=results is not None)


def _passed(path: Path) -> Iterator[Passed]:
    """What the run of a results.json has compared, and found right."""
    from reports.results.reading import read_results

    for scene in read_results(path).scenes:
        for answer in scene.references:
            for check in answer.checks:
                if check.state == "passed" and check.compared:
                    yield scene.name, answer.reference, check.quantity


def _print(traced: Sequence[RuleTrace], with_references: bool) -> None:
    from rich.table import Table
    from rich.text import Text

    from reports.results.words import RULE_NAMES

    table = Table(box=None, pad_edge=False, padding=(0, 2, 1, 0))
    judged = "judged by, on scenes" if with_references else "judged by"
    for heading in ("rule", "what it says", judged, "scenes"):
        table.add_column(heading)
    if with_references:
        table.add_column("compared by, on scenes")
    for row in traced:
        judges = [f"{q} {n}" if with_references else q for q, n in row.checked.items()]
        cells: list[Any] = [row.rule, RULE_NAMES[row.rule], ", ".join(judges)]
        cells.append(f"{len(row.scenes)}: " + ", ".join(row.scenes))
        if with_references:
            cells.append("\n".join(f"{who} {count}" for who, count in row.compared.items()) or "–")
        table.add_row(*(Text(cell) for cell in cells))
    stdout_console().print(table)
