"""S9, S10: the plane of a triangle or a polygon (E7: the slide says 'of the triangle')."""

from __future__ import annotations

import numpy as np

from minirt.shapes.compensated import pair_cross, two_difference
from minirt.vectors import Floats, dot, norm, unit

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
    return over_slope(dot(P1 - P0, p), d, p)


def over_slope(ahead: Floats, d: Floats, p: Floats) -> Floats:
    """ahead/(d·p), (n,); +inf where d·p cannot be told from zero."""
    slope = dot(d, p)
    t: Floats
    if steeper(slope, UNDECIDED_SLOPE, d, p):
        t = ahead / slope
    else:
        size = np.abs(d[0] * p[0]) + np.abs(d[1] * p[1]) + np.abs(d[2] * p[2])
        parallel = np.abs(slope) <= UNDECIDED_SLOPE * size
        t = np.where(parallel, np.inf, ahead / np.where(parallel, 1.0, slope))
    return t


def steeper(slope: Floats, share: float, d: Floats, p: Floats) -> bool:
    """Whether one plane's d·p are all surely above a share of ‖d‖‖p‖ and of Σ|dᵢpᵢ|, in size.

    Both are at most 3 · max|dᵢ| · max|pᵢ|: one bound for all rays spares a look at each.
    """
    if p.shape[1] > 1 or not slope.size:
        return False
    least = max(slope.min(), -slope.max())
    return bool(least > 4.0 * share * max(d.max(), -d.min()) * max(p.max(), -p.min()))


def plane_normal(p: Floats) -> Floats:
    """The unit normal s of a plane on the side of the right-hand rule. Source: S9, S10."""
    return unit(p)


def edge_normal(a: Floats, b: Floats, c: Floats) -> Floats:
    """(b − a) × (c − a) with each component correct to about one ulp.

    Plain float64 loses the digits of needles and caps: with edges that are nearly parallel the
    two products of a component cancel. Edges and products are therefore carried with their
    rounding errors, which leaves an error near 2⁻¹⁰² of the product of the edge lengths. What is
    smaller than 2⁻⁹⁰ of it cannot be told from zero and is returned as zero: a degenerate triangle.

    Parameters
    ----------
    a, b, c : (3, n) float64
        Vertices in scene units.

    Returns
    -------
    (3, n) float64
        Twice the area times the unit normal of the right-hand rule; zero where degenerate.

    Source: S9.
    """
    e, f = two_difference(b, a), two_difference(c, a)
    normal = pair_cross(e, f)[0]
    normal[:, norm(normal) <= norm(e[0]) * norm(f[0]) * 2.0**-90] = 0.0
    return normal
