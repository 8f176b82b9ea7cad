"""Contested hits: where surfaces lie so close together that an error can change which is first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from minirt.hits import RayHits
from minirt.rays import Rays
from minirt.trace import World, normals
from minirt.vectors import Floats, Index, Ints, dot, norm, take
from reference.compare.other_hits import nearest_other, nearest_two

#: The object, or the face, of a contested hit: the other renderer may see another one there. No
#: exact answer equals it.
CONTESTED = -2
#: 1/slope up to which one trace shows whether other surfaces lie within the error of the first.
_STEEP = 16.0


@dataclass(frozen=True)
class ContestedSearch:
    """First hits of rays, and which of them are contested under an error.

    Attributes
    ----------
    world : World
    step : float
        How far a ray may be displaced, in scene units.
    tilt : float
        By how much more per distance from its origin.
    grain : float
        Further relative error of t.
    """

    world: World
    step: float
    tilt: float
    grain: float

    def first_hits(self, rays: Rays) -> tuple[RayHits, Index]:
        """The first hits, and the rays that may hit other faces of the same object instead.

        If another object may be hit instead, the hit is contested.
        """
        apart = np.broadcast_to(2.0 * _STEEP * self.step / norm(rays.d), (rays.count,))
        relative = 2.0 * (_STEEP * self.tilt + self.grain)
        hits, next_t = nearest_two(self.world, rays, apart, relative)
        met = np.flatnonzero(hits.object >= 0)
        first = hits.take(met)
        gap = self._gap(take(rays.P0, met), take(rays.d, met), first)
        watched = first.t * (1.0 + relative) + apart[met]
        contested = np.flatnonzero(np.minimum(next_t[met], watched) <= first.t + gap)
        return hits, self._settle(rays, hits, met[contested], gap[contested])

    def _settle(self, cast: Rays, hits: RayHits, rays: Index, gap: Floats) -> Index:
        """Settle the hits of rays that may hit something else within the gap: see `first_hits`."""

        def others(rays: Index, gap: Floats, face: Ints | None) -> RayHits:
            t, known = hits.t[rays], (hits.object[rays], face)
            low, high = np.maximum(t - gap, cast.interval(rays)[0]), t + gap
            beside = Rays.of(take(cast.P0, rays), take(cast.d, rays), low, high)
            return nearest_other(self.world, beside, known)

        other = others(rays, gap, hits.triangle[rays])
        some = np.flatnonzero(other.object >= 0)
        rays, gap, other = rays[some], gap[some], other.take(some)
        alike = other.object == hits.object[rays]
        alike[alike] = others(rays[alike], gap[alike], None).object < 0
        farther = np.flatnonzero(alike & (other.t > hits.t[rays]))
        hits.put(rays[farther], other.take(farther))
        hits.object[rays[~alike]] = CONTESTED
        several: Index = rays[alike]
        return several

    def _gap(self, P0: Floats, d: Floats, hits: RayHits) -> Floats:
        """The largest difference of t (n,) of two surfaces whose order the error can change."""
        t, length = hits.t, norm(d)
        normal = normals(self.world, self.world.rules.point_at(P0, d, t), hits)
        slope = np.maximum(np.abs(dot(normal, d / length)), 2.0**-20)
        gap: Floats = 2.0 * (self.step / length + self.tilt * t) / slope
        return gap + 2.0 * self.grain * t
