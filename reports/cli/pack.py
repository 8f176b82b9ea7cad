"""`minirt pack`: reference images that prove themselves; `pack verify`, `pack approve`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from reports.cli.options import CORES, JobsOption, Json, ScenesArgument
from reports.inputs import names_in
from reports.pack import Only
from reports.terminal.console import print_json, progress, stdout_console


class MakesByDefault(TyperGroup):
    """A group in which what names no command of it are the arguments of `make`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put `make` before anything but a command or a request for help."""
        if args[:1] and args[0] not in (*self.commands, *ctx.help_option_names):
            args = ["make", *args]
        return super().parse_args(ctx, args)


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
    from reports.pack.confirm import PackOptions
    from reports.pack.make import make_pack
    from reports.pack.renewed import pack_summary

    options = PackOptions.of(names_in(reference), names_in(require), jobs)
    with progress("pack") as tell:
        manifest = make_pack(chosen_scenes(scenes), out, options, tell)
    if json:
        print_json(manifest.model_dump(mode="json"))
    else:
        stdout_console().print(pack_summary(out, manifest), soft_wrap=True)


@pack.command(epilog="Example: minirt pack verify pack")
def verify(folder: FolderArgument, jobs: JobsOption = CORES, json: Json = False) -> None:
    """Render a pack's scenes again and compare bit by bit; exit status 1 on one flipped bit."""
    from reports.pack.check import differences
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
    from reports.pack.confirm import PackOptions
    from reports.pack.make import approve_pack
    from reports.pack.renewed import renewed_scenes
    from reports.results.words import count

    options = PackOptions.of(names_in(reference), names_in(require), jobs)
    anew = renewed_scenes(folder, only, scenes, jobs)
    with progress("pack approve") as tell:
        records = approve_pack(folder, anew, who, why, options, tell)
    if json:
        print_json({"approvals": [record.model_dump(mode="json") for record in records]})
    else:
        stdout_console().print(
            f"{folder}: {count(len(records), 'frame')} replaced or added, "
            f"{count(len(anew), 'scene')} looked at",
            soft_wrap=True,
        )
