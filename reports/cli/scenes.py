"""`minirt scenes`: what is in the atlas, and the scenes' format."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.cli.options import Json
from reports.terminal.console import indented, print_json, stdout_console

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
    from minirt.scene_file.atlas import atlas_names

    if schema:
        from minirt.scene_file.schema import scene_schema

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
    from rich.text import Text

    console = stdout_console()
    for scene in every:
        rules = " ".join(scene.rules)
        console.print(Text.assemble((scene.name, "bold"), "  ", (rules, "dim")), soft_wrap=True)
        console.print(indented(scene.about, 2, console))


def _show(scene: Scene) -> None:
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
