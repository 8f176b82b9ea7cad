"""S8: the sphere."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from minirt.vectors import Floats, dot, unit


class Quadratic(NamedTuple):
    """The slide's equation a·t² − 2b·t + c = 0, each (n,) float64, and a quarter of its Δ."""

    a: Floats
    b: Floats
    c: Floats
    quarter_delta: Floats


def sphere_quadratic(P0: Floats, d: Floats, C: Floats, R: Floats) -> Quadratic:
    """a = d·d, b = d·(C−P0), c = (P0−C)·(P0−C) − R², and Δ/4.

    b² − ac cancels for far and small spheres (E8), so Δ comes from q, the vector from the line to
    the centre: Δ/4 = (d·d)(R² − q·q).

    Source: S8, E8.
    """
    L = C - P0
    a = dot(d, d)
    b = dot(d, L)
    q = L - (b / a) * d
    return Quadratic(a, b, dot(L, L) - R * R, a * (R * R - dot(q, q)))


def sphere_roots(P0: Floats, d: Floats, C: Floats, R: Floats) -> tuple[Floats, Floats]:
    """Both parameters t at which a line meets a sphere, smaller first.

    The equation is the slide's, (d·d)t² + 2d·(P0−C)t + (P0−C)·(P0−C) − R² = 0, and so is the
    test Δ ≥ 0, but the textbook −b ± √Δ cancels where the two have nearly one magnitude (E8). So
    the root of larger magnitude comes first, whose terms have one sign; the other is c/a divided
    by it, from the product of the roots.

    Parameters
    ----------
    P0, d : (3, n) float64
        Origins and directions (any length but 0).
    C : (3, n) or (3, 1) float64
        Centres.
    R : (n,) or (1,) float64
        Radii, > 0.

    Returns
    -------
    near, far : (n,) float64
        near ≤ far, of either sign; +inf where Δ < 0.

    Source: S8, E8.
    """
    a, b, c, quarter_delta = sphere_quadratic(P0, d, C, R)
    meets = quarter_delta >= 0
    root = np.sqrt(np.where(meets, quarter_delta, 0.0))
    larger = b + np.copysign(root, b)
    at_tangent_point = larger == 0
    first = larger / a
    second = np.where(at_tangent_point, 0.0, c / np.where(at_tangent_point, 1.0, larger))
    near = np.where(meets, np.minimum(first, second), np.inf)
    far = np.where(meets, np.maximum(first, second), np.inf)
    return near, far


def sphere_normal(M: Floats, C: Floats) -> Floats:
    """The unit normal at M on a sphere of centre C, pointing outward. Source: S8."""
    return unit(M - C)
