"""Frames read from and written to `.npz`, `.exr`, or a folder of images; writing is atomic."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from converters.atomic import atomic_file, atomic_folder
from converters.frames.casts import Size, check_size
from converters.frames.exr import read_exr, write_exr
from converters.frames.folder import META_FILE, read_folder, write_folder
from converters.frames.npz import read_npz, write_npz
from converters.frames.single_image import SUFFIXES, write_single
from minirt.errors import InputError
from minirt.frame import Frame
from minirt.quantities import QUANTITIES


def write_frame(frame: Frame, path: str | Path, images: Mapping[str, str] | None = None) -> None:
    """Write a frame to a file or a folder; a crash leaves what was there before.

    Parameters
    ----------
    frame : Frame
        Any subset of the quantities, at least one.
    path : path
        `.npz`: every bit, with the table's types. `.exr`: float32, for every viewer. A name
        without a suffix, with the suffix `.d` or with a slash at its end: a folder of images,
        which may replace a folder of images but no other.
    images : mapping of str to str, optional
        For a folder: the suffix of some quantities, ``{"color": ".png"}``. By default `.png` for
        `hit` and `shadow` (black is 0 or nothing hit: `hit` says which), `.exr` for the rest,
        and a `color.png` beside `color.exr`, which is preferred on reading.

    Raises
    ------
    InputError
        The path cannot be written, or the format cannot hold a value.
    """
    check_size(*frame.size, None, "the frame")
    kind = _kind(path)
    if images and kind != "folder":
        raise InputError("formats of single images are for a folder", where=str(path))
    if kind == "folder":
        _require_replaceable(Path(path))
        with atomic_folder(path) as folder:
            write_folder(frame, folder, images or {})
        return
    with atomic_file(path) as temporary:
        (write_npz if kind == ".npz" else write_exr)(frame, temporary)


def write_image(frame: Frame, quantity: str, path: str | Path) -> None:
    """Write one quantity as one image.

    Parameters
    ----------
    frame : Frame
    quantity : str
        Its name.
    path : path
        `.png`: `color` clamped and sRGB-encoded, masks black and white (1 is white), `alpha`;
        `.pfm`, `.exr`: float32 numbers; `.npy`: the array itself.

    Raises
    ------
    InputError
        The path cannot be written, or the format cannot hold the quantity.
    """
    with atomic_file(path) as temporary:
        write_single(frame, quantity, temporary)


def read_frame(path: str | Path, expect: Size = None) -> Frame:
    """Read the quantities that a file or folder holds; the others are absent from the frame.

    Values are accepted where the table's type holds them exactly: float32 for float64, numbers 0
    and 1 for bool, whole floats for integers. NaN is accepted: judging it is the comparison's task.

    Parameters
    ----------
    path : path
        `.npz`, `.exr`, or a folder of images (see `converters.frames.folder`).
    expect : (ny, nx), optional
        Another size is refused after reading the header, before anything is allocated.

    Raises
    ------
    InputError
        Missing, broken, of the wrong size, type or shape, or with an unknown quantity.
    """
    place = Path(path)
    try:
        if place.is_dir():
            return read_folder(place, expect)
        if not place.is_file():
            raise InputError("no such file", where=str(path))
        kind = _kind(path)
        if kind == "folder":
            raise _unknown_format(path)
        return (read_npz if kind == ".npz" else read_exr)(place, expect)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError("cannot be read", where=repr(str(path))[:200], got=reason) from None
    except MemoryError:
        raise InputError("the frame does not fit in memory", where=str(path)) from None


def _kind(path: str | Path) -> str:
    suffix = Path(path).suffix.lower()
    if str(path).endswith(os.sep) or suffix in ("", ".d"):
        return "folder"
    if suffix not in (".npz", ".exr"):
        raise _unknown_format(path)
    return suffix


def _unknown_format(path: str | Path) -> InputError:
    return InputError(
        "unknown format of a frame",
        where=str(path),
        got=Path(path).suffix or "a file without a suffix",
        expected=".npz, .exr, or a folder",
    )


def _require_replaceable(folder: Path) -> None:
    """Refuse to replace a folder that holds anything but a frame's images."""
    if not folder.is_dir():
        return
    for entry in folder.iterdir():
        ours = entry.stem in QUANTITIES and entry.suffix.lower() in SUFFIXES
        if not entry.is_file() or not (ours or entry.name == META_FILE):
            raise InputError(
                "the folder holds other files than a frame's and is not replaced",
                where=str(folder),
                got=entry.name,
                expected="a new name, or a folder of a frame's images",
            )
