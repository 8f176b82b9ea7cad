"""A frame as one OpenEXR file: float32, lossless, under names that every viewer knows."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from converters.frames.casts import Size, as_float32, as_quantity
from converters.frames.images import Image, open_image, write_image_file
from minirt.errors import InputError
from minirt.frame import Array, Frame
from minirt.quantities import QUANTITIES, Quantity

#: Prefix of the attributes that hold the frame's `meta`.
ATTRIBUTE = "minirt:"


def write_exr(frame: Frame, path: Path) -> None:
    """Write every quantity under its channel names. Not atomic; see `converters.frames.io`.

    Raises
    ------
    InputError
        A value that float32 cannot hold.
    """
    parts = [QUANTITIES[name] for name in QUANTITIES if name in frame]
    channels = tuple(channel for quantity in parts for channel in quantity.channels)

    def rows(block: slice) -> Array:
        height = block.stop - block.start
        values = np.zeros((height, frame.size[1], len(channels)), dtype=np.float32)
        first = 0
        for quantity in parts:
            last = first + quantity.components
            source = frame[quantity.name][block].reshape(height, -1, quantity.components)
            values[..., first:last] = as_float32(source, quantity, quantity.name)
            first = last
        return values

    attributes = {ATTRIBUTE + key: value for key, value in frame.meta.items()}
    write_image_file(path, frame.size, channels, "float", rows, attributes)


def read_exr(path: Path, expect: Size) -> Frame:
    """Read the quantities that a file holds; other channels are ignored.

    Names are case-sensitive.

    Raises
    ------
    InputError
        Not a readable image, a quantity without one of its channels, or a value that it cannot
        have.
    """
    with open_image(path, expect) as image:
        parts = _held(image)
        arrays = {q.name: q.missing(image.ny, image.nx) for q in parts}
        for rows, planes in image.blocks():
            for quantity in parts:
                where = f"{path}: {quantity.name}"
                target = arrays[quantity.name][rows]
                target = target.reshape(*target.shape[:2], quantity.components)
                for k, channel in enumerate(quantity.channels):
                    plane = planes[image.channels.index(channel)]
                    target[..., k] = as_quantity(plane, quantity, where)
        meta = {
            name.removeprefix(ATTRIBUTE): text
            for name, text in image.attributes.items()
            if name.startswith(ATTRIBUTE)
        }
        return Frame(arrays, meta)


def _held(image: Image) -> list[Quantity]:
    names = set(image.channels)
    parts = [q for q in QUANTITIES.values() if names.intersection(q.channels)]
    for quantity in parts:
        if not names.issuperset(quantity.channels):
            raise InputError(
                "a channel is missing",
                where=f"{image.path}: {quantity.name}",
                got=", ".join(c for c in quantity.channels if c in names),
                expected=", ".join(quantity.channels),
            )
    if not parts:
        raise InputError(
            "no channel is one of a quantity",
            where=image.path,
            got=", ".join(image.channels)[:200],
            expected=", ".join(c for q in QUANTITIES.values() for c in q.channels),
        )
    return parts
