"""Numbers carried as an unevaluated sum of two float64, for the places where float64 cancels.

A pair (high, low) holds some 106 bits. Only +, − and × are used, each correctly rounded, so that
every CPU gives the same bits.

Source: T. J. Dekker 1971, doi:10.1007/BF01397083; D. E. Knuth, The Art of Computer Programming 2.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from minirt.vectors import Floats

Pair: TypeAlias = tuple[Floats, Floats]

_SPLITTER = 134217729.0  # 2**27 + 1: Veltkamp's constant for 53-bit numbers


def two_difference(a: Floats, b: Floats) -> Pair:
    """a − b as a rounded difference and the exact error of that rounding."""
    high = a - b
    back = high - a
    return high, (a - (high - back)) - (b + back)


def two_product(a: Floats, b: Floats) -> Pair:
    """a · b as a rounded product and the exact error of that rounding."""
    high = a * b
    a_high, a_low = _split(a)
    b_high, b_low = _split(b)
    low = a_low * b_low - (((high - a_high * b_high) - a_low * b_high) - a_high * b_low)
    return high, low


def product(x: Pair, y: Pair) -> Pair:
    """x · y, with a relative error of a few 2⁻¹⁰⁶."""
    high, low = two_product(x[0], y[0])
    return _renewed(high, low + (x[0] * y[1] + x[1] * y[0]))


def difference(x: Pair, y: Pair) -> Pair:
    """x − y, with an error of a few 2⁻¹⁰⁶ of |x| + |y|."""
    high, low = two_difference(x[0], y[0])
    return _renewed(high, low + (x[1] - y[1]))


def pair_cross(x: Pair, y: Pair) -> Pair:
    """Vector product over the first axis, with an error near 2⁻¹⁰³ of its products."""
    turned = [
        product((x[0][[i, j]], x[1][[i, j]]), (y[0][[j, i]], y[1][[j, i]]))
        for i, j in ((1, 2), (2, 0), (0, 1))
    ]
    parts = [difference((h[0], l[0]), (h[1], l[1])) for h, l in turned]
    return np.stack([h for h, _ in parts]), np.stack([l for _, l in parts])


def pair_dot(x: Pair, y: Pair) -> Pair:
    """Scalar product over the first axis, with an error near 2⁻¹⁰³ of its products."""
    high, low = product(x, y)
    total = high[0], low[0]
    for k in (1, 2):
        total = difference(total, (-high[k], -low[k]))
    return total


def _renewed(high: Floats, low: Floats) -> Pair:
    total = high + low
    return total, low - (total - high)


def _split(a: Floats) -> Pair:
    big = _SPLITTER * a
    high = big - (big - a)
    return high, a - high
