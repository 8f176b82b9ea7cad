"""`minirt render`: a scene as a file."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.cli.options import Json, SceneArgument
from reports.terminal.console import print_json, progress, stderr_console

if TYPE_CHECKING:
    from minirt.frame import Frame
    from minirt.scene import Scene

#: Formats of any number of quantities; without a suffix, or with .d, a folder.
_FRAMES = (".exr", ".npz", "", ".d")
#: Formats of a single quantity.
_PICTURES = (".png", ".pfm", ".npy")


def render(
    scene: SceneArgument,
    out: Annotated[
        str,
        typer.Option(
            "--out", "-o", metavar="PATH",
            help="Where to write: .exr, .npz or a folder for any quantities; .png, .pfm or .npy "
            "for one.",
        ),
    ],
    quantities: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES", show_default=False,
            help="Which quantities, separated by commas, e.g. hit,depth,color; without it all, "
            "or color for a picture. Only what they need is traced.",
        ),
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(
            metavar="NXxNY", show_default=False,
            help="Columns and rows of pixels instead of the scene's, on the same virtual screen.",
        ),
    ] = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Render a scene by the slides' rules."""
    import minirt

    loaded = minirt.load_scene(scene)
    if size is not None:
        loaded = resized(loaded, size)
    _require_format(out)
    names = _chosen(quantities, out)
    begin = time.perf_counter()
    with progress("render") as tell:
        frame = minirt.render(loaded, quantities=names, progress=tell)
    seconds = time.perf_counter() - begin
    writer(out, names)(frame)
    _report(frame, out, seconds, json)


def resized(scene: Scene, size: str) -> Scene:
    """The scene with another number of pixels, ``640x480``, on the same virtual screen.

    Raises
    ------
    InputError
        Not two whole numbers.
    SceneError
        Numbers that a scene cannot have.
    """
    from minirt import load_scene
    from minirt.errors import InputError

    columns, x, rows = size.lower().replace("×", "x").partition("x")
    if not (x and columns.isdecimal() and rows.isdecimal()):
        raise InputError("not a size", where="--size", got=repr(size)[:80], expected="as 640x480")
    document = scene.to_dict()
    document["screen"] |= {"nx": int(columns[:9]), "ny": int(rows[:9])}
    return load_scene(document, scene.folder)


def writer(out: str, names: tuple[str, ...] | None) -> Callable[[Frame], None]:
    """What writes a frame to a path of this name."""
    from converters.frames.io import write_frame, write_image

    if names is not None and Path(out).suffix.lower() in _PICTURES:
        return lambda frame: write_image(frame, names[0], out)
    return lambda frame: write_frame(frame, out)


def _require_format(out: str) -> None:
    """Refuse a name that no format goes by, before anything is rendered."""
    from minirt.errors import InputError

    suffix = Path(out).suffix.lower()
    if suffix not in (*_FRAMES, *_PICTURES):
        raise InputError(
            "unknown format",
            where=out,
            got=suffix,
            expected=".exr, .npz or a folder for any quantities; .png, .pfm or .npy for one",
        )


def _chosen(quantities: str | None, out: str) -> tuple[str, ...] | None:
    """Names of the quantities to render; None for all."""
    from minirt.errors import InputError
    from minirt.render import chosen_quantities

    picture = Path(out).suffix.lower() in _PICTURES
    if quantities is None:
        return ("color",) if picture else None
    names = chosen_quantities(quantities)
    if picture and len(names) > 1:
        raise InputError(
            "a picture holds one quantity",
            where="--quantities",
            got=", ".join(names),
            expected="one of them, or an .exr, an .npz or a folder",
        )
    return names


def _report(frame: Frame, out: str, seconds: float, json: bool) -> None:
    from reports.results.words import count, one_line

    ny, nx = frame.size
    megapixels = nx * ny / 1e6
    document: dict[str, Any] = {
        "out": out,
        "scene": frame.meta["scene"],
        "sceneSha256": frame.meta["sceneSha256"],
        "version": frame.meta["version"],
        "nx": nx,
        "ny": ny,
        "quantities": list(frame),
        "seconds": seconds,
        "megapixels_per_second": megapixels / seconds,
    }
    if json:
        print_json(document)
    what = next(iter(frame)) if len(frame) == 1 else count(len(frame), "quantity", "quantities")
    stderr_console().print(
        f"{one_line(out)}: {one_line(frame.meta['scene'])}, {nx} × {ny}, {what}; "
        f"{seconds:.2f} s, {megapixels / seconds:.2f} Mpixel/s",
        soft_wrap=True,
    )
