"""A frame as a folder of single images, for programs that can write nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from converters.frames.casts import Size
from converters.frames.npz import meta_text, parse_meta, read_npy
from converters.frames.single_image import SUFFIXES, read_single, write_single
from minirt.errors import InputError
from minirt.frame import Array, Frame
from minirt.quantities import QUANTITIES

META_FILE = "meta.json"
#: An image for people, beside the numbers of `color`.
_VIEWED = "color.png"
_MAX_META_BYTES = 2**20


def write_folder(frame: Frame, folder: Path, suffixes: Mapping[str, str]) -> None:
    """Write each quantity into an empty folder. Not atomic; see `converters.frames.io`.

    Where `suffixes` names no format, masks become PNG: `hit`, and `shadow` if the frame has `hit`,
    since black stands for both 0 and −1, nothing hit. Everything else becomes OpenEXR, with a
    `color.png` beside `color.exr` for people to look at.

    Parameters
    ----------
    frame : Frame
    folder : Path
    suffixes : mapping of str to str
        The format of some quantities, ``{"color": ".png"}``.

    Raises
    ------
    InputError
        An unknown quantity in `suffixes`, or a format that cannot hold its quantity.
    """
    unknown = sorted(set(suffixes) - set(QUANTITIES))
    if unknown:
        raise InputError("unknown quantity", got=unknown[0], expected=", ".join(QUANTITIES))
    masks = {"hit", "shadow"} if "hit" in frame else {"hit"}
    for name in frame:
        suffix = suffixes.get(name, ".png" if name in masks else ".exr")
        write_single(frame, name, folder / f"{name}{suffix}")
        if name == "color" and name not in suffixes:
            write_single(frame, name, folder / _VIEWED)
    (folder / META_FILE).write_text(meta_text(frame.meta), encoding="utf-8")


def read_folder(folder: Path, expect: Size) -> Frame:
    """Read every image that is named after a quantity: NAME.png, .exr, .pfm, .npy, ….

    Files that are not images are ignored, and so is `color.png` beside the numbers of `color`. An
    image under another name is an error: a typing error such as `dept.exr` must not count as 'not
    given'.

    Raises
    ------
    InputError
        No image, an unknown name, a quantity that occurs twice, or an image that cannot be read.
    """
    arrays: dict[str, Array] = {}
    masked = False
    for name, path in sorted(_images(folder).items()):
        if path.suffix.lower() == ".npy":
            arrays[name] = read_npy(path, QUANTITIES[name], expect)
        else:
            arrays[name], is_mask = read_single(path, QUANTITIES[name], expect)
            masked = masked or (is_mask and name == "shadow")
        expect = arrays[name].shape[0], arrays[name].shape[1]
    if masked and "hit" in arrays:
        shadow = QUANTITIES["shadow"]
        arrays["shadow"][~arrays["hit"]] = shadow.miss  # black and white cannot express it
    return Frame(arrays, _read_meta(folder / META_FILE))


def _images(folder: Path) -> dict[str, Path]:
    found: dict[str, Path] = {}
    entries = sorted(folder.iterdir())
    if any(p.stem == "color" and p.suffix.lower() in (".exr", ".npy", ".pfm") for p in entries):
        entries = [path for path in entries if path.name != _VIEWED]
    for path in entries:
        if path.suffix.lower() not in SUFFIXES or path.name.startswith("."):
            continue
        if path.stem not in QUANTITIES or path.stem in found:
            what = "a quantity occurs twice" if path.stem in found else "unknown quantity"
            raise InputError(
                what, where=str(folder), got=path.name, expected=f"one of {', '.join(QUANTITIES)}"
            )
        found[path.stem] = path
    if not found:
        raise InputError(
            "no image of a quantity in the folder",
            where=str(folder),
            expected="files such as hit.png, depth.pfm, normal.exr",
        )
    return found


def _read_meta(path: Path) -> dict[str, str]:
    if not path.is_file():
        return {}
    with path.open(encoding="utf-8", errors="replace") as stream:
        return parse_meta(stream.read(_MAX_META_BYTES), str(path))
