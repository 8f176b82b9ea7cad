"""Vectors as component-first float64 arrays of shape (3, n) or (3,).

Only elementwise +, −, ×, ÷ and √ are used, which IEEE 754 rounds correctly, in a fixed order:
every CPU gives the same bits. No matrix product, no power, no trigonometric function.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Index: TypeAlias = NDArray[np.intp]
Bools: TypeAlias = NDArray[np.bool_]


def dot(a: Floats, b: Floats) -> Floats:
    """Scalar product over the first axis."""
    products = a * b
    result: Floats = products[0] + products[1]
    result += products[2]
    return result


def cross(a: Floats, b: Floats) -> Floats:
    """Vector product over the first axis; ``cross(b, a)`` is its exact negative."""
    result = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        component = result[k, ...]
        np.multiply(a[i], b[j], out=component)
        component -= a[j] * b[i]
    return result


def norm(a: Floats) -> Floats:
    """Euclidean length over the first axis."""
    result: Floats = np.sqrt(dot(a, a))
    return result


def unit(a: Floats) -> Floats:
    """The vector divided by its length; NaN for the zero vector."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return a / norm(a)


def column(a: Any) -> Floats:
    """A vector (3,) as the column (3, 1) that broadcasts against (3, n)."""
    return np.asarray(a, dtype=np.float64).reshape(3, 1)


def take(v: Floats, index: Index | Ints) -> Floats:
    """Some (3, k) of vectors (3, n): ``v[:, index]``, in a fraction of its time.

    One vector (3, 1) stands for all k, whatever the index.
    """
    if v.shape[1] == 1:
        return np.broadcast_to(v, (len(v), len(index)))
    some: Floats = v.take(index, axis=1)
    return some


def put(v: Floats, index: Index, values: Floats) -> None:
    """Overwrite some of vectors (3, n): ``v[:, index] = values``, in a fraction of its time."""
    for row, value in zip(v, values, strict=True):
        row[index] = value


def divided(numbers: Index, by: int) -> tuple[Index, Index]:
    """Quotients and remainders (n,): ``np.divmod(numbers, by)``, in a fraction of its time."""
    quotient: Index = numbers // by
    return quotient, numbers - quotient * by
