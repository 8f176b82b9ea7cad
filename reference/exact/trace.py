"""RT for rays whose numbers are balls: the first hit, as far as it is certain.

The primitives that a ray may hit are found in float64 without a tree: each primitive's bounding
sphere is tested against each ray, with a margin for the errors of both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from minirt.scene import Scene
from minirt.vectors import Floats, dot, norm
from reference.exact.balls import Ball, middle, radius
from reference.exact.primitives import Primitive, SpherePrimitive, primitives
from reference.exact.shapes import Answer, Intersection, Ray

#: Ray–primitive pairs tested in one pass.
_PAIRS = 2**20
#: Margin around every bounding sphere, as a share of the largest coordinate: the difference of two
#: squares in float64 can be off by some 2⁻²⁵ of it.
_MARGIN = 2.0**-20
#: Largest radius of a ray's balls, as a share of the same: the margin would not hold larger ones.
_WIDEST = 2.0**-24


class FirstHit(NamedTuple):
    """The first hit of a ray.

    Attributes
    ----------
    hit : Answer
    object, face : int or None
        −1 for nothing; None if open.
    t : Ball or None
    primitive : Primitive or None
        The one that is hit, if that is certain; else None.
    """

    hit: Answer
    object: int | None
    face: int | None
    t: Ball | None = None
    primitive: Primitive | None = None


_NOTHING = FirstHit(Answer.NO, -1, -1)
_OPEN = FirstHit(Answer.OPEN, None, None)


class Tracer:
    """Traces rays through all primitives of a scene."""

    def __init__(self, scene: Scene) -> None:
        self._primitives = list(primitives(scene))
        spheres = [_bounding_sphere(primitive) for primitive in self._primitives]
        self._center = np.array([c for c, _ in spheres]).reshape(-1, 3).T
        self._radius = np.array([r for _, r in spheres])
        box = np.zeros((2, 3)) if scene.bounds is None else scene.bounds
        self._reach = float(max(np.abs(scene.screen.P0).max(), np.abs(box).max())) + scene.extent

    def first(self, rays: Sequence[Ray]) -> list[FirstHit]:
        """RT of each ray. Source: S4, S6."""
        return [self._first(ray, near) for ray, near in self._candidates(rays)]

    def occluded(self, rays: Sequence[Ray]) -> list[Answer]:
        """Whether each ray hits anything. Source: S12."""
        return [self._occluded(ray, near) for ray, near in self._candidates(rays)]

    def _first(self, ray: Ray, near: list[tuple[float, int]] | None) -> FirstHit:
        if near is None:
            return _OPEN
        possible: list[tuple[Primitive, Intersection]] = []
        nearest: Ball | None = None
        for entry, number in near:
            if nearest is not None and nearest < entry:
                break
            primitive = self._primitives[number]
            intersection = primitive.intersect(ray)
            if intersection.answer is Answer.NO:
                continue
            if nearest is not None and intersection.t > nearest:
                continue
            possible.append((primitive, intersection))
            if intersection.answer is Answer.YES and (nearest is None or intersection.t < nearest):
                nearest = intersection.t
        return _nearest_of(possible, nearest)

    def _occluded(self, ray: Ray, near: list[tuple[float, int]] | None) -> Answer:
        if near is None:
            return Answer.OPEN
        answers = set()
        for _, number in near:
            answers.add(self._primitives[number].intersect(ray).answer)
            if Answer.YES in answers:
                return Answer.YES
        return Answer.OPEN if Answer.OPEN in answers else Answer.NO

    def _candidates(
        self, rays: Sequence[Ray]
    ) -> Iterator[tuple[Ray, list[tuple[float, int]] | None]]:
        """Each ray with the primitives that it may hit, sorted by the least t of such a hit.

        None instead of the primitives for a ray whose balls are too large.
        """
        size = max(1, _PAIRS // max(1, len(self._primitives)))
        for start in range(0, len(rays), size):
            chunk = rays[start : start + size]
            P0 = np.array([[middle(x) for x in ray.P0] for ray in chunk]).T
            d = np.array([[middle(x) for x in ray.d] for ray in chunk]).T
            for ray, near in zip(chunk, self._near(P0, d), strict=True):
                yield ray, near if self._is_narrow(ray) else None

    def _is_narrow(self, ray: Ray) -> bool:
        """Whether a ray's balls fit into the margin; those of d turn it about its origin."""
        turn = max(map(radius, ray.d)) / max(abs(middle(x)) for x in ray.d)
        return bool(turn * self._reach + max(map(radius, ray.P0)) < _WIDEST * self._reach)

    def _near(self, P0: Floats, d: Floats) -> list[list[tuple[float, int]]]:
        if not self._primitives:
            return [[] for _ in range(P0.shape[1])]
        length = norm(d)
        ahead = ((d / length).T @ self._center) - (dot(P0, d) / length)[:, None]
        apart = dot(self._center, self._center) - 2.0 * (P0.T @ self._center) + dot(P0, P0)[:, None]
        bound = self._radius + _MARGIN * self._reach
        meets = (apart - ahead * ahead <= bound * bound) & (ahead >= -bound)
        found: list[list[tuple[float, int]]] = [[] for _ in range(P0.shape[1])]
        for ray, number in zip(*(axis.tolist() for axis in np.nonzero(meets)), strict=True):
            entry = (ahead[ray, number] - bound[number]) / length[ray]
            found[ray].append((float(entry), number))
        return [sorted(near) for near in found]


def _nearest_of(possible: list[tuple[Primitive, Intersection]], nearest: Ball | None) -> FirstHit:
    """The first hit, from those that are possible and the t of the nearest certain one."""
    if nearest is None:
        return _OPEN if possible else _NOTHING
    rivals = [(p, m) for p, m in possible if not m.t > nearest]
    if len(rivals) == 1:
        primitive, intersection = rivals[0]
        return FirstHit(Answer.YES, primitive.object, intersection.face, intersection.t, primitive)
    objects = {primitive.object for primitive, _ in rivals}
    return FirstHit(Answer.YES, objects.pop() if len(objects) == 1 else None, None)


def _bounding_sphere(primitive: Primitive) -> tuple[Floats, float]:
    low, high = primitive.points.min(axis=0), primitive.points.max(axis=0)
    if isinstance(primitive, SpherePrimitive):
        return primitive.center, primitive.radius
    return 0.5 * (low + high), 0.5 * float(norm(high - low))
