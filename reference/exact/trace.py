"""RT for rays whose numbers are balls: what is met first, as far as it can be told.

Which primitives a ray may meet is found in float64, with no tree: each primitive's bounding
sphere is measured against each ray, with room for the errors of both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from minirt.scene import Scene
from minirt.vectors import Floats, dot, norm
from reference.exact.balls import Ball, middle, radius
from reference.exact.primitives import Primitive, SpherePrimitive, primitives
from reference.exact.shapes import Answer, Meeting, Ray

#: Ray–primitive pairs measured in one pass.
_PAIRS = 2**20
#: Room around every bounding sphere, as a share of the largest coordinate: the difference of two
#: squares in float64 can hide some 2⁻²⁵ of it.
_ROOM = 2.0**-20
#: A ray is lost when its balls are wider than this share of the same: the room would not hold it.
_LOST = 2.0**-24


class First(NamedTuple):
    """What a ray meets first.

    Attributes
    ----------
    hit : Answer
    object, face : int or None
        −1 for nothing; None: open.
    t : Ball or None
    primitive : Primitive or None
        The one that is met, where it is certain which; else None.
    """

    hit: Answer
    object: int | None
    face: int | None
    t: Ball | None = None
    primitive: Primitive | None = None


_NOTHING = First(Answer.NO, -1, -1)
_OPEN = First(Answer.OPEN, None, None)


class Tracer:
    """All primitives of a scene, to be met by rays."""

    def __init__(self, scene: Scene) -> None:
        self._primitives = list(primitives(scene))
        spheres = [_bounding_sphere(primitive) for primitive in self._primitives]
        self._center = np.array([c for c, _ in spheres]).reshape(-1, 3).T
        self._radius = np.array([r for _, r in spheres])
        box = np.zeros((2, 3)) if scene.bounds is None else scene.bounds
        self._reach = float(max(np.abs(scene.screen.P0).max(), np.abs(box).max())) + scene.extent

    def first(self, rays: Sequence[Ray]) -> list[First]:
        """RT of each ray. Source: S4, S6."""
        return [self._first(ray, near) for ray, near in self._candidates(rays)]

    def occluded(self, rays: Sequence[Ray]) -> list[Answer]:
        """Whether each ray meets anything. Source: S12."""
        return [self._occluded(ray, near) for ray, near in self._candidates(rays)]

    def _first(self, ray: Ray, near: list[tuple[float, int]] | None) -> First:
        if near is None:
            return _OPEN
        possible: list[tuple[Primitive, Meeting]] = []
        nearest: Ball | None = None
        for entry, number in near:
            if nearest is not None and nearest < entry:
                break
            primitive = self._primitives[number]
            meeting = primitive.meet(ray)
            if meeting.answer is Answer.NO or (nearest is not None and meeting.t > nearest):
                continue
            possible.append((primitive, meeting))
            if meeting.answer is Answer.YES and (nearest is None or meeting.t < nearest):
                nearest = meeting.t
        return _first_of(possible, nearest)

    def _occluded(self, ray: Ray, near: list[tuple[float, int]] | None) -> Answer:
        if near is None:
            return Answer.OPEN
        answers = set()
        for _, number in near:
            answers.add(self._primitives[number].meet(ray).answer)
            if Answer.YES in answers:
                return Answer.YES
        return Answer.OPEN if Answer.OPEN in answers else Answer.NO

    def _candidates(
        self, rays: Sequence[Ray]
    ) -> Iterator[tuple[Ray, list[tuple[float, int]] | None]]:
        """Each ray with the primitives it may meet, by the least t at which it may meet them.

        None in place of the primitives for a ray that is not known well enough to be placed.
        """
        size = max(1, _PAIRS // max(1, len(self._primitives)))
        for start in range(0, len(rays), size):
            chunk = rays[start : start + size]
            P0 = np.array([[middle(x) for x in ray.P0] for ray in chunk]).T
            d = np.array([[middle(x) for x in ray.d] for ray in chunk]).T
            for ray, near in zip(chunk, self._near(P0, d), strict=True):
                yield ray, near if self._placed(ray) else None

    def _placed(self, ray: Ray) -> bool:
        """Whether a ray's balls are small enough for the room; d's turn it about its origin."""
        turn = max(map(radius, ray.d)) / max(abs(middle(x)) for x in ray.d)
        return bool(turn * self._reach + max(map(radius, ray.P0)) < _LOST * self._reach)

    def _near(self, P0: Floats, d: Floats) -> list[list[tuple[float, int]]]:
        if not self._primitives:
            return [[] for _ in range(P0.shape[1])]
        length = norm(d)
        ahead = ((d / length).T @ self._center) - (dot(P0, d) / length)[:, None]
        apart = dot(self._center, self._center) - 2.0 * (P0.T @ self._center) + dot(P0, P0)[:, None]
        bound = self._radius + _ROOM * self._reach
        meets = (apart - ahead * ahead <= bound * bound) & (ahead >= -bound)
        found: list[list[tuple[float, int]]] = [[] for _ in range(P0.shape[1])]
        for ray, number in zip(*(axis.tolist() for axis in np.nonzero(meets)), strict=True):
            entry = (ahead[ray, number] - bound[number]) / length[ray]
            found[ray].append((float(entry), number))
        return [sorted(near) for near in found]


def _first_of(possible: list[tuple[Primitive, Meeting]], nearest: Ball | None) -> First:
    """The answer, from the meetings that may come first and the t of one that surely counts."""
    if nearest is None:
        return _OPEN if possible else _NOTHING
    rivals = [(p, m) for p, m in possible if not m.t > nearest]
    if len(rivals) == 1:
        primitive, meeting = rivals[0]
        return First(Answer.YES, primitive.object, meeting.face, meeting.t, primitive)
    objects = {primitive.object for primitive, _ in rivals}
    return First(Answer.YES, objects.pop() if len(objects) == 1 else None, None)


def _bounding_sphere(primitive: Primitive) -> tuple[Floats, float]:
    low, high = primitive.points.min(axis=0), primitive.points.max(axis=0)
    if isinstance(primitive, SpherePrimitive):
        return primitive.center, primitive.radius
    return 0.5 * (low + high), 0.5 * float(norm(high - low))
