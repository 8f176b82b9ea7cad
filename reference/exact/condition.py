"""The condition number of t: how much it changes when its inputs change.

An ulp is 2⁻⁵² relative. The condition number of t with respect to its inputs x_i (the numbers in
P0, d and in C, R or the vertices) is the componentwise relative one,

    κ = 1 + Σ |∂t/∂x_i · x_i| / |t|,

where 1 stands for the rounding of t itself. It is the factor from relative changes of the inputs
to that of t, so that no algorithm on rounded inputs can promise less than about κ ulp. The
derivatives follow from the implicit function theorem at the exact solution:

* sphere, F = |M − C|² − R² at M = P0 + t·d, with n = M − C: ∂t/∂P0 = −n/(n·d),
  ∂t/∂C = n/(n·d), ∂t/∂d = −t·n/(n·d), ∂t/∂R = R/(n·d);
* triangle with weights w_a, w_b, w_c of the hit point and normal N: a vertex moves the plane in
  proportion to its weight, ∂t/∂a = w_a·N/(d·N), and ∂t/∂P0 = −N/(d·N), ∂t/∂d = −t·N/(d·N);
* polygon, S10's plane (X − P1)·p = 0: its data are P0, d, P1 and the normals N_k of the fan, whose
  sum p is: ∂t/∂P1 = p/(d·p), ∂t/∂N_k = (P1 − M)/(d·p), the rest as for the triangle.

Numbers may be of any exact or precise type: fractions, rationals, multiple precision. If d is
itself a rounded sum, `d_size` is the size of its terms: a change of them by one ulp changes d by
one ulp of that size.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

#: 2⁻⁵²: the spacing of float64 numbers between 1 and 2.
ULP = 2.0**-52
#: minirt's promise: t is within this many ulp times its condition number.
BOUND = 4.0

Vector: TypeAlias = Sequence[Any]


def dot(a: Vector, b: Vector) -> Any:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def minus(a: Vector, b: Vector) -> Vector:
    """a − b."""
    return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def sensitivity(slope: Vector, x: Vector) -> Any:
    """Σ |∂g/∂x_i · x_i| of one vector."""
    return sum(abs(s * c) for s, c in zip(slope, x, strict=True))


def sphere_condition(
    t: Any, P0: Vector, d: Vector, C: Vector, R: Any, d_size: Vector | None = None
) -> Any:
    """κ of the parameter t at which a ray hits a sphere."""
    n = [p + t * e - c for p, e, c in zip(P0, d, C, strict=True)]
    total = sensitivity(n, P0) + sensitivity(n, C) + abs(t) * sensitivity(n, d_size or d) + R * R
    return 1 + total / abs(dot(n, d) * t)


def triangle_weights(P0: Vector, d: Vector, corners: Sequence[Vector]) -> tuple[list[Any], Any]:
    """Weights of a, b, c at the hit point, times −d·N, and −d·N itself."""
    A, B, C = (minus(x, P0) for x in corners)
    w = [dot(d, cross(y, x)) for x, y in ((B, C), (C, A), (A, B))]
    return w, sum(w)


def triangle_condition(
    t: Any, P0: Vector, d: Vector, corners: Sequence[Vector], d_size: Vector | None = None
) -> Any:
    """κ of the parameter t at which a ray hits a triangle."""
    (N,) = fan_normals(corners)
    w, total = triangle_weights(P0, d, corners)
    by_vertices = sum(abs(k / total) * sensitivity(N, x) for k, x in zip(w, corners, strict=True))
    every = sensitivity(N, P0) + abs(t) * sensitivity(N, d_size or d) + by_vertices
    return 1 + every / abs(dot(d, N) * t)


def fan_normals(P: Sequence[Vector]) -> list[Vector]:
    """The normals of a polygon's fan of triangles."""
    return [cross(minus(P[k], P[0]), minus(P[k + 1], P[0])) for k in range(1, len(P) - 1)]


def polygon_condition(
    t: Any, P0: Vector, d: Vector, P: Sequence[Vector], d_size: Vector | None = None
) -> Any:
    """κ of the parameter t at which a ray hits a polygon's plane."""
    fan = fan_normals(P)
    p = [sum(column) for column in zip(*fan, strict=True)]
    spread = [sum(map(abs, column)) for column in zip(*fan, strict=True)]
    to_P1 = [x - (y + t * z) for x, y, z in zip(P[0], P0, d, strict=True)]
    every = sensitivity(p, P0) + abs(t) * sensitivity(p, d_size or d)
    every += sensitivity(p, P[0]) + sensitivity(to_P1, spread)
    return 1 + every / abs(dot(d, p) * t)
