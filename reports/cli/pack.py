"""`minirt pack`: reference images that prove themselves; `pack verify`, `pack approve`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from reports.cli.options import CORES, JobsOption, Json, ScenesArgument
from reports.inputs import names_in
from reports.terminal.console import print_json, progress, stdout_console

if TYPE_CHECKING:
    from collections.abc import Sequence

    from minirt.scene import Scene
    from reference.source import Reference
    from reports.pack import Manifest


class MakesByDefault(TyperGroup):
    """A group in which what names no command of it are the arguments of `make`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put `make` before anything but a command or a request for help."""
        if args[:1] and args[0] not in (*self.commands, *ctx.help_option_names):
            args = ["make", *args]
        return super().parse_args(ctx, args)


class Only(StrEnum):
    """Which scenes of a pack are made anew."""

    failing = "failing"
    missing = "missing"
    all = "all"


pack = typer.Typer(
    cls=MakesByDefault, no_args_is_help=True, rich_markup_mode=None,
    help="Write reference images that prove themselves: minirt pack [SCENES] -o DIR.",
)  # fmt: skip

FolderArgument = Annotated[Path, typer.Argument(metavar="DIR", help="A pack.")]
ReferenceOption = Annotated[
    str,
    typer.Option(
        "--reference", metavar="NAMES",
        help="Renderers that confirm, separated by commas, as for verify, or none; exact "
        "arithmetic is always asked.",
    ),
]  # fmt: skip
MustOption = Annotated[
    str,
    typer.Option(
        "--require", metavar="NAMES", help="Renderers without whose answer there is no pack."
    ),
]


@pack.command(epilog="Example: minirt pack atlas:one-sphere atlas:glass-ball -o pack")
def make(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="A new folder.")],
    scenes: ScenesArgument = None,
    reference: ReferenceOption = "",
    require: MustOption = "",
    jobs: JobsOption = CORES,
    json: Json = False,
) -> None:
    """Render scenes, have them confirmed, and write a pack.

    Each scene's folder holds the scene, the frame as .npz and .exr, a contact sheet and what is
    uncertain; manifest.json has the SHA-256 of everything, who confirms each quantity, and the
    tolerances. The same pack has the same bytes on every machine.
    """
    from reports.inputs import chosen_scenes
    from reports.pack import make_pack

    chosen, required = _references(reference, require)
    with progress("pack") as tell:
        manifest = make_pack(chosen_scenes(scenes), out, chosen, required, jobs, tell)
    if json:
        print_json(manifest.model_dump(mode="json"))
    else:
        stdout_console().print(_summary(out, manifest), soft_wrap=True)


@pack.command(epilog="Example: minirt pack verify pack")
def verify(folder: FolderArgument, jobs: JobsOption = CORES, json: Json = False) -> None:
    """Render a pack's scenes again and compare bit by bit; exit status 1 on one flipped bit."""
    from reports.pack import differences
    from reports.results.words import count, one_line

    with progress("pack verify") as tell:
        found = list(differences(folder, jobs, tell))
    if json:
        print_json({"pack": str(folder), "differences": [vars(each) for each in found]})
    else:
        for each in found:
            line = f"✗ {one_line(each.scene or 'the pack')}: {one_line(each.what)}"
            stdout_console().print(line, soft_wrap=True)
        words = count(len(found), "difference") if found else "every bit is as it was packed"
        stdout_console().print(f"{folder}: {words}", soft_wrap=True)
    raise typer.Exit(int(bool(found)))


@pack.command(epilog="Example: minirt pack approve pack --who Ada --why 'issue 12'")
def approve(
    folder: FolderArgument,
    who: Annotated[str, typer.Option(help="Who approves.")],
    why: Annotated[str, typer.Option(help="Why the frames may change.")],
    only: Annotated[
        Only,
        typer.Option(
            help="Scenes of the pack that differ now, scenes that it lacks, or both and all others."
        ),
    ] = Only.failing,
    scenes: Annotated[
        list[str] | None, typer.Argument(help="Those it may lack; without any the atlas.")
    ] = None,
    reference: ReferenceOption = "",
    require: MustOption = "",
    jobs: JobsOption = CORES,
    json: Json = False,
) -> None:
    """Replace frames of a pack on purpose, with a record of who, why, and the hashes."""
    from reports.pack import approve_pack
    from reports.results.words import count

    chosen, required = _references(reference, require)
    anew = _anew(folder, only, scenes, jobs)
    with progress("pack approve") as tell:
        records = approve_pack(folder, anew, who, why, chosen, required, jobs, tell)
    if json:
        print_json({"approvals": [record.model_dump(mode="json") for record in records]})
    else:
        stdout_console().print(
            f"{folder}: {count(len(records), 'frame')} replaced or added, "
            f"{count(len(anew), 'scene')} looked at",
            soft_wrap=True,
        )


def _anew(folder: Path, only: Only, scenes: list[str] | None, jobs: int) -> list[Scene]:
    """The scenes that are to be rendered and confirmed anew."""
    from minirt import load_scene
    from reports.inputs import chosen_scenes
    from reports.pack import differences, read_manifest

    manifest = read_manifest(folder)
    packed = {entry.name: folder / entry.folder / "scene.json" for entry in manifest.scenes}
    lacking = (
        [s for s in chosen_scenes(scenes) if s.name not in packed] if only != Only.failing else []
    )
    if only is Only.missing:
        return lacking
    if only is Only.failing:
        differing = {each.scene for each in differences(folder, jobs)}
        packed = {name: path for name, path in packed.items() if name in differing}
    return [load_scene(path) for path in packed.values()] + lacking


def _references(named: str, required: str) -> tuple[Sequence[Reference], tuple[str, ...]]:
    """Who is asked to confirm, and who must answer."""
    from reference.registry import USUAL, choose_references

    must = tuple(each.name for each in choose_references(names_in(required)))
    chosen = [] if named == "none" else names_in(named) or list(USUAL)
    return choose_references([*chosen, *must]), must


def _summary(folder: Path, manifest: Manifest) -> str:
    from reports.results.words import count, listed

    who = listed([*manifest.references, "exact arithmetic"])
    open_ = {
        name
        for entry in manifest.scenes
        for name, quantity in entry.quantities.items()
        if not quantity.confirmed_by
    }
    tail = f"; not checked somewhere: {', '.join(sorted(open_))}" if open_ else ""
    return f"{folder}: {count(len(manifest.scenes), 'scene')}, confirmed by {who}{tail}"
