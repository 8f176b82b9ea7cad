"""A scene's primitives for the judge: their float64 numbers as fractions and as balls."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from minirt.scene import Scene, Sphere
from minirt.vectors import Floats
from reference.exact.balls import Ball, as_ball, blurred_by, known, rationals, sharp, unit
from reference.exact.condition import (
    BOUND,
    ULP,
    Vector,
    cross,
    dot,
    fan_normals,
    minus,
    polygon_condition,
    sphere_condition,
    triangle_condition,
)
from reference.exact.shapes import (
    MISSED,
    Intersection,
    Ray,
    intersect_polygon,
    intersect_sphere,
    intersect_triangle,
)

#: Normals below 2⁻⁹⁰ of the product of two edges may be zero to minirt; divided by the 4 ulp by
#: which `blurred_by` multiplies a size.
_DEGENERATE = 2.0**-90 / (BOUND * ULP)


class ExactRay(NamedTuple):
    """A primary ray from the scene's numbers: fractions, and the sizes of d's terms."""

    P0: list[Any]
    d: list[Any]
    d_size: list[Any]


class Solution(NamedTuple):
    """The exact t, and its condition number."""

    t: Ball
    condition: Ball


@dataclass(frozen=True, eq=False)
class SpherePrimitive:
    """A sphere: object number, centre (3,) and radius."""

    object: int
    center: Floats
    radius: float

    @property
    def points(self) -> Floats:
        """The centre, (1, 3)."""
        return self.center[None]

    @cached_property
    def _balls(self) -> tuple[list[Ball], Ball]:
        return known(self.center), known([self.radius])[0]

    def intersect(self, ray: Ray) -> Intersection:
        """Whether a ray hits it. Source: S8."""
        return intersect_sphere(ray, *self._balls)

    def normal_at(self, M: Vector) -> list[Ball]:
        """(M − C)/‖M − C‖. Source: S8."""
        return unit(minus(M, [as_ball(x) for x in rationals(self.center)]))

    def solve(self, ray: ExactRay) -> Solution:
        """The smallest positive root of a ray that has one: fractions up to the square root."""
        C, (R,) = rationals(self.center), rationals([self.radius])
        L = minus(C, ray.P0)
        a, b, c = dot(ray.d, ray.d), dot(ray.d, L), dot(L, L) - R * R
        sign = -1 if b > 0 and c > 0 else 1
        t = sharp(lambda: (b + sign * as_ball(b * b - a * c).sqrt()) / a)
        P0, d, d_size, center = _as_balls(*ray, C)
        return Solution(t, sphere_condition(t, P0, d, center, as_ball(R), d_size))


@dataclass(frozen=True, eq=False)
class TrianglePrimitive:
    """A triangle or a face of a mesh: object and face number, vertices (3, 3)."""

    object: int
    face: int
    points: Floats

    @cached_property
    def _corners(self) -> list[list[Ball]]:
        return [known(row) for row in self.points]

    @cached_property
    def _normal(self) -> list[Ball]:
        return _sum_of_fan(self.points)

    def intersect(self, ray: Ray) -> Intersection:
        """Whether a ray hits it; a degenerate triangle never does. Source: S9."""
        if not any(self._normal):
            return MISSED
        return intersect_triangle(ray, self._corners, self._normal, self.face)

    def normal_at(self, M: Vector) -> list[Ball]:
        """The unit normal of the right-hand rule, the same everywhere. Source: S9."""
        return unit(self._normal)

    def solve(self, ray: ExactRay) -> Solution:
        """t of the plane of a ray that is not parallel to it: fractions throughout."""
        a, b, c = (rationals(row) for row in self.points)
        N = cross(minus(b, a), minus(c, a))
        t = as_ball(dot(minus(a, ray.P0), N) / dot(ray.d, N))
        P0, d, d_size, *corners = _as_balls(*ray, a, b, c)
        return Solution(t, triangle_condition(t, P0, d, corners, d_size))


@dataclass(frozen=True, eq=False)
class PolygonPrimitive:
    """A convex polygon: object number, vertices (m, 3)."""

    object: int
    points: Floats

    @cached_property
    def _corners(self) -> list[list[Ball]]:
        return [known(row) for row in self.points]

    @cached_property
    def _normal(self) -> list[Ball]:
        return _sum_of_fan(self.points)

    def intersect(self, ray: Ray) -> Intersection:
        """Whether a ray hits it. Source: S10, S11."""
        return intersect_polygon(ray, self._corners, self._normal)

    def normal_at(self, M: Vector) -> list[Ball]:
        """The plane's unit normal of the right-hand rule. Source: S10."""
        return unit(self._normal)

    def solve(self, ray: ExactRay) -> Solution:
        """t of the plane of a ray that is not parallel to it: fractions throughout. Source: S10."""
        P = [rationals(row) for row in self.points]
        p = [sum(column) for column in zip(*fan_normals(P), strict=True)]
        t = as_ball(dot(minus(P[0], ray.P0), p) / dot(ray.d, p))
        P0, d, d_size, *corners = _as_balls(*ray, *P)
        return Solution(t, polygon_condition(t, P0, d, corners, d_size))


Primitive: TypeAlias = SpherePrimitive | TrianglePrimitive | PolygonPrimitive


def primitives(scene: Scene) -> Iterator[Primitive]:
    """A scene's primitives, in the order of its objects and their faces."""
    for number, thing in enumerate(scene.objects):
        if isinstance(thing, Sphere):
            yield SpherePrimitive(number, thing.center, thing.radius)
        elif thing.type == "polygon":
            yield PolygonPrimitive(number, thing.vertices)
        else:
            for face, corners in enumerate(thing.vertices[thing.faces]):
                yield TrianglePrimitive(number, face, corners)


def _sum_of_fan(points: Floats) -> list[Ball]:
    """The normal of a triangle or polygon, within 4 ulp of the fan's normals that it sums up.

    Also within 2⁻⁹⁰ of the largest product of edges: a triangle with a smaller normal is
    degenerate to minirt. A normal that is exactly zero stays zero.
    """
    P = [rationals(row) for row in points]
    columns = list(zip(*fan_normals(P), strict=True))
    total = [sum(column) for column in columns]
    if not any(total):
        return [as_ball(0)] * 3
    edges = as_ball(max(abs(x) for corner in P[1:] for x in minus(corner, P[0])))
    size = [as_ball(sum(map(abs, column))) + _DEGENERATE * edges * edges for column in columns]
    return [blurred_by(as_ball(x), y) for x, y in zip(total, size, strict=True)]


def _as_balls(*vectors: Vector) -> list[list[Ball]]:
    return [[as_ball(x) for x in v] for v in vectors]
