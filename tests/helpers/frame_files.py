"""A frame of every quantity, and images as other programs write them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

from minirt.frame import Frame
from minirt.quantities import QUANTITIES

Array = NDArray[Any]
META = {"scene": "kugel ν", "sceneSha256": "ab" * 32, "version": "0.1.0"}
KINDS = ("f.npz", "f.exr", "f.d", "f")


def whole_frame(ny: int = 6, nx: int = 4) -> Frame:
    """Every quantity, no two rows or columns alike."""
    arrays = {}
    for k, quantity in enumerate(QUANTITIES.values()):
        shape = quantity.shape(ny, nx)
        ramp = np.arange(np.prod(shape)).reshape(shape) + k
        arrays[quantity.name] = (ramp % 2 if quantity.discrete else ramp / 7).astype(quantity.dtype)
    arrays["shadow"][~arrays["hit"]] = -1
    return Frame(arrays, META)


def assert_same(a: Frame, b: Frame, exact: bool = True) -> None:
    assert set(a) == set(b)
    assert len(a) > 0
    for name in a:
        expected = a[name] if exact or QUANTITIES[name].discrete else a[name].astype(np.float32)
        assert b[name].dtype == QUANTITIES[name].dtype
        np.testing.assert_array_equal(b[name], expected, err_msg=name)
    assert b.meta == a.meta


def write_pixels(path: Path, pixels: Array, names: tuple[str, ...] = (), **extra: Any) -> None:
    """An image as another program would write it."""
    pixels = np.atleast_3d(pixels)
    kind = {"float32": "float", "uint32": "uint"}.get(pixels.dtype.name, pixels.dtype.name)
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    if names:
        spec.channelnames = names
    if "formats" in extra:
        spec.channelformats = extra["formats"]
    if "tile" in extra:
        spec.tile_width = spec.tile_height = extra["tile"]
    if "full_width" in extra:
        spec.full_width = extra["full_width"]
    out = oiio.ImageOutput.create(str(path))
    assert out is not None
    assert out.open(str(path), spec), out.geterror()
    assert out.write_image(np.ascontiguousarray(pixels)), out.geterror()
    assert out.close()
