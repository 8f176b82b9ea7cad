"""`minirt export`: a scene in another program's language."""

from __future__ import annotations

import shlex
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from reports.console import Json, SceneArgument, answers, people, print_json

if TYPE_CHECKING:
    from minirt.scene import Scene

#: The files of an export, and the command that renders them.
Written: TypeAlias = tuple[list[str], list[str]]


class Language(StrEnum):
    """Whose language."""

    mitsuba = "mitsuba"
    povray = "povray"


def export(
    scene: SceneArgument,
    to: Annotated[Language, typer.Option(help="Whose language.")],
    out: Annotated[
        Path,
        typer.Option(
            "--out",
            "-o",
            metavar="PATH",
            help="For mitsuba a new or empty folder, or an earlier export; for povray a file.",
        ),
    ],
    json: Json = False,
) -> None:
    """Write a scene in another renderer's language.

    Prints the command that renders it.
    """
    import minirt
    from reports.words import count

    files, command = _WRITE[to](minirt.load_scene(scene), out)
    if json:
        print_json({"to": to.value, "files": files, "command": shlex.join(command)})
    else:
        people().print(f"{out}: {count(len(files), 'file')}. Render them with:", soft_wrap=True)
        answers().print(shlex.join(command), soft_wrap=True)


def _mitsuba(scene: Scene, out: Path) -> Written:
    from converters.mitsuba import export_mitsuba

    export_mitsuba(scene, out)
    files = sorted(str(path) for path in out.iterdir())
    picture = out.with_name(out.resolve().name + ".exr")
    return files, ["mitsuba", "-m", "scalar_rgb", str(out / "scene.xml"), "-o", str(picture)]


def _povray(scene: Scene, out: Path) -> Written:
    from converters.povray import export_povray

    export_povray(scene, out)
    size = [f"+W{scene.screen.nx}", f"+H{scene.screen.ny}"]
    return [str(out)], ["povray", f"+I{out}", f"+O{out.with_suffix('.png')}", *size, "-A", "-D"]


_WRITE = {Language.mitsuba: _mitsuba, Language.povray: _povray}
