"""Conversion of numbers: from a file's types to a frame's, and from a frame's to float32."""

from __future__ import annotations

from typing import Any

import numpy as np

from minirt.errors import InputError
from minirt.frame import Array
from minirt.quantities import Quantity
from minirt.scene_file.schema import MAX_PIXELS, MAX_SIDE

#: Rows and columns of an image; None where any will do.
Size = tuple[int, int] | None

#: Every whole number up to here, and not the next, is a float32: 24 bits of significand.
EXACT = 2**24


def check_size(ny: int, nx: int, expect: Size, where: str) -> None:
    """Refuse an image before anything is allocated for it.

    Parameters
    ----------
    ny, nx : int
        Rows and columns.
    expect : (ny, nx) or None
        The size that the image must have.
    where : str
        The file, for errors.

    Raises
    ------
    InputError
        Not of the expected size, empty, or over the limit.
    """
    got = f"{nx} × {ny} (columns × rows)"
    if expect is not None and (ny, nx) != expect:
        raise InputError("wrong size", where=where, got=got, expected=f"{expect[1]} × {expect[0]}")
    if ny < 1 or nx < 1:
        raise InputError("the image is empty", where=where, got=got)
    if ny * nx > MAX_PIXELS or max(ny, nx) > MAX_SIDE:
        raise InputError(
            "the image is over the size limit",
            where=where,
            got=got,
            expected=f"at most {MAX_PIXELS:,} pixels and {MAX_SIDE:,} a side",
        )


def check_type(dtype: np.dtype[Any], quantity: Quantity, where: str) -> None:
    """Refuse an element type that cannot be converted to a quantity's.

    Bool, integers and floats of up to 8 bytes can, in any byte order; for a discrete quantity if
    the values are whole and in range, which `as_quantity` checks.

    Parameters
    ----------
    dtype : numpy.dtype
    quantity : Quantity
    where : str
        The file and the name in it, for errors.

    Raises
    ------
    InputError
        Of another kind, or longer.
    """
    if dtype.kind not in "biuf" or dtype.itemsize > 8:
        raise InputError("wrong type", where=where, got=str(dtype)[:80], expected=quantity.dtype)


def as_quantity(values: Array, quantity: Quantity, where: str) -> Array:
    """Values of a file in the table's type, if that holds them exactly.

    Parameters
    ----------
    values : array of any shape
    quantity : Quantity
    where : str
        The file and the name in it, for errors.

    Returns
    -------
    array of the same shape
        `values` itself where it has that type already.

    Raises
    ------
    InputError
        A type that cannot be converted, or a value of a discrete quantity that is not whole or
        out of its type's range (a bool quantity's: 0 and 1).
    """
    wanted = np.dtype(quantity.dtype)
    if values.dtype == wanted:
        return values
    check_type(values.dtype, quantity, where)
    if quantity.discrete:
        low, high = (0, 1) if wanted.kind == "b" else _range(wanted)
        exact = values.astype(np.float64) if values.dtype.kind == "f" else values
        wrong = ~((exact >= low) & (exact <= high))  # NaN is neither
        if values.dtype.kind == "f":
            wrong |= np.trunc(exact) != exact
        if wrong.any():
            raise InputError(
                "a value that the quantity cannot have",
                where=where,
                got=str(values[wrong].flat[0]),
                expected=f"whole numbers from {low} to {high}",
            )
    return values.astype(wanted)


def as_float32(values: Array, quantity: Quantity, where: str) -> Array:
    """A quantity's values as float32; infinities and NaN stay what they are.

    Parameters
    ----------
    values : array of any shape, of the quantity's type
    quantity : Quantity
    where : str
        The file and the name in it, for errors.

    Raises
    ------
    InputError
        A whole number above 2**24, which float32 would round, or a finite number that would
        become infinite, which means a miss.
    """
    with np.errstate(over="ignore"):
        result = values.astype(np.float32)
    if np.dtype(quantity.dtype).itemsize > 2 and quantity.discrete:
        wrong = np.abs(values.astype(np.int64)) > EXACT
        limit = f"at most {EXACT:,}"
    else:
        wrong = np.isinf(result) & np.isfinite(values)
        limit = f"at most {np.finfo(np.float32).max:.4g}"
    if wrong.any():
        raise InputError(
            "float32 cannot hold a value",
            where=where,
            got=str(values[wrong].flat[0]),
            expected=f"{limit}, or an .npz file",
        )
    return result


def _range(dtype: np.dtype[Any]) -> tuple[int, int]:
    limits = np.iinfo(dtype)
    return int(limits.min), int(limits.max)
