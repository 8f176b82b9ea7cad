"""Image files through OpenImageIO, read and written in blocks of rows, row 0 at the top."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import OpenImageIO as oiio

from converters.frames.casts import Size, check_size
from minirt.errors import InputError
from minirt.frame import Array

#: Size of one block of rows, in bytes. It bounds the memory that is needed beside the image itself.
BLOCK_BYTES = 2**25

oiio.attribute("try_all_readers", 0)  # a file is what its suffix says, or it is broken


@dataclass(frozen=True)
class Image:
    """An open image file.

    Attributes
    ----------
    path : str
        For errors.
    ny, nx : int
        Rows and columns.
    channels : tuple of str
        Their names, in the order of the planes.
    alpha : int
        Which of them is alpha, the coverage; −1 for none.
    white : int
        The code of full intensity of an integer image (PNG, TIFF); 0 where values are numbers.
    attributes : dict of str to str
        Its metadata of type text.
    """

    path: str
    ny: int
    nx: int
    channels: tuple[str, ...]
    alpha: int
    white: int
    attributes: dict[str, str]
    _input: oiio.ImageInput
    _spec: oiio.ImageSpec

    def blocks(self) -> Iterator[tuple[slice, list[Array]]]:
        """The image from top to bottom: some rows, and each channel's (rows, nx) values there.

        Values come in the file's own types: OpenImageIO would turn a count of 1 into 1/(2³²−1).
        """
        rows = max(1, BLOCK_BYTES // (self.nx * len(self.channels) * 4))
        step = self._spec.tile_height or 1
        rows = -(-rows // step) * step
        for top in range(0, self.ny, rows):
            bottom = min(top + rows, self.ny)
            yield slice(top, bottom), self._planes(top, bottom)

    def _planes(self, top: int, bottom: int) -> list[Array]:
        planes: list[Array] = []
        for first, last, kind in _runs(self._spec):
            y = self._spec.y
            window = (top + y, bottom + y)
            if self._spec.tile_width:
                across = (self._spec.x, self._spec.x + self.nx)
                block = self._input.read_tiles(*across, *window, 0, 1, first, last, kind)
            else:
                block = self._input.read_scanlines(*window, 0, first, last, kind)
            if block is None:
                raise _unreadable(self.path, self._input.geterror())
            values = np.asarray(block).reshape(bottom - top, self.nx, last - first)
            planes += [values[..., k] for k in range(last - first)]
        return planes


@contextmanager
def open_image(path: Path, expect: Size) -> Iterator[Image]:
    """Open an image file and check its header, before anything is allocated.

    Raises
    ------
    InputError
        Not a readable image, of another size than `expect` (rows, columns), over the limit, or of
        a kind that is not one flat image: cropped, deep, of several parts.
    """
    hints = oiio.ImageSpec()
    hints.attribute("pnm:pfmflip", 1)  # PFM counts rows from the bottom; not the default here
    hints.attribute("oiio:UnassociatedAlpha", 1)  # leave colours as they are
    if not path.is_file():
        raise _unreadable(str(path), "no such file")
    source = oiio.ImageInput.open(str(path), hints)
    if source is None:
        raise _unreadable(str(path), oiio.geterror())
    try:
        spec = source.spec()
        check_size(spec.height, spec.width, expect, str(path))
        _require_flat(spec, str(path))
        white = {"uint8": 2**8 - 1, "uint16": 2**16 - 1}.get(str(spec.format), 0)
        yield Image(
            str(path), spec.height, spec.width, tuple(spec.channelnames), spec.alpha_channel,
            white, _texts(spec), source, spec,
        )  # fmt: skip
    finally:
        source.close()


def write_image_file(
    path: Path,
    size: tuple[int, int],
    channels: tuple[str, ...],
    kind: Literal["float", "uint8"],
    rows: Callable[[slice], Array],
    attributes: Mapping[str, str] | None = None,
) -> None:
    """Write one image a block of rows at a time; the same bytes for the same content.

    Parameters
    ----------
    path : Path
        Its suffix says the format. Not atomic: see `converters.atomic`.
    size : (ny, nx)
    channels : tuple of str
        Names, which PNG and PFM cannot keep.
    kind : str
        Type of the values: float is float32.
    rows : function
        From a slice of rows to their values, (rows, nx, channels) of that type.
    attributes : mapping of str to str, optional

    Raises
    ------
    OSError
        OpenImageIO cannot write it.
    """
    ny, nx = size
    spec = oiio.ImageSpec(nx, ny, len(channels), kind)
    if kind == "float":
        spec.channelnames = channels
        spec.alpha_channel = channels.index("A") if "A" in channels else -1
        spec.attribute("compression", "zip")
        spec.attribute("DateTime", "")  # otherwise the time of writing is stored
        for key, value in (attributes or {}).items():
            spec.attribute(key, value)
    out = oiio.ImageOutput.create(str(path))
    if out is None:
        raise OSError(_line(oiio.geterror()))
    done = out.open(str(path), spec)
    step = max(1, BLOCK_BYTES // (nx * len(channels) * 4))
    for top in range(0, ny, step):
        block = slice(top, min(top + step, ny))
        done = done and out.write_scanlines(block.start, block.stop, 0, rows(block))
    if not (out.close() and done):
        raise OSError(_line(out.geterror()) or "the image could not be written completely")


def _runs(spec: oiio.ImageSpec) -> Iterator[tuple[int, int, Any]]:
    """Ranges of channels that share one type, with that type."""
    formats = list(spec.channelformats) or [spec.format] * spec.nchannels
    first = 0
    for k in range(1, spec.nchannels + 1):
        if k == spec.nchannels or formats[k] != formats[first]:
            yield first, k, formats[first]
            first = k


def _require_flat(spec: oiio.ImageSpec, where: str) -> None:
    if spec.deep or spec.depth > 1 or spec.get_int_attribute("oiio:subimages", 1) > 1:
        raise InputError("not one flat image", where=where, expected="one part, not deep")
    data = (spec.x, spec.y, spec.width, spec.height)
    display = (spec.full_x, spec.full_y, spec.full_width, spec.full_height)
    if spec.get_string_attribute("openexr:lineOrder") and data != display:
        raise InputError(
            "the image is cropped: its data window is not its display window",
            where=where,
            got=f"x, y, width, height {data} of {display}",
            expected="every pixel of the image in the file",
        )


def _texts(spec: oiio.ImageSpec) -> dict[str, str]:
    return {a.name: a.value for a in spec.extra_attribs if isinstance(a.value, str)}


def _unreadable(path: str, reason: str) -> InputError:
    return InputError("the image cannot be read", where=path, got=_line(reason) or "no image")


def _line(text: str) -> str:
    """A library's message on one line of at most 300 characters."""
    return " ".join(text.split())[:300]
