"""S10: the plane of a polygon (E7: the slide says 'of the triangle')."""

from __future__ import annotations

import numpy as np

from minirt.vectors import Floats, dot, unit

#: The rounding error of d·p is at most this share of |d₁p₁| + |d₂p₂| + |d₃p₃|: half an ulp for p's
#: components, half for each product, one for the two sums. Below it the ray is parallel.
UNDECIDED_SLOPE = 4 * 2.0**-53


def plane_t(P0: Floats, d: Floats, P1: Floats, p: Floats) -> Floats:
    """t = (P1 − P0)·p / (d·p), where the ray's line meets the plane (X − P1)·p = 0.

    Parameters
    ----------
    P0, d : (3, n) float64
    P1, p : (3, n) or (3, 1) float64
        A point of the plane and its normal, of any length.

    Returns
    -------
    (n,) float64
        Of either sign; +inf where d·p cannot be told from zero (parallel) or p is zero.

    Source: S10.
    """
    slope = dot(d, p)
    size = np.abs(d[0] * p[0]) + np.abs(d[1] * p[1]) + np.abs(d[2] * p[2])
    parallel = np.abs(slope) <= UNDECIDED_SLOPE * size
    t: Floats = np.where(parallel, np.inf, dot(P1 - P0, p) / np.where(parallel, 1.0, slope))
    return t


def plane_normal(p: Floats) -> Floats:
    """The unit normal s of a plane on the side of the right-hand rule. Source: S9, S10."""
    return unit(p)
