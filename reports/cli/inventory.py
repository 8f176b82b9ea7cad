"""`minirt scenes`, `rules`, `doctor`: what ships, what proves each rule, what is installed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.cli.options import Json, RequireOption
from reports.inputs import names_in
from reports.terminal.console import indented, print_json, progress, stdout_console

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from minirt.scene import Scene
    from reference.traceability import Passed, RuleTrace


def scenes(
    name: Annotated[str | None, typer.Argument(help="Show this scene's paragraphs.")] = None,
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON Schema of the scenes' format.")
    ] = False,
    json: Json = False,
) -> None:
    """List the scenes that ship with minirt, or show one.

    What each proves, and the rules it exercises.
    """
    from minirt import load_scene
    from minirt.scene_file.atlas import atlas_names

    if schema:
        from minirt.scene_file.schema import scene_schema

        print_json(scene_schema())
    elif name is not None:
        scene = load_scene(f"atlas:{name.removeprefix('atlas:')}")
        print_json(_paragraphs(scene)) if json else _show_scene(scene)
    else:
        every = [load_scene(f"atlas:{each}") for each in atlas_names()]
        if json:
            print_json({"scenes": [_scene_line(scene) for scene in every]})
        else:
            _list_scenes(every)


def _scene_line(scene: Scene) -> dict[str, Any]:
    return {"name": scene.name, "about": scene.about, "rules": list(scene.rules)}


def _paragraphs(scene: Scene) -> dict[str, Any]:
    return _scene_line(scene) | {
        "proves": scene.proves,
        "failure_means": scene.failure_means,
        "floor": scene.floor and {"certain": scene.floor[0], "why": scene.floor[1]},
        "nx": scene.screen.nx,
        "ny": scene.screen.ny,
        "objects": len(scene.objects),
    }


def _list_scenes(every: list[Scene]) -> None:
    from rich.text import Text

    console = stdout_console()
    for scene in every:
        rules = " ".join(scene.rules)
        console.print(Text.assemble((scene.name, "bold"), "  ", (rules, "dim")), soft_wrap=True)
        console.print(indented(scene.about, 2, console))


def _show_scene(scene: Scene) -> None:
    console, screen = stdout_console(), scene.screen
    console.print(scene.name, style="bold")
    console.print(indented(scene.about, 0, console))
    console.print(
        f"{screen.nx} × {screen.ny}, objects: {len(scene.objects)}, rules: {' '.join(scene.rules)}",
        style="dim",
    )
    parts = {"What it proves": scene.proves, "What a failure usually means": scene.failure_means}
    if scene.floor:
        parts[f"Certain pixels: at least {100 * scene.floor[0]:.4g} %"] = scene.floor[1]
    for title, text in parts.items():
        console.print()
        console.print(title, style="bold")
        console.print(indented(text, 2, console))


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
        _print_rules(traced, with_references=results is not None)


def _passed(path: Path) -> Iterator[Passed]:
    """What the run of a results.json has compared, and found right."""
    from reports.results.reading import read_results

    for scene in read_results(path).scenes:
        for answer in scene.references:
            for check in answer.checks:
                if check.state == "passed" and check.compared:
                    yield scene.name, answer.reference, check.quantity


def _print_rules(traced: Sequence[RuleTrace], with_references: bool) -> None:
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


def doctor(
    require: RequireOption = "",
    json: Json = False,
) -> None:
    """Show what is installed, and what brings what is missing.

    Every reference renderer is tried on a tiny scene.
    """
    from reports.doctor import examine
    from reports.terminal.doctor import print_examination

    with progress("trying the reference renderers") as tell:
        found = examine(names_in(require), tell)
    if json:
        print_json(found.document())
    else:
        print_examination(found)
    if not found.healthy:
        raise typer.Exit(3)
