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
Bools: TypeAlias = NDArray[np.bool_]

_SPLITTER = 134217729.0  # 2**27 + 1: Veltkamp's constant for 53-bit numbers


def dot(a: Floats, b: Floats) -> Floats:
    """Scalar product over the first axis."""
    result: Floats = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return result


def cross(a: Floats, b: Floats) -> Floats:
    """Vector product over the first axis; ``cross(b, a)`` is its exact negative."""
    return np.stack(
        (
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        )
    )


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


def edge_normal(a: Floats, b: Floats, c: Floats) -> Floats:
    """(b − a) × (c − a) with each component correct to about one ulp.

    Plain float64 loses the digits of needles and caps: with edges that are nearly parallel the
    two products of a component cancel. Edges and products are therefore carried with their
    rounding errors (Knuth's two-difference, Dekker's two-product), which leaves an error near
    2⁻¹⁰² of the product of the edge lengths. What is smaller than 2⁻⁹⁰ of it cannot be told from
    zero and is returned as zero: a degenerate triangle.

    Parameters
    ----------
    a, b, c : (3, n) float64
        Vertices in scene units.

    Returns
    -------
    (3, n) float64
        Twice the area times the unit normal of the right-hand rule; zero where degenerate.

    Source: S9; T. J. Dekker 1971, doi:10.1007/BF01397083.
    """
    e, e_low = _two_difference(b, a)
    f, f_low = _two_difference(c, a)
    parts = []
    for i, j in ((1, 2), (2, 0), (0, 1)):
        p, p_low = _two_product(e[i], f[j])
        q, q_low = _two_product(e[j], f[i])
        p_low = p_low + (e[i] * f_low[j] + e_low[i] * f[j])
        q_low = q_low + (e[j] * f_low[i] + e_low[j] * f[i])
        high, low = _two_difference(p, q)
        parts.append(high + (low + (p_low - q_low)))
    normal = np.stack(parts)
    size = norm(e) * norm(f)
    normal[:, norm(normal) <= size * 2.0**-90] = 0.0
    return normal


def _two_difference(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """a − b as a rounded difference and the exact error of that rounding."""
    high = a - b
    back = high - a
    return high, (a - (high - back)) - (b + back)


def _two_product(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """a · b as a rounded product and the exact error of that rounding."""
    high = a * b
    a_high, a_low = _split(a)
    b_high, b_low = _split(b)
    low = a_low * b_low - (((high - a_high * b_high) - a_low * b_high) - a_high * b_low)
    return high, low


def _split(a: Floats) -> tuple[Floats, Floats]:
    big = _SPLITTER * a
    high = big - (big - a)
    return high, a - high
