"""S9: the triangle."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from minirt.shapes.close_calls import edge_on_t, edge_volumes, slack, within_span
from minirt.shapes.plane import over_slope
from minirt.vectors import Bools, Floats, Ints, cross, dot


class TriangleCase(IntEnum):
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
        A `TriangleCase`.
    """

    t: Floats
    beta: Floats
    gamma: Floats
    case: Ints


def triangle_hit(P0: Floats, d: Floats, a: Floats, b: Floats, c: Floats, N: Floats) -> TriangleHits:
    """Solve S9's equation (3) for t, β, γ.

    The weights are Cramer's quotients of volumes that d spans with two edges seen from P0. Where
    rounding could turn a volume's sign it is computed again with 106 bits, so that the triangle
    decides as exact arithmetic would, and a ray on a shared edge or vertex counts for all the
    triangles that share it: none slips through. t is the plane's (S10), measured from the vertex
    of the largest weight, so that large triangles keep the digits of what happens near a corner.

    Parameters
    ----------
    P0, d : (3, n) float64
    a, b, c : (3, n) or (3, 1) float64
        Vertices.
    N : (3, n) or (3, 1) float64
        `minirt.shapes.plane.edge_normal` of a, b, c; zero says degenerate.

    Returns
    -------
    TriangleHits
        t of either sign: the interval is S6's matter.

    Source: S9, E3.
    """
    weights, inside = _weights(P0, d, a, b, c)
    w_a, w_b, w_c = weights
    t = over_slope(_ahead(weights, P0, a, b, c, N), d, N)
    t = edge_on_t(t, inside, weights, P0, d, a, b, c, N)
    t = within_span(t, inside, P0, d, a, b, c, N)
    total = w_a + w_b + w_c
    none = np.isinf(t) | (total == 0)
    total = np.where(none, 1.0, total)
    case = np.where(
        none, TriangleCase.NONE, np.where(inside, TriangleCase.INSIDE, TriangleCase.OUTSIDE)
    )
    return TriangleHits(
        np.where(none, np.inf, t),
        np.where(none, np.nan, w_b / total),
        np.where(none, np.nan, w_c / total),
        case.astype(np.int32),
    )


def _weights(
    P0: Floats, d: Floats, a: Floats, b: Floats, c: Floats
) -> tuple[tuple[Floats, Floats, Floats], Bools]:
    """1−β−γ, β, γ, all times one number, and whether they have one sign: inside the triangle."""
    A, B, C = a - P0, b - P0, c - P0
    w_a = dot(d, cross(B + C, b - c))
    w_b = dot(d, cross(C + A, c - a))
    w_c = dot(d, cross(A + B, a - b))
    least = np.minimum(np.minimum(w_a, w_b), w_c)
    most = np.maximum(np.maximum(w_a, w_b), w_c)
    error = slack(P0, d, a, b, c)
    inside = (least > error) | (most < -error)
    close = np.nonzero(~inside & ~((least < -error) & (most > error)))
    if len(close[0]):
        w_a[close], w_b[close], w_c[close] = edge_volumes(close, P0, d, a, b, c)
        some = np.stack((w_a[close], w_b[close], w_c[close]))
        inside[close] = (some >= 0).all(axis=0) | (some <= 0).all(axis=0)
    return (w_a, w_b, w_c), inside


def _ahead(
    weights: tuple[Floats, Floats, Floats], P0: Floats, a: Floats, b: Floats, c: Floats, N: Floats
) -> Floats:
    """(V − P0)·N, (n,), of the vertex V with the largest weight."""
    x, y, z = (np.abs(w) for w in weights)
    heaviest_a, heavier_b = (x >= y) & (x >= z), y >= z
    if max(a.shape[1], P0.shape[1]) == 1:
        A, B, C = (dot(vertex - P0, N) for vertex in (a, b, c))
        return np.where(heaviest_a, A, np.where(heavier_b, B, C))
    return dot(np.where(heaviest_a, a, np.where(heavier_b, b, c)) - P0, N)
