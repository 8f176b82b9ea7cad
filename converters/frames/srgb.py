"""Linear light to sRGB codes and back, by tables: the same bytes on every machine.

Source: IEC 61966-2-1.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from minirt.vectors import Floats


def srgb_codes(linear: Floats) -> NDArray[np.uint8]:
    """The nearest 8-bit sRGB codes; values are clamped, NaN becomes 0.

    Parameters
    ----------
    linear : array of any shape, float64
        Linear light; 1 is white.

    Returns
    -------
    uint8 array of the same shape

    Source: IEC 61966-2-1.
    """
    codes = np.searchsorted(_steps(), np.nan_to_num(linear, nan=0.0), side="right")
    return codes.astype(np.uint8)


def linear_light(codes: NDArray[Any]) -> Floats:
    """Linear light of unsigned 8-bit or 16-bit sRGB codes, float64 of the same shape."""
    result: Floats = _decoded(int(np.iinfo(codes.dtype).max))[codes]
    return result


@cache
def _steps() -> Floats:
    """Where code k − 1 changes into k: halfway between them, decoded. 255 numbers."""
    return np.array([_decode((k - 0.5) / 255) for k in range(1, 256)])


@cache
def _decoded(white: int) -> Floats:
    return np.array([_decode(k / white) for k in range(white + 1)])


def _decode(value: float) -> float:
    """The transfer function of the standard, from code in 0…1 to linear light."""
    return value / 12.92 if value <= 0.04045 else float(((value + 0.055) / 1.055) ** 2.4)
