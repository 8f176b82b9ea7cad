"""What RT meets beside the first hit: the next one, and the first of another surface."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from minirt.geometry import Kind
from minirt.hits import FirstHits, RayHits
from minirt.rays import Rays
from minirt.rules import Rules
from minirt.trace import RT, World
from minirt.vectors import Floats, Index, Ints

#: Objects (n,), and a face of each; all of its faces for None.
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
        How far the next is looked for: up to t·(1 + relative) + fixed.

    Returns
    -------
    first : RayHits
    t : (n,) float64
        Of the next hit of any other primitive; if that is farther, anything that is farther too.
        A primitive may count as its own next.
    """
    both = _FirstTwo(rays, world.rules, fixed, relative)
    return RT(world, rays, both), both.next_t


def nearest_other(world: World, rays: Rays, passed_over: Faces) -> RayHits:
    """The first hit of each ray that is not on a face to be passed over.

    Spheres and polygons are passed over as a whole.
    """
    return RT(world, rays, _Others(rays, world.rules, passed_over))


class _FirstTwo(FirstHits):
    """The first hit of each ray, and the t of the next: see `nearest_two`."""

    def __init__(self, rays: Rays, rules: Rules, fixed: Floats | float, relative: float) -> None:
        super().__init__(rays, rules)
        self.next_t = np.full(rays.count, np.inf)
        self._fixed, self._relative = np.broadcast_to(fixed, (rays.count,)), relative

    def keep_one(self, rays: Index, found: RayHits) -> None:
        """Note the worse one of each ray's best and of what is found."""
        before = self.hits.take(rays)
        super().keep_one(rays, found)
        closer = self.hits.t[rays] != before.t
        closer |= self.hits.object[rays] != before.object
        closer |= self.hits.triangle[rays] != before.triangle
        worse = np.where(closer, before.t, found.t)
        self.next_t[rays] = np.minimum(self.next_t[rays], worse)

    def latest(self, rays: Index, t: Floats) -> Floats:
        """As far as the next hit is looked for."""
        latest: Floats = t * (1.0 + self._relative) + self._fixed[rays]
        return latest


class _Others(FirstHits):
    """The first hit of each ray that is not passed over: see `nearest_other`."""

    def __init__(self, rays: Rays, rules: Rules, passed_over: Faces) -> None:
        super().__init__(rays, rules)
        self._passed_over = passed_over

    def keep(self, kind: Kind, rays: Index, found: RayHits) -> None:
        """Leave out what is passed over."""
        object_, face = self._passed_over
        wanted = found.object != object_[rays]
        if face is not None and kind == Kind.TRIANGLES:
            wanted |= found.triangle != face[rays]
        some = np.flatnonzero(wanted)
        super().keep(kind, rays[some], found.take(some))
