"""S9: the triangle."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from minirt.shapes.plane import plane_t
from minirt.vectors import Floats, Ints, cross, dot


class Meeting(IntEnum):
    """S9's three cases."""

    INSIDE = 0
    #: The plane is met outside the triangle.
    OUTSIDE = 1
    #: No β, γ: the ray is parallel to the plane, or the triangle is degenerate.
    NONE = 2


class TriangleHits(NamedTuple):
    """The solution of equation (3) and which of the three cases it is.

    Attributes
    ----------
    t, beta, gamma : (n,) float64
        Solution of P0 + t·d = (1−β−γ)a + βb + γc; t = +inf and β = γ = NaN in case NONE.
    case : (n,) int32
        A `Meeting`.
    """

    t: Floats
    beta: Floats
    gamma: Floats
    case: Ints


def triangle_hit(
    P0: Floats, d: Floats, a: Floats, b: Floats, c: Floats, N: Floats
) -> TriangleHits:
    """Solve S9's equation (3) for t, β, γ.

    The weights are Cramer's quotients of volumes spanned by d and the triangle's edges as seen
    from P0. Written with sum and difference of an edge's ends, the volume of a shared edge has
    exactly opposite signs for its two triangles, so that no ray slips between them. t is the
    plane's (S10), with a normal that is correct to an ulp for needles too.

    Parameters
    ----------
    P0, d : (3, n) float64
    a, b, c : (3, n) or (3, 1) float64
        Vertices.
    N : (3, n) or (3, 1) float64
        `minirt.vectors.edge_normal` of a, b, c; zero says degenerate.

    Returns
    -------
    TriangleHits
        t of either sign: the interval is S6's matter.

    Source: S9, E3.
    """
    A, B, C = a - P0, b - P0, c - P0
    weight_a = dot(d, cross(B + C, b - c))
    weight_b = dot(d, cross(C + A, c - a))
    weight_c = dot(d, cross(A + B, a - b))
    total = weight_a + weight_b + weight_c
    t = plane_t(P0, d, a, N)
    none = np.isinf(t) | (total == 0)
    total = np.where(none, 1.0, total)
    inside = ((weight_a >= 0) & (weight_b >= 0) & (weight_c >= 0)) | (
        (weight_a <= 0) & (weight_b <= 0) & (weight_c <= 0)
    )
    case = np.where(none, Meeting.NONE, np.where(inside, Meeting.INSIDE, Meeting.OUTSIDE))
    return TriangleHits(
        np.where(none, np.inf, t),
        np.where(none, np.nan, weight_b / total),
        np.where(none, np.nan, weight_c / total),
        case.astype(np.int32),
    )


