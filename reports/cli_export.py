"""`minirt export`: a scene in another program's language."""

from __future__ import annotations

import shlex
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from reports.console import Json, SceneArgument, answers, people, print_json


class Language(StrEnum):
    """Whose language."""

    mitsuba = "mitsuba"


def export(
    scene: SceneArgument,
    to: Annotated[Language, typer.Option(help="Whose language.")],
    out: Annotated[
        Path,
        typer.Option(
            "--out", "-o", metavar="DIR", help="A new or empty folder, or an earlier export."
        ),
    ],
    json: Json = False,
) -> None:
    """Write a scene in another renderer's language.

    Prints the command that renders it.
    """
    import minirt
    from converters.mitsuba import export_mitsuba
    from reports.words import count

    export_mitsuba(minirt.load_scene(scene), out)
    files = sorted(str(path) for path in out.iterdir())
    picture = out.with_name(out.resolve().name + ".exr")
    scene_file = str(out / "scene.xml")
    command = shlex.join(["mitsuba", "-m", "scalar_rgb", scene_file, "-o", str(picture)])
    if json:
        print_json({"to": to.value, "files": files, "command": command})
    else:
        people().print(f"{out}: {count(len(files), 'file')}. Render them with:", soft_wrap=True)
        answers().print(command, soft_wrap=True)
