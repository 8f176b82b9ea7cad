"""Hits other than the first one: the next hit, and the first hit of another surface."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from minirt.geometry import Kind
from minirt.hits import FirstHits, RayHits
from minirt.rays import Rays
from minirt.rules import Rules
from minirt.trace import RT, World
from minirt.vectors import Floats, Index, Ints

#: Objects (n,), and one face of each; None for all of its faces.
Faces: TypeAlias = tuple[Ints, Ints | None]


def nearest_two(
    world: World, rays: Rays, fixed: Floats | float, relative: float
) -> tuple[RayHits, Floats]:
    """The first hit of each ray, and the t of the next.

    Parameters
    ----------
    world : World
    rays : Rays
    fixed, relative : (n,) float64 or float, float
        The next hit is searched for up to t·(1 + relative) + fixed.

    Returns
    -------
    first : RayHits
    t : (n,) float64
        Of the next hit of any other primitive; if that is farther, any larger number.
        A primitive may count as its own next one.
    """
    both = _FirstTwo(rays, world.rules, fixed, relative)
    return RT(world, rays, both), both.next_t


def nearest_other(world: World, rays: Rays, excluded: Faces) -> RayHits:
    """The first hit of each ray that is not on the excluded face.

    Spheres and polygons are excluded as a whole.
    """
    return RT(world, rays, _Others(rays, world.rules, excluded))


class _FirstTwo(FirstHits):
    """The first hit of each ray, and the t of the next: see `nearest_two`."""

    def __init__(self, rays: Rays, rules: Rules, fixed: Floats | float, relative: float) -> None:
        super().__init__(rays, rules)
        self.next_t = np.full(rays.count, np.inf)
        self._fixed, self._relative = np.broadcast_to(fixed, (rays.count,)), relative

    def keep_one(self, rays: Index, found: RayHits) -> None:
        """Record the farther one of each ray's best hit and the new one."""
        before = self.hits.take(rays)
        super().keep_one(rays, found)
        closer = self.hits.t[rays] != before.t
        closer |= self.hits.object[rays] != before.object
        closer |= self.hits.triangle[rays] != before.triangle
        worse = np.where(closer, before.t, found.t)
        self.next_t[rays] = np.minimum(self.next_t[rays], worse)

    def latest(self, rays: Index, t: Floats) -> Floats:
        """The largest t up to which the next hit is searched for."""
        latest: Floats = t * (1.0 + self._relative) + self._fixed[rays]
        return latest


class _Others(FirstHits):
    """The first hit of each ray that is not excluded: see `nearest_other`."""

    def __init__(self, rays: Rays, rules: Rules, excluded: Faces) -> None:
        super().__init__(rays, rules)
        self._excluded = excluded

    def keep(self, kind: Kind, rays: Index, found: RayHits) -> None:
        """Drop excluded hits."""
        object_, face = self._excluded
        wanted = found.object != object_[rays]
        if face is not None and kind == Kind.TRIANGLES:
            wanted |= found.triangle != face[rays]
        some = np.flatnonzero(wanted)
        super().keep(kind, rays[some], found.take(some))
