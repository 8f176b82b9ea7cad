"""`minirt scenes`: what is in the atlas, and the scenes' format."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.console import Json, answers, print_json

if TYPE_CHECKING:
    from minirt.scene import Scene


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
    from minirt.scene import atlas_names

    if schema:
        from minirt.schema import scene_schema

        print_json(scene_schema())
    elif name is not None:
        scene = load_scene(f"atlas:{name.removeprefix('atlas:')}")
        print_json(_paragraphs(scene)) if json else _show(scene)
    else:
        every = [load_scene(f"atlas:{each}") for each in atlas_names()]
        print_json({"scenes": [_line(scene) for scene in every]}) if json else _list(every)


def _line(scene: Scene) -> dict[str, Any]:
    return {"name": scene.name, "about": scene.about, "rules": list(scene.rules)}


def _paragraphs(scene: Scene) -> dict[str, Any]:
    return _line(scene) | {
        "proves": scene.proves,
        "failure_means": scene.failure_means,
        "floor": scene.floor and {"certain": scene.floor[0], "why": scene.floor[1]},
        "nx": scene.screen.nx,
        "ny": scene.screen.ny,
        "objects": len(scene.objects),
    }


def _list(every: list[Scene]) -> None:
    from rich.table import Table

    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(ratio=1)
    for scene in every:
        table.add_row(scene.name, scene.about)
        table.add_row("", " ".join(scene.rules), style="dim")
    answers().print(table)


def _show(scene: Scene) -> None:
    from rich.padding import Padding

    console, screen = answers(), scene.screen
    console.print(scene.name, style="bold")
    console.print(scene.about)
    console.print(
        f"{screen.nx} × {screen.ny}, objects: {len(scene.objects)}, rules: {' '.join(scene.rules)}",
        style="dim",
    )
    parts = {"What it proves": scene.proves, "What a failure usually means": scene.failure_means}
    if scene.floor:
        parts[f"Certain pixels: at least {scene.floor[0]:.1%}"] = scene.floor[1]
    for title, text in parts.items():
        console.print()
        console.print(title, style="bold")
        console.print(Padding(text, (0, 0, 0, 2)))
