"""Whether POV-Ray's list of media gives each ray of a scene the indices of the surfaces it hits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from converters.povray.media import Body
from minirt.points import Branch, Points
from minirt.rules import SLIDES
from minirt.scene import Scene
from minirt.shading import in_total_reflection
from minirt.vectors import Bools, Floats, Index
from minirt.whitted import Whitted

Lists = NDArray[np.intp]

#: Quotients of POV-Ray's float32 indices err by less; media closer than that are one to it.
_SAME = 2.0**-22
#: Rays followed at a time; bounds the memory.
_BLOCK = 2**16


def media_fault(scene: Scene, bodies: tuple[Body, ...]) -> str | None:
    """Why POV-Ray's indices are not the slides' somewhere in this picture; None where they are.

    Every ray of every pixel is followed as minirt follows it, with the list that POV-Ray would
    keep. A body that is hit and is not in the list is entered and appended; one that is in the
    list is left and removed. The quotient of indices is that of the last body and the hit one, or
    of the hit one and the body that is last after it. If the hit body is in the list but not
    last, POV-Ray takes 1.
    """
    if not bodies:
        return None
    follower = _Follower(scene, bodies)
    screen = scene.screen
    for start in range(0, screen.nx * screen.ny, _BLOCK):
        pixels = np.arange(start, min(start + _BLOCK, screen.nx * screen.ny))
        rays = follower.whitted.rays_of(pixels)
        points = follower.whitted.points(rays, follower.whitted.first_hits(rays))
        fault = follower.follow(points, np.full((len(points.rays), follower.longest), -1), 0)
        if fault:
            return fault
    return None


class _Follower:
    def __init__(self, scene: Scene, bodies: tuple[Body, ...]) -> None:
        self.whitted, self.scene = Whitted(scene), scene
        self.longest = scene.max_depth + 2
        self.index = np.array([body.index for body in bodies] + [1.0])  # −1, no body: outside all
        self.body = np.full(len(scene.objects), -1)
        for number, body in enumerate(bodies):
            self.body[list(body.objects)] = number

    def follow(self, points: Points, lists: Lists, generation: int) -> str | None:
        """Check points, reached by rays with these lists (n, k), and all points behind them."""
        if generation >= self.scene.max_depth:
            return None
        body = self.body[points.hits.object]
        clear = np.flatnonzero(body >= 0)
        some = points.take(clear)
        after, ratio = self._cross(lists[clear], body[clear])
        if not np.allclose(ratio, _expected(some), rtol=_SAME, atol=0):
            return "bodies for which POV-Ray's list of media and the surfaces themselves disagree"
        if (np.abs(ratio - 1) < _SAME).any():
            return "a body of index 1, whose refracted rays POV-Ray does not count"
        through = self.whitted.refracted(some)
        total = np.isnan(through.direction[0])
        passing = np.flatnonzero(~total)
        fault = self._next_points(through.take(passing), after[passing], generation)
        tir = np.zeros(len(body), dtype=np.bool_)
        tir[clear] = total
        shiny = _mirrored(points, tir)
        back = self.whitted.reflected(points.take(shiny))
        return fault or self._next_points(back, lists[shiny], generation)

    def _next_points(self, rays: Branch, lists: Lists, generation: int) -> str | None:
        points = self.whitted.points(rays.rays, rays.hits)
        return self.follow(points, lists[points.rays], generation + 1) if len(points.rays) else None

    def _cross(self, lists: Lists, body: Index) -> tuple[Lists, Floats]:
        """POV-Ray's lists behind the surface, and its quotients of indices."""
        known = lists == body[:, None]
        inside, last = known.any(axis=1), _last(lists)
        after = lists.copy()
        rows = np.flatnonzero(~inside)
        after[rows, (lists[rows] >= 0).sum(axis=1)] = body[rows]
        rows = np.flatnonzero(inside)
        order = np.argsort(known[rows], axis=1, kind="stable")  # the known one goes to the end
        after[rows] = np.take_along_axis(np.where(known, -1, lists)[rows], order, axis=1)
        leaving = self.index[body] / self.index[_last(after)]
        ratio = np.where(inside, leaving, self.index[last] / self.index[body])
        return after, np.where(inside & (last != body), 1.0, ratio)


def _expected(points: Points) -> Floats:
    """ν/ν_t by the surfaces alone."""
    leaving = (points.delta * points.normal).sum(axis=0) > 0
    nu, nu_t = SLIDES.indices(points.material.ior, leaving)
    ratio: Floats = nu / nu_t
    return ratio


def _mirrored(points: Points, tir: Bools) -> Index:
    k_r, _ = in_total_reflection(points.material.reflectance, points.material.transmittance, tir)
    return np.flatnonzero(k_r > 0)


def _last(lists: Lists) -> Index:
    """The last body of each list; −1 of an empty one."""
    size = (lists >= 0).sum(axis=1)
    rows = np.arange(len(lists))
    return np.asarray(np.where(size > 0, lists[rows, size - 1], -1))
