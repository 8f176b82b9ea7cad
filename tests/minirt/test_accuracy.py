"""The kernels' t against exact arithmetic: at most 4 ulp × condition number.

An ulp is 2⁻⁵² relative; the condition numbers are those of `reference.exact.condition`, from the
exact solution in 400-bit mpmath.

A decision (hit or miss) is a sign of g(x). It is decided where no relative change of the inputs
by 4 ulp reverses it, |g| > 4 ulp · Σ |∂g/∂x_i · x_i|, evaluated in rational arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import minirt
from minirt.rules import SLIDES
from minirt.shapes.plane import edge_normal
from minirt.shapes.triangle import TriangleCase
from minirt.vectors import Floats
from reference.exact.condition import (
    BOUND,
    ULP,
    Vector,
    cross,
    dot,
    fan_normals,
    minus,
    polygon_condition,
    sensitivity,
    sphere_condition,
    triangle_condition,
    triangle_weights,
)

#: Rays of each family; mpmath takes some 0.3 ms each.
COUNT = 300


def _numbers(kind: type, *columns: Floats) -> list[list[Any]]:
    return [[kind(float(c)) for c in column] for column in columns]


def _directions(rng: np.random.Generator, n: int) -> Floats:
    d = rng.normal(size=(3, n))
    return np.asarray(d / np.sqrt((d * d).sum(axis=0)))


def _across(rng: np.random.Generator, d: Floats) -> Floats:
    """Unit vectors perpendicular to d, to rounding."""
    side = np.cross(_directions(rng, d.shape[1]), d, axis=0)
    return np.asarray(side / np.sqrt((side * side).sum(axis=0)))


# -- spheres ---------------------------------------------------------------------------------------

Spheres = tuple[Floats, Floats, Floats, Floats]


def _aimed(
    rng: np.random.Generator, n: int, far: float, offset: Floats, radius: float = 1.0
) -> Spheres:
    """Rays that pass the centre of a sphere at `offset` radii, from `far` radii away."""
    d = _directions(rng, n)
    C = rng.normal(size=(3, n)) * radius
    P0 = C - far * radius * d + offset * radius * _across(rng, d)
    return P0, d * rng.uniform(0.1, 10.0, n), C, np.full(n, radius)


def _random(rng: np.random.Generator, n: int) -> Spheres:
    return _aimed(rng, n, 5.0, rng.uniform(0, 1, n))


def _grazing(rng: np.random.Generator, n: int) -> Spheres:
    return _aimed(rng, n, 5.0, np.sqrt(1 - 10.0 ** rng.uniform(-12, -2, n)))


def _far(rng: np.random.Generator, n: int) -> Spheres:
    return _aimed(rng, n, 1e6, rng.uniform(0, 1, n))


def _far_grazing(rng: np.random.Generator, n: int) -> Spheres:
    return _aimed(rng, n, 1e6, np.sqrt(1 - 10.0 ** rng.uniform(-9, -2, n)))


def _inside(rng: np.random.Generator, n: int) -> Spheres:
    d, C = _directions(rng, n), rng.normal(size=(3, n))
    return C + 0.99 * rng.uniform(0, 1, n) * _directions(rng, n), d, C, np.ones(n)


def _on_surface(rng: np.random.Generator, n: int) -> Spheres:
    d, C = _directions(rng, n), rng.normal(size=(3, n))
    return C + _directions(rng, n), d, C, np.ones(n)


def _behind_surface(rng: np.random.Generator, n: int) -> Spheres:
    P0, d, C, R = _on_surface(rng, n)
    return P0 + (P0 - C) * 10.0 ** rng.uniform(-14, -3, n), d, C, R


def _huge(rng: np.random.Generator, n: int) -> Spheres:
    return _aimed(rng, n, 5.0, rng.uniform(0, 1, n), 1e12)


def _tiny(rng: np.random.Generator, n: int) -> Spheres:
    return _aimed(rng, n, 5.0, rng.uniform(0, 1, n), 1e-12)


def _along_axes(rng: np.random.Generator, n: int) -> Spheres:
    C, R = rng.normal(size=(3, n)), np.ones(n)
    d = np.eye(3)[:, rng.integers(0, 3, n)] * np.array([[1.0], [-1.0], [1.0]])
    return C - 50.0 * d + rng.uniform(0, 0.999, n) * _across(rng, d), d, C, R


def _integers(rng: np.random.Generator, n: int) -> Spheres:
    d = rng.integers(-3, 4, (3, n)).astype(float)
    d[2] += (d == 0).all(axis=0)
    C = rng.integers(-4, 5, (3, n)).astype(float)
    return C - rng.integers(4, 30, n) * d, d, C + rng.integers(0, 2, (3, n)), np.full(n, 2.0)


SPHERES = {
    f.__name__[1:]: f
    for f in (
        _random, _grazing, _far, _far_grazing, _inside, _on_surface, _behind_surface, _huge,
        _tiny, _along_axes, _integers,
    )
}  # fmt: skip


def _sphere_exact(P0: Vector, d: Vector, C: Vector, R: Any) -> list[Any]:
    """Both roots with 400 bits, or none."""
    L, a = minus(C, P0), dot(d, d)
    b = dot(d, L)
    quarter = b * b - a * (dot(L, L) - R * R)
    if quarter < 0:
        return []
    root = mp.sqrt(quarter)
    return [(b - root) / a, (b + root) / a]


@pytest.mark.parametrize("family", SPHERES)
def test_sphere_t_is_within_4_ulp_times_its_condition(family: str) -> None:
    P0, d, C, R = SPHERES[family](np.random.default_rng(8), COUNT)
    near, far = minirt.intersect_sphere(P0, d, C, R)[1:]
    worst, ran = 0.0, 0
    with mp.workprec(400):
        for k in range(COUNT):
            p, e, c = _numbers(mpf, P0[:, k], d[:, k], C[:, k])
            roots = _sphere_exact(p, e, c, mpf(R[k]))
            if not roots or roots[0] == roots[1] or np.isinf(near[k]):
                continue
            for t, ours in zip(roots, (near[k], far[k]), strict=True):
                if t == 0:
                    assert ours == 0
                    continue
                condition = sphere_condition(t, p, e, c, mpf(R[k]))
                worst = max(worst, float(abs(mpf(ours) - t) / abs(t) / condition / ULP))
                ran += 1
    assert ran > COUNT
    assert worst <= BOUND


@pytest.mark.parametrize("family", SPHERES)
def test_sphere_hit_or_miss_agrees_with_rational_arithmetic(family: str) -> None:
    rng = np.random.default_rng(9)
    P0, d, C, R = SPHERES[family](rng, COUNT)
    R = R * (1 + np.where(rng.random(COUNT) < 0.5, 0, rng.normal(size=COUNT) * 1e-6))
    found = np.isfinite(minirt.intersect_sphere(P0, d, C, R).near)
    decided = 0
    for k in range(COUNT):
        p, e, c = _numbers(Fraction, P0[:, k], d[:, k], C[:, k])
        r, L, a = Fraction(float(R[k])), minus(c, p), dot(e, e)
        b = dot(e, L)
        g = b * b - a * (dot(L, L) - r * r)
        by_center = [2 * (b * x - a * y) for x, y in zip(e, L, strict=True)]
        by_d = [2 * (b * y - x * (dot(L, L) - r * r)) for x, y in zip(e, L, strict=True)]
        movement = (
            sensitivity(by_center, c)
            + sensitivity(by_center, p)
            + sensitivity(by_d, e)
            + 2 * a * r * r
        )
        if abs(g) > Fraction(4 * ULP) * movement:
            decided += 1
            assert found[k] == (g > 0)
    assert decided > 0.5 * COUNT


# -- triangles -------------------------------------------------------------------------------------

Triangles = tuple[Floats, Floats, Floats, Floats, Floats]
Corners = tuple[Floats, Floats, Floats]


def _toward(
    rng: np.random.Generator, a: Floats, b: Floats, c: Floats, origin: Callable[[Floats], Floats]
) -> Triangles:
    """Rays from origin(M) through a random point M of each triangle."""
    n = a.shape[1]
    weights = rng.dirichlet((0.5, 0.5, 0.5), n).T
    M = weights[0] * a + weights[1] * b + weights[2] * c
    P0 = origin(M)
    return P0, (M - P0) * 10.0 ** rng.uniform(-2, 2, n), a, b, c


def _vertices(rng: np.random.Generator, n: int, size: float = 1.0) -> Corners:
    a, b, c = size * rng.normal(size=(3, 3, n))
    return a, b, c


def _triangle_random(rng: np.random.Generator, n: int) -> Triangles:
    return _toward(rng, *_vertices(rng, n), lambda M: M + 3 * _directions(rng, n))


def _edges(
    rng: np.random.Generator, n: int, first: Floats, second: Floats, turn: Floats
) -> Corners:
    """Triangles with two edges of given lengths and the sine of the angle between them."""
    e = _directions(rng, n)
    a = rng.normal(size=(3, n))
    return a, a + first * e, a + second * (e * np.sqrt(1 - turn * turn) + turn * _across(rng, e))


def _needles(rng: np.random.Generator, n: int) -> Triangles:
    corners = _edges(rng, n, np.full(n, 1e4), np.full(n, 1e-4), rng.uniform(0.1, 1, n))
    return _toward(rng, *corners, lambda M: M + 10.0 ** rng.uniform(-4, 4, n) * _directions(rng, n))


def _caps(rng: np.random.Generator, n: int) -> Triangles:
    turn = 10.0 ** rng.uniform(-12, -6, n)
    corners = _edges(rng, n, np.full(n, 1e4), np.full(n, 6e3), turn)
    return _toward(rng, *corners, lambda M: M + 10.0 ** rng.uniform(-4, 4, n) * _directions(rng, n))


def _mixed_edges(rng: np.random.Generator, n: int) -> Triangles:
    first, second = 10.0 ** rng.uniform(-4, 4, (2, n))
    corners = _edges(rng, n, first, second, 10.0 ** rng.uniform(-6, 0, n))
    return _toward(rng, *corners, lambda M: M + 10.0 ** rng.uniform(-4, 4, n) * _directions(rng, n))


def _edge_on(rng: np.random.Generator, n: int) -> Triangles:
    a, b, c = _vertices(rng, n)
    N = np.cross(b - a, c - a, axis=0)

    def beside(M: Floats) -> Floats:
        along = (b - a) * rng.normal(size=n) + (c - a) * rng.normal(size=n)
        return np.asarray(M + along + N * 10.0 ** rng.uniform(-12, -3, n))

    return _toward(rng, a, b, c, beside)


def _far_observer(rng: np.random.Generator, n: int) -> Triangles:
    return _toward(rng, *_vertices(rng, n), lambda M: M + 1e6 * _directions(rng, n))


def _far_from_origin(rng: np.random.Generator, n: int) -> Triangles:
    shift = 1e5 * rng.normal(size=(3, n))
    a, b, c = (v + shift for v in _vertices(rng, n))
    return _toward(rng, a, b, c, lambda M: M + 3 * _directions(rng, n))


def _close_to_large(rng: np.random.Generator, n: int) -> Triangles:
    a, b, _ = _vertices(rng, n, 1e4)
    c = rng.normal(size=(3, n))
    return _toward(rng, a, b, c, lambda M: M + 1e-4 * _directions(rng, n))


def _floor(rng: np.random.Generator, n: int) -> Triangles:
    a, b, c = _vertices(rng, n, 1e3)
    a[2], b[2], c[2] = 0.0, 0.0, 0.0
    height = 10.0 ** rng.uniform(-9, -3, n)

    def low(M: Floats) -> Floats:
        P0 = M + 100.0 * _directions(rng, n)
        P0[2] = height
        return P0

    return _toward(rng, a, b, c, low)


TRIANGLES = {
    f.__name__[1:]: f
    for f in (
        _triangle_random, _needles, _caps, _mixed_edges, _edge_on, _far_observer,
        _far_from_origin, _close_to_large, _floor,
    )
}  # fmt: skip


def _triangle_exact(P0: Vector, d: Vector, *corners: Vector) -> tuple[Any, Any]:
    """Exact t, and its condition number."""
    (N,) = fan_normals(corners)
    t = dot(minus(corners[0], P0), N) / dot(d, N)
    return t, triangle_condition(t, P0, d, corners)


@pytest.mark.parametrize("family", TRIANGLES)
def test_triangle_t_is_within_4_ulp_times_its_condition(family: str) -> None:
    rays = TRIANGLES[family](np.random.default_rng(10), COUNT)
    hits = minirt.intersect_triangle(*rays)
    worst, ran = 0.0, 0
    with mp.workprec(400):
        for k in np.flatnonzero(hits.case == TriangleCase.INSIDE):
            t, condition = _triangle_exact(*_numbers(mpf, *(v[:, k] for v in rays)))
            worst = max(worst, float(abs(mpf(hits.t[k]) - t) / abs(t) / condition / ULP))
            ran += 1
    assert ran > 0.4 * COUNT
    assert worst <= BOUND


@pytest.mark.parametrize("family", TRIANGLES)
def test_triangle_inside_or_outside_agrees_with_rational_arithmetic(family: str) -> None:
    rng = np.random.default_rng(11)
    P0, d, a, b, c = TRIANGLES[family](rng, COUNT)
    d = d + 1e-3 * (rng.random(COUNT) < 0.5) * (b - a) * rng.normal(size=COUNT)
    case = minirt.intersect_triangle(P0, d, a, b, c).case
    decided = 0
    for k in range(COUNT):
        p, e, *corners = _numbers(Fraction, P0[:, k], d[:, k], a[:, k], b[:, k], c[:, k])
        w, total = triangle_weights(p, e, corners)
        moves = _moves(p, e, corners)
        if all(abs(x) > Fraction(4 * ULP) * m for x, m in zip(w, moves, strict=True)):
            decided += 1
            inside = all(x / total >= 0 for x in w)
            assert case[k] == (TriangleCase.INSIDE if inside else TriangleCase.OUTSIDE), (family, k)
    assert decided > 0.5 * COUNT


def _moves(P0: Vector, d: Vector, corners: Sequence[Vector]) -> list[Any]:
    """Σ |∂w/∂x_i · x_i| of each weight d·(C × B): ∂d is C × B, ∂B is d × C, ∂C is B × d."""
    A, B, C = (minus(x, P0) for x in corners)
    a, b, c = corners
    result = []
    for x, y, X, Y in ((B, C, b, c), (C, A, c, a), (A, B, a, b)):
        by_x, by_y = cross(d, y), cross(x, d)
        by_origin = [-p - q for p, q in zip(by_x, by_y, strict=True)]
        movement = sensitivity(cross(y, x), d) + sensitivity(by_x, X) + sensitivity(by_y, Y)
        result.append(movement + sensitivity(by_origin, P0))
    return result


# -- polygons --------------------------------------------------------------------------------------


def _polygon(rng: np.random.Generator, m: int, size: float, away: float) -> Floats:
    """A convex polygon on an ellipse in a random plane, (m, 3)."""
    turn = np.sort(rng.uniform(0, 2 * np.pi, m)) if m < 5 else np.arange(m) * (2 * np.pi / m)
    n = _directions(rng, 1)
    u = _across(rng, n)
    v = np.cross(n, u, axis=0)
    center = away * rng.normal(size=(3, 1))
    return np.asarray((center + size * (np.cos(turn) * u + 0.3 * np.sin(turn) * v)).T)


@pytest.mark.parametrize("m", [3, 5, 8, 64])
@pytest.mark.parametrize(("size", "away"), [(1.0, 1.0), (1e4, 1.0), (1e-4, 1.0), (1.0, 1e5)])
def test_polygon_t_is_within_4_ulp_times_its_condition(m: int, size: float, away: float) -> None:
    rng = np.random.default_rng(12)
    vertices = _polygon(rng, m, size, away)
    n = COUNT // 3
    weights = rng.dirichlet(np.full(m, 0.3), n)
    M = (weights @ vertices).T
    P0 = M + size * 10.0 ** rng.uniform(-4, 2, n) * _directions(rng, n)
    d = M - P0
    hits = minirt.intersect_polygon(P0, d, vertices)
    worst, ran = 0.0, 0
    with mp.workprec(400):
        P = _numbers(mpf, *vertices)
        p = [sum(column) for column in zip(*fan_normals(P), strict=True)]
        for k in np.flatnonzero(hits.triangle >= 0):
            o, e = _numbers(mpf, P0[:, k], d[:, k])
            t = dot(minus(P[0], o), p) / dot(e, p)
            condition = polygon_condition(t, o, e, P)
            worst = max(worst, float(abs(mpf(hits.t[k]) - t) / abs(t) / condition / ULP))
            ran += 1
    assert ran > 0.4 * n
    assert worst <= BOUND


def test_edge_normal_is_correct_to_an_ulp() -> None:
    """Each component to 1 ulp, but for what lies under 2⁻⁹⁸ of the product of the edges."""
    rng = np.random.default_rng(13)
    ran = 0
    for family in (_needles, _caps, _mixed_edges, _far_from_origin):
        _, _, a, b, c = family(rng, COUNT)
        N = edge_normal(a, b, c)
        for k in range(COUNT):
            x, y, z = _numbers(Fraction, a[:, k], b[:, k], c[:, k])
            e, f = minus(y, x), minus(z, x)
            size = max(map(abs, e)) * max(map(abs, f))
            for ours, exact in zip(N[:, k], cross(e, f), strict=True):
                assert abs(Fraction(float(ours)) - exact) <= (
                    Fraction(ULP) * abs(exact) + Fraction(2.0**-98) * size
                )
                ran += 1
    assert ran == 4 * 3 * COUNT


@pytest.mark.parametrize("tilt", [1.0, 1e-3, 1e-14, 0.0])
def test_what_many_rays_share_changes_no_bit(tilt: float) -> None:
    """One origin, one plane: whatever is looked at once for all is as if looked at for each."""
    rng = np.random.default_rng(7)
    n = 4000
    x, y = np.array([-3.0, 1e4, 2, -2, -2.5]), np.array([-1.0, -2, 1e4, 4, -0.9])
    a, b, c, e, P0 = np.stack((x, y, 0.3 * x - 0.2 * y), axis=1)[:, :, None]
    P0[2] += 4.0 * tilt
    shares = rng.dirichlet((0.3, 0.3, 0.3), n).T * 10.0 ** rng.uniform(-6, 0, n)
    target = a + shares[1] * (b - a) + shares[2] * (c - a) - 0.01 * (rng.random(n) < 0.2)
    d = (target - P0) * 10.0 ** rng.uniform(-2, 2, n)
    each = np.ascontiguousarray(np.broadcast_to(P0, d.shape))
    N = edge_normal(a, b, c)
    of_each_ray = [np.ascontiguousarray(np.broadcast_to(v, d.shape)) for v in (a, b, c, N)]
    shared = SLIDES.triangle(P0, d, a, b, c, N)
    own_a, own_b, own_c, own_N = of_each_ray
    alone = SLIDES.triangle(each, d, own_a, own_b, own_c, own_N)
    for name in shared._fields:
        assert getattr(shared, name).tobytes() == getattr(alone, name).tobytes(), name
    fan = (np.stack((a, a), axis=1), np.stack((b, c), axis=1), np.stack((c, e), axis=1))
    normals = np.stack([edge_normal(*(v[:, k] for v in fan)) for k in (0, 1)], axis=1)
    p = normals.sum(axis=1)
    rules = SLIDES.plane, SLIDES.triangle
    shared_polygon = SLIDES.polygon(P0, d, fan, normals, p, *rules)
    first, second, third = (np.repeat(v, n, axis=2) for v in fan)
    alone_polygon = SLIDES.polygon(
        each,
        d,
        (first, second, third),
        np.repeat(normals, n, axis=2),
        np.repeat(p, n, axis=1),
        *rules,
    )
    for name in shared_polygon._fields:
        one, other = getattr(shared_polygon, name), getattr(alone_polygon, name)
        assert one.tobytes() == other.tobytes(), name
    assert (shared.case == TriangleCase.INSIDE).sum() > (500 if tilt else -1)
