"""`minirt export`: a scene in another program's language."""

from __future__ import annotations

import shlex
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.cli.options import Json, SceneArgument
from reports.terminal.console import print_json, stderr_console, stdout_console

if TYPE_CHECKING:
    from minirt.scene import Scene


class Language(StrEnum):
    """Whose language."""

    mitsuba = "mitsuba"
    povray = "povray"
    gltf = "gltf"
    obj = "obj"


def export(
    scene: SceneArgument,
    to: Annotated[Language, typer.Option(help="Whose language.")],
    out: Annotated[
        Path,
        typer.Option(
            "--out", "-o", metavar="PATH",
            help="mitsuba, obj: a new or empty folder, or an earlier export; gltf, povray: a file.",
        ),
    ],
    json: Json = False,
) -> None:  # fmt: skip
    """Write a scene in another program's language.

    Prints the command that renders it, or the file to open where any viewer will do.
    """
    import minirt
    from reports.results.words import count

    files, answer, is_command = _EXPORTS[to](minirt.load_scene(scene), out)
    if json:
        named = [str(path) for path in files]
        command = answer if is_command else None
        print_json({"to": to.value, "files": named, "command": command})
    else:
        use = "Render them with:" if is_command else "Any viewer opens:"
        stderr_console().print(f"{out}: {count(len(files), 'file')}. {use}", soft_wrap=True)
        stdout_console().print(answer, soft_wrap=True)


def _mitsuba(scene: Scene, out: Path) -> tuple[list[Path], str, bool]:
    from converters.mitsuba.scene import export_mitsuba

    export_mitsuba(scene, out)
    files = [str(out / name) for name in ("scene.xml", "scene.exr")]
    command = ["mitsuba", "-m", "scalar_rgb", files[0], "-o", files[1]]
    return sorted(out.iterdir()), shlex.join(command), True


def _povray(scene: Scene, out: Path) -> tuple[list[Path], str, bool]:
    from converters.povray.scene import export_povray

    export_povray(scene, out)
    size = [f"+W{scene.screen.nx}", f"+H{scene.screen.ny}"]
    command = ["povray", f"+I{out}", f"+O{out.with_suffix('.png')}", *size, "-A", "-D"]
    return [out], shlex.join(command), True


def _gltf(scene: Scene, out: Path) -> tuple[list[Path], str, bool]:
    from converters.gltf.scene import export_gltf

    export_gltf(scene, out)
    return [out], str(out), False


def _obj(scene: Scene, out: Path) -> tuple[list[Path], str, bool]:
    from converters.obj import export_obj

    export_obj(scene, out)
    return sorted(out.iterdir()), str(out / "scene.obj"), False


#: What writes each language: gives the files, and the command or the file that leads to a picture.
_EXPORTS = {
    Language.mitsuba: _mitsuba,
    Language.povray: _povray,
    Language.gltf: _gltf,
    Language.obj: _obj,
}
