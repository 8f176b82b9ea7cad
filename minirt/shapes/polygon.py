"""S10, S11: the convex polygon."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from minirt.shapes.close_calls import within_span
from minirt.shapes.triangle import TriangleCase, TriangleHits
from minirt.vectors import Floats, Index, Ints, dot, norm, take


class PolygonHits(NamedTuple):
    """t of the plane, and the fan triangle the point lies in.

    Attributes
    ----------
    t : (n,) float64
        +inf where the plane is met outside the polygon, or not at all.
    triangle : (n,) int32
        The first fan triangle 0…m−3 that holds the point; −1 for none.
    beta, gamma : (n,) float64
        Weights within that triangle; NaN for none.
    """

    t: Floats
    triangle: Ints
    beta: Floats
    gamma: Floats


def fan(m: int) -> Ints:
    """The m − 2 triangles (P1, Pk, Pk+1) of a polygon's fan, as indices (m − 2, 3). Source: S11."""
    k = np.arange(1, m - 1, dtype=np.int32)
    return np.stack((np.zeros_like(k), k, k + 1), axis=1)


def polygon_hit(
    P0: Floats,
    d: Floats,
    corners: tuple[Floats, Floats, Floats],
    fan_normals: Floats,
    p: Floats,
    plane: Callable[[Floats, Floats, Floats, Floats], Floats],
    triangle: Callable[[Floats, Floats, Floats, Floats, Floats, Floats], TriangleHits],
) -> PolygonHits:
    """Meet the plane (S10), then ask the fan's triangles in turn (S9) which one holds the point.

    Seen so nearly edge-on that the plane's t says nothing, t is that triangle's.

    Parameters
    ----------
    P0, d : (3, n) float64
    corners : three (3, m − 2) or (3, m − 2, n) float64
        The fan's triangles, P1, Pk, Pk+1: one polygon's, or those of each ray's own.
    fan_normals : (3, m − 2) or (3, m − 2, n) float64
        Their `edge_normal`.
    p : (3, 1) or (3, n) float64
        The polygon's normal, of any length.
    plane, triangle
        The rules S10 and S9 in force.

    Source: S11.
    """
    n = d.shape[1]
    fans = [v.reshape(3, v.shape[1], -1) for v in (*corners, fan_normals)]
    t = plane(P0, d, fans[0][:, 0], p)
    index = np.full(n, -1, dtype=np.int32)
    beta, gamma = np.full(n, np.nan), np.full(n, np.nan)
    pending = np.arange(n)
    for k in range(fans[0].shape[1]):
        a, b, c, N = (_of(v[:, k], pending) for v in fans)
        meeting = triangle(P0, d, a, b, c, N)
        holds = meeting.case == TriangleCase.INSIDE
        held, open_ = np.flatnonzero(holds), np.flatnonzero(~holds)
        chosen, now = pending[held], t[pending]
        now = np.where(holds & np.isinf(now), meeting.t, now)
        t[pending] = within_span(now, holds, P0, d, a, b, c, _of(p, pending))
        index[chosen], beta[chosen], gamma[chosen] = k, meeting.beta[held], meeting.gamma[held]
        pending, P0, d = pending[open_], _of(P0, open_), take(d, open_)
    return PolygonHits(np.where(index >= 0, t, np.inf), index, beta, gamma)


def _of(v: Floats, rays: Index) -> Floats:
    """Each ray's own of vectors (3, n); the one of (3, 1)."""
    return v if v.shape[1] == 1 else take(v, rays)


def polygon_normal(fan_normals: Floats) -> Floats:
    """p: the sum of the fan's normals, (3, 1); in a plane they differ in length only."""
    total = np.zeros((3, 1))
    for k in range(fan_normals.shape[1]):
        total += fan_normals[:, k : k + 1]
    return total


def polygon_fault(vertices: Floats, fan_normals: Floats) -> str | None:
    """Why S11 cannot take this polygon, or None.

    The plane must hold every vertex to 1e-9 of the polygon's size (and 8 ulp of the coordinates);
    every corner must turn the normal's way, or not at all, to within the same distance.

    Parameters
    ----------
    vertices : (m, 3) float64
    fan_normals : (3, m − 2) float64
    """
    P = vertices.T
    size = float(norm(P.max(axis=1) - P.min(axis=1)))
    slack = 1e-9 * size + 8 * 2.0**-53 * float(np.abs(P).max())
    p = polygon_normal(fan_normals)
    length = float(norm(p)[0])
    if length == 0:
        return "the polygon has no area"
    s = p / length
    off = np.abs(dot(P - P[:, :1], s))
    if off.max() > slack:
        worst = f"vertices[{int(off.argmax())}] lies {off.max():.3g} scene units off its plane"
        return f"the polygon is not planar: {worst}"
    ahead, behind = np.roll(P, -1, axis=1) - P, P - np.roll(P, 1, axis=1)
    turn = dot(np.cross(behind, ahead, axis=0), s)
    reach = np.maximum(norm(ahead), norm(behind))
    if (turn < -slack * reach).any() or (dot(fan_normals, s) < -slack * size).any():
        corner = int(turn.argmin())
        return f"the polygon is not convex, or turns more than once: see vertices[{corner}]"
    return None
