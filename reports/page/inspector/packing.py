"""Arrays on a page: bit patterns, predicted, byte by byte, deflated; exact when they come back.

Bit patterns are whole numbers. Of them, or of their differences from another array's, differences
between neighbours are taken, across and down, up to `MOST_ORDERS` times: smooth or equal
values become small numbers, which compress well. `templates/scripts/arrays.js` reads it back.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from minirt.frame import Array
from minirt.vectors import Floats

Kind = Literal["f8", "f4", "b2", "i4", "i1"]
#: Whether another array was subtracted, and how many times neighbours were.
Predictor = tuple[bool, int]

#: Times that neighbours are subtracted, at most: more would gather more rounding than they save.
MOST_ORDERS = 3

#: What each kind is held as, and the unsigned numbers of its bit patterns.
_TYPES: dict[Kind, tuple[type, type]] = {
    "f8": (np.float64, np.uint64), "f4": (np.float32, np.uint32), "b2": (np.uint16, np.uint16),
    "i4": (np.int32, np.uint32), "i1": (np.int8, np.uint8),
}  # fmt: skip

#: The largest finite ratio that is stored; larger ones are stored as this.
_LARGEST = 3e38
#: The least float32 above 1.
_BEYOND = float(np.nextafter(np.float32(1), np.float32(2)))
#: zlib's level of compression.
_LEVEL = 6


@dataclass(frozen=True)
class Packed:
    """An array (ny, nx) or (ny, nx, k), packed.

    Attributes
    ----------
    kind : str
        f8 float64; f4 float32; b2 the upper half of a float32; i4 int32; i1 int8.
    components : int
    exact : bool
        Whether every number comes back as it was.
    predictors : tuple of (bool, int)
        By component: whether the array that it was packed beside was subtracted, and how many
        times neighbours were.
    data : bytes
        Deflated, component by component.
    """

    kind: Kind
    components: int
    exact: bool
    predictors: tuple[Predictor, ...]
    data: bytes


def pack(values: Array, other: Array | None = None, rounded: bool = False) -> Packed:
    """Pack an array; exactly, unless it may be rounded to float32.

    Parameters
    ----------
    values : (ny, nx) or (ny, nx, k) array
        bool, int8, int32 or float64.
    other : array, optional
        Of the same shape and type, packed without `other`: what `values` is probably close to.
    rounded : bool
        Whether float64 is rounded to float32, which takes a quarter of the bytes.
    """
    kind = _kind(values, other, rounded)
    held = _bits_of(values, kind)
    beside = None if other is None else _bits_of(other, kind)
    parts = [_part(held[..., k], None if beside is None else beside[..., k])
             for k in range(held.shape[2])]  # fmt: skip
    exact = kind != "f4" or _single(values)
    stream = b"".join(part for _, part in parts)
    return Packed(
        kind, held.shape[2], exact, tuple(name for name, _ in parts), zlib.compress(stream, _LEVEL)
    )


def pack_ratio(ratio: Floats) -> Packed:
    """Pack error over tolerance to two digits, never across 1: what is wrong stays wrong."""
    finite = np.isfinite(ratio)
    up = finite & (np.abs(ratio) > 1)
    within = np.where(finite, np.clip(ratio, -_LARGEST, _LARGEST), ratio)
    beyond = np.copysign(np.maximum(np.abs(within), _BEYOND), within)
    bits = np.where(up, beyond, within).astype(np.float32).view(np.uint32)
    high = (bits + np.where(up, np.uint32(0xFFFF), np.uint32(0))) >> np.uint32(16)
    codes = np.where(np.isnan(ratio), np.uint16(0x7FC0), high.astype(np.uint16))
    part = _part(codes, None)
    return Packed("b2", 1, False, (part[0],), zlib.compress(part[1], _LEVEL))


def _kind(values: Array, other: Array | None, rounded: bool) -> Kind:
    if values.dtype == np.float64:
        arrays = [values] if other is None else [values, other]
        return "f4" if rounded or all(map(_single, arrays)) else "f8"
    return "i4" if values.dtype == np.int32 else "i1"


def _single(values: Array) -> bool:
    """Whether every number is one of float32's already."""
    with np.errstate(over="ignore"):
        return bool(np.array_equal(values.astype(np.float32).astype(np.float64), values,
                                   equal_nan=True))  # fmt: skip


def _with_components(values: Array) -> Array:
    return values.reshape(*values.shape[:2], -1)


def _bits_of(values: Array, kind: Kind) -> NDArray[Any]:
    """Bit patterns (ny, nx, k); every NaN is the same one."""
    held_type, unsigned = _TYPES[kind]
    with np.errstate(over="ignore"):
        held: NDArray[Any] = np.ascontiguousarray(_with_components(values).astype(held_type))
    if kind in ("f8", "f4"):
        held[np.isnan(held)] = np.nan
    bits: NDArray[Any] = held.view(unsigned)
    return bits


def _part(bits: NDArray[Any], other: NDArray[Any] | None) -> tuple[Predictor, bytes]:
    """The shortest prediction of one component, and its bytes, plane by plane."""
    tried: list[tuple[float, Predictor, NDArray[Any]]] = []
    for subtracted, left in ((False, bits), *([] if other is None else [(True, bits - other)])):
        for orders in range(MOST_ORDERS + 1):
            folded = _folded(left)
            cost = float(np.log2(folded.astype(np.float64) + 1).sum())
            tried.append((cost, (subtracted, orders), folded))
            left = _from_neighbours(left)
    _, predictor, folded = min(tried, key=lambda each: each[0])
    flat = np.ascontiguousarray(folded).reshape(-1)
    planes = flat.view(np.uint8).reshape(-1, folded.itemsize).T
    return predictor, np.ascontiguousarray(planes).tobytes()


def _from_neighbours(bits: NDArray[Any]) -> NDArray[Any]:
    """Each number less the one to its left, then less the one above it."""
    across = bits.copy()
    across[:, 1:] -= bits[:, :-1]
    down = across.copy()
    down[1:] -= across[:-1]
    return down


def _folded(difference: NDArray[Any]) -> NDArray[Any]:
    """Small differences of either sign as small numbers."""
    unsigned = difference.dtype.type
    top = unsigned(8 * difference.itemsize - 1)
    folded: NDArray[Any] = (difference << unsigned(1)) ^ (unsigned(0) - (difference >> top))
    return folded
