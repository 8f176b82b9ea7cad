"""S8: the sphere."""

from __future__ import annotations

import numpy as np

from minirt.vectors import Floats, dot, unit


def sphere_roots(P0: Floats, d: Floats, C: Floats, R: Floats) -> tuple[Floats, Floats]:
    """Both parameters t at which a line meets a sphere, smaller first.

    The equation is the slide's, (d·d)t² + 2d·(P0−C)t + (P0−C)·(P0−C) − R² = 0, and so is the
    test Δ ≥ 0, but the textbook −b ± √Δ cancels for far and small spheres (E8). So

    * Δ comes from q, the vector from the line to the centre: Δ/4 = (d·d)(R² − q·q);
    * the root of larger magnitude is (b ± √Δ)/a, whose terms have one sign;
    * the other is c/a divided by it, the product of the roots.

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
    L = C - P0
    a = dot(d, d)
    b = dot(d, L)
    q = L - (b / a) * d
    quarter_delta = a * (R * R - dot(q, q))
    meets = quarter_delta >= 0
    root = np.sqrt(np.where(meets, quarter_delta, 0.0))
    larger = b + np.copysign(root, b)
    c = dot(L, L) - R * R
    at_tangent_point = larger == 0
    first = larger / a
    second = np.where(at_tangent_point, 0.0, c / np.where(at_tangent_point, 1.0, larger))
    near = np.where(meets, np.minimum(first, second), np.inf)
    far = np.where(meets, np.maximum(first, second), np.inf)
    return near, far


def sphere_normal(M: Floats, C: Floats) -> Floats:
    """The unit normal at M on a sphere of centre C, pointing outward. Source: S8."""
    return unit(M - C)
