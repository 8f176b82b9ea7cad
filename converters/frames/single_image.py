"""One quantity as one image: a mask, a picture, or numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from converters.frames.casts import Size, as_float32, as_quantity
from converters.frames.images import Image, open_image, write_image_file
from converters.frames.npz import write_array
from converters.frames.srgb import linear_light, srgb_codes
from minirt.errors import InputError
from minirt.frame import Array, Frame
from minirt.quantities import QUANTITIES, Quantity

#: Formats that are read, if they can hold the quantity; .npy, .exr, .pfm and .png are written.
SUFFIXES = (
    ".npy", ".exr", ".pfm", ".png", ".tif", ".tiff", ".hdr",
    ".bmp", ".tga", ".jpg", ".jpeg", ".ppm", ".pgm",
)  # fmt: skip

_MASKS = ("hit", "shadow", "tir")


def write_single(frame: Frame, name: str, path: Path) -> None:
    """Write one quantity to a file whose suffix says how. Not atomic; see `frames.io`.

    Parameters
    ----------
    frame : Frame
    name : str
        The quantity's.
    path : Path

    Raises
    ------
    InputError
        A quantity that the frame does not have, or that the format cannot hold.
    """
    if name not in frame:
        raise InputError(
            "the frame does not have this quantity", got=repr(name), expected=", ".join(frame)
        )
    quantity, values = QUANTITIES[name], frame[name]
    suffix = path.suffix.lower()
    if suffix == ".npy":
        with path.open("wb") as stream:
            write_array(stream, values)
    elif suffix == ".png":
        _write_png(quantity, values, path)
    elif suffix == ".exr" or (suffix == ".pfm" and quantity.components != 2):
        _write_numbers(frame, quantity, path)
    else:
        raise InputError(
            "this format cannot hold the quantity",
            where=name,
            got=path.suffix or path.name,
            expected=".npy, .exr, .pfm (1 or 3 components) or .png (masks, color, alpha)",
        )


def read_single(path: Path, quantity: Quantity, expect: Size) -> tuple[Array, bool]:
    """Read one quantity from an image; and whether the image is a black and white mask.

    Integer images (PNG, …) hold masks, true from half of full intensity, or `color` in sRGB, or
    `alpha`. All others (EXR, PFM, …) hold the numbers themselves.

    Parameters
    ----------
    path : Path
    quantity : Quantity
    expect : (ny, nx) or None

    Raises
    ------
    InputError
        Not a readable image, or one that cannot hold the quantity.
    """
    with open_image(path, expect) as image:
        where = str(path)
        if image.white and quantity.name not in (*_MASKS[:2], "color", "alpha"):
            raise InputError(
                "an image of integers cannot hold the quantity",
                where=where,
                expected=".npy, .exr or .pfm",
            )
        mask = bool(image.white) and quantity.name in _MASKS
        array = quantity.missing(image.ny, image.nx)
        for rows, planes in image.blocks():
            target = array[rows].reshape(rows.stop - rows.start, image.nx, quantity.components)
            if mask:
                target[..., 0] = _grey(image, planes) >= image.white / 2
                continue
            for k, plane in enumerate(_components(image, planes, quantity)):
                values = _intensity(plane, image.white, quantity) if image.white else plane
                target[..., k] = as_quantity(values, quantity, where)
        return array, mask


def _write_png(quantity: Quantity, values: Array, path: Path) -> None:
    if quantity.name not in (*_MASKS, "color", "alpha"):
        raise InputError(
            "a PNG cannot hold the quantity", where=quantity.name, expected=".npy, .exr or .pfm"
        )

    def rows(block: slice) -> Array:
        part = values[block]
        if quantity.name in _MASKS:
            part = np.where(part == 1, np.uint8(255), np.uint8(0))
        elif quantity.name == "color":
            part = srgb_codes(part)
        else:
            part = np.rint(np.nan_to_num(part).clip(0, 1) * 255).astype(np.uint8)
        return part.reshape(*part.shape[:2], quantity.components)

    channels = ("R", "G", "B") if quantity.components == 3 else ("Y",)
    write_image_file(path, (len(values), values.shape[1]), channels, "uint8", rows)


def _write_numbers(frame: Frame, quantity: Quantity, path: Path) -> None:
    values = frame[quantity.name]

    def rows(block: slice) -> Array:
        part = as_float32(values[block], quantity, quantity.name)
        return part.reshape(*part.shape[:2], quantity.components)

    write_image_file(path, frame.size, quantity.channels, "float", rows)


def _grey(image: Image, planes: list[Array]) -> Array:
    """Mean of the channels without coverage."""
    used = _without_coverage(image, planes)
    total: Array = sum((plane.astype(np.float64) for plane in used[1:]), used[0].astype(np.float64))
    return total / len(used)


def _components(image: Image, planes: list[Array], quantity: Quantity) -> list[Array]:
    """The planes of a quantity's components, from an image that may have more or fewer channels."""
    wanted = quantity.components
    used = planes if len(planes) == wanted else _without_coverage(image, planes)
    if len(used) == wanted:
        return used
    if wanted == 2 and len(used) == 3:  # a PFM has 1 or 3
        return used[:2]
    if wanted == 1 and all(np.array_equal(p, used[0], equal_nan=True) for p in used):
        return used[:1]
    if len(used) == 1 and quantity.name == "color":
        return used * 3
    raise InputError(
        "the image does not have the quantity's channels",
        where=image.path,
        got=", ".join(image.channels)[:200],
        expected=f"{wanted} of them",
    )


def _without_coverage(image: Image, planes: list[Array]) -> list[Array]:
    if len(planes) == 1:
        return planes
    return [plane for k, plane in enumerate(planes) if k != image.alpha]


def _intensity(codes: Array, white: int, quantity: Quantity) -> Array:
    return linear_light(codes) if quantity.name == "color" else codes / np.float64(white)
