"""S4, S6: the answers of RT, and which of a ray's hits is kept as its answer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from minirt.geometry import Kind
from minirt.rays import Rays
from minirt.rules import Rules
from minirt.vectors import Floats, Index, Ints

#: A t_max below every t: of a ray whose question is answered.
_ANSWERED = -1e300


@dataclass(frozen=True, eq=False)
class RayHits:
    """Answers of RT, one a ray.

    Attributes
    ----------
    t : (n,) float64
        +inf for ∅.
    object, triangle : (n,) int32
        Number of the object, and of the face within it; −1 for ∅.
    beta, gamma : (n,) float64
        S9's weights; NaN on spheres and for ∅.
    """

    t: Floats
    object: Ints
    triangle: Ints
    beta: Floats
    gamma: Floats

    @classmethod
    def none(cls, shape: tuple[int, ...]) -> RayHits:
        """No hit."""
        return cls(
            np.full(shape, np.inf),
            np.full(shape, -1, dtype=np.int32),
            np.full(shape, -1, dtype=np.int32),
            np.full(shape, np.nan),
            np.full(shape, np.nan),
        )

    def take(self, index: Index) -> RayHits:
        """Some of the answers."""
        return RayHits(*(value.take(index) for value in vars(self).values()))

    def put(self, index: Index, other: RayHits) -> None:
        """Overwrite some of the answers."""
        for name, value in vars(self).items():
            value[index] = getattr(other, name)


class FirstHits:
    """The first hit of each ray among those that were found so far.

    This is what RT asks to be kept. A harness that wants to know more of the hits derives from this
    class, and has RT fill that instead.

    Parameters
    ----------
    rays : Rays
    rules : Rules
        S4's `closer` decides.

    Attributes
    ----------
    hits : RayHits
    t_max : (n,) float64
        The largest t that can still matter for each ray. Only culling looks at it.
    """

    def __init__(self, rays: Rays, rules: Rules) -> None:
        self.hits = RayHits.none((rays.count,))
        self.t_max = np.broadcast_to(rays.t1, (rays.count,)).copy()
        self._closer = rules.closer
        self._first = np.empty(rays.count, dtype=np.intp)

    def keep(self, kind: Kind, rays: Index, found: RayHits) -> None:
        """Take over what is better of hits (k,) of rays (k,), one of which may come repeatedly.

        Hits of one ray are looked at in their order.
        """
        counts = np.isfinite(found.t)
        if not counts.all():
            at = np.flatnonzero(counts)
            rays, found = rays[at], found.take(at)
        while (rays[1:] <= rays[:-1]).any():  # the first hit of each ray, then the others
            each = np.arange(len(rays))
            self._first[rays[::-1]] = each[::-1]
            mine = self._first[rays] == each
            one, others = np.flatnonzero(mine), np.flatnonzero(~mine)
            self.keep_one(rays[one], found.take(one))
            rays, found = rays[others], found.take(others)
        self.keep_one(rays, found)

    def keep_one(self, rays: Index, found: RayHits) -> None:
        """`keep` for one hit a ray."""
        hits = self.hits
        closer = self._closer(
            found.t, found.object, found.triangle,
            hits.t[rays], hits.object[rays], hits.triangle[rays],
        )  # fmt: skip
        if not closer.all():
            better = np.flatnonzero(closer)
            rays, found = rays[better], found.take(better)
        hits.put(rays, found)
        self.t_max[rays] = self.latest(rays, found.t)

    def latest(self, rays: Index, t: Floats) -> Floats:
        """`t_max` (k,) of rays whose best hits are at t (k,)."""
        return t


class AnyHits(FirstHits):
    """Some hit of each ray: a ray that has one is not tested any more."""

    def latest(self, rays: Index, t: Floats) -> Floats:
        """Below every t."""
        return np.full(len(rays), _ANSWERED)
