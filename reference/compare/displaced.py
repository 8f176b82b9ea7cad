"""The lecture's algorithm as another renderer might follow it: every ray a little aside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from minirt.geometry import Geometry, Kind
from minirt.render import Tile, trace_pixels
from minirt.rules import SLIDES
from minirt.scene import Scene
from minirt.trace import Hits, nearest, nearest_two
from minirt.vectors import Bools, Floats, Index, Ints, column, cross, dot, norm, put, take, unit
from minirt.whitted import Points, Signature, Whitted
from reference.compare.surfaces import PerSurface
from reference.source import AlongRay, Declared, NormalOffset

#: 1/slope up to which one trace tells whether other surfaces lie within the error of the first.
_STEEP = 16.0

#: Of no object, or of no face, and not nothing either: what is met where the other renderer may
#: well see another one. No exact answer equals it.
_CONTESTED = -2
_CONTESTED_PATH = np.uint64(0xC0)

#: Two vectors that few rays or edges are parallel to.
_ASKEW = column((0.48, 0.6, 0.64)), column((0.8, -0.64, 0.0))


class Displaced(Whitted):
    """The lecture's algorithm with every ray moved sideways by some δ, in direction k of six.

    Secondary rays start as another renderer starts them. What is met where surfaces of several
    objects lie within the error of the first is no object's.

    Parameters
    ----------
    scene : Scene
    declared : Declared
    levers : PerSurface
    k : int
        0…5: the direction around each ray.
    step : float
        How many δ.
    """

    def __init__(
        self, scene: Scene, declared: Declared, levers: PerSurface, k: int, step: float
    ) -> None:
        super().__init__(scene, replace(SLIDES, refract=self.refracted_direction))
        self.declared, self.levers, self.k = declared, levers, k
        self.sample, self.step, self.tilt = step, step * declared.delta, step * declared.slope

    def tile(self, d: Floats, around: tuple[Floats, Floats], wanted: frozenset[str]) -> Tile:
        """The wanted quantities of the pixels whose rays should go along d (3, n).

        `around` is `perpendicular` of d.
        """
        self._aside = turned(around, self.k)
        if self.tilt:
            d = d + self.tilt * norm(d) * self._aside
        self._faces_contested = np.zeros(d.shape[1], dtype=np.bool_)
        tile = trace_pixels(self, d, wanted)
        tile["hit"] = tile["t"] < np.inf
        tile["triangle"] = np.where(self._faces_contested, _CONTESTED, tile["triangle"])
        return tile

    def refracted_direction(self, delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
        """ϱ (3, n) with the square of its cosine a rounding larger, for odd k smaller.

        Whoever takes the root of 1 − η²(1 − cos²), η = ν/ν_t, rounds twice near 1: by u/2·(1 + η²)
        in all, where a unit vector's error is 4·u or more. Where ϱ grazes the surface, that turns
        it by much more than anything else does, even from one side to the other of the same index.
        """
        exact = SLIDES.refract(delta, s, nu, nu_t)
        cosine = dot(exact, s)
        rounding = self.declared.angle / 8.0 * (1.0 + (nu / nu_t) ** 2)
        square = cosine**2 + (rounding if self.k % 2 == 0 else -rounding)
        moved = np.copysign(np.sqrt(np.maximum(square, 0.0)), cosine)
        bent: Floats = exact + (moved - cosine) * s
        return bent

    def primary_origin(self, d: Floats) -> Floats:
        """The observer, moved sideways."""
        moved: Floats = super().primary_origin(d) + self.step * self._aside
        return moved

    def primary_hits(self, P0: Floats, d: Floats) -> Hits:
        """The first hits that are not so near that the other renderer may overlook them."""
        hits, several = self._hits(P0, d, self.declared.near / abs(self.scene.screen.nu))
        self._faces_contested[several] = True
        return hits

    def secondary_start(self, points: Points, direction: Floats) -> tuple[Floats, float]:
        """Where the other renderer starts, moved sideways."""
        start = self.declared.start
        if isinstance(start, NormalOffset):
            origin, t0 = _off_surface(points, self._side(points, direction), start), 0.0
        elif isinstance(start, AlongRay):
            origin, t0 = points.M, start.length
        else:
            origin, t0 = super().secondary_start(points, direction)
        return origin + self.step * carried(points, direction, self.k), t0

    def _side(self, points: Points, direction: Floats) -> Floats:
        """Which side of a surface rays leave on, (n,), by its sign; on either when along it."""
        slope = dot(points.normal, direction)
        return np.where(slope == 0, 1.0 if self.k % 2 == 0 else -1.0, slope)

    def optical_normal(self, normal: Floats, hits: Hits) -> Floats:
        """Facets tilted by what their vertices' rounding turns them, spheres by the angle's."""
        tilt = self.declared.angle + _facet_tilt(hits, self.geometry, self.levers, self.declared)
        return unit(normal + self.sample * tilt * sideways(normal, self.k))

    def shadow(self, points: Points) -> Bools:
        """Shadow; facets that the light may pass on either side shade themselves, then do not.

        A facet exactly parallel to the light, as a wall along an axis is, is so for everybody.
        """
        dark = super().shadow(points)
        slope = np.abs(dot(points.normal, unit(self.to_light)))
        tilt = _facet_tilt(points.hits, self.geometry, self.levers, self.declared)
        return np.where((slope > 0) & (slope < tilt), self.k % 2 == 0, dark)

    def first_hits(self, P0: Floats, d: Floats, t0: float = 0.0) -> Hits:
        """The first hits; of no object, but with their t, where another may be met instead."""
        hits, several = self._hits(P0, d, t0)
        hits.object[several] = _CONTESTED
        return hits

    def color(
        self, P0: Floats, d: Floats, hits: Hits, generation: int = 0
    ) -> tuple[Floats, Signature]:
        """As the lecture's, with a signature of its own for what is contested."""
        result, signature = super().color(P0, d, hits, generation)
        signature[hits.object == _CONTESTED] = _CONTESTED_PATH
        return result, signature

    def _hits(self, P0: Floats, d: Floats, t0: float) -> tuple[Hits, Index]:
        """The first hits, and of which rays other faces of the same object may be met instead.

        Where another object may be, the hit is nobody's.
        """
        apart = 2.0 * _STEEP * self.step / norm(d)
        relative = 2.0 * (_STEEP * self.tilt + self.declared.grain)
        hits, next_t = nearest_two(self.geometry, self.rules, P0, d, t0, apart, relative)
        met = np.flatnonzero(hits.object >= 0)
        first = hits.take(met)
        gap = self._gap(take(P0, met), take(d, met), first)
        watched = first.t * (1.0 + relative) + apart[met]
        contested = np.flatnonzero(np.minimum(next_t[met], watched) <= first.t + gap)
        return hits, self._settle(P0, d, t0, hits, met[contested], gap[contested])

    def _settle(
        self, P0: Floats, d: Floats, t0: float, hits: Hits, rays: Index, gap: Floats
    ) -> Index:
        """What rays meet that may meet something else within the gap: see `_hits`."""

        def others(rays: Index, gap: Floats, face: Ints | None) -> Hits:
            t, known = hits.t[rays], (hits.object[rays], face)
            low, high = np.maximum(t - gap, t0), t + gap
            at, along = take(P0, rays), take(d, rays)
            return nearest(self.geometry, self.rules, at, along, low, high, other_than=known)

        other = others(rays, gap, hits.triangle[rays])
        some = np.flatnonzero(other.object >= 0)
        rays, gap, other = rays[some], gap[some], other.take(some)
        alike = other.object == hits.object[rays]
        alike[alike] = others(rays[alike], gap[alike], None).object < 0
        farther = np.flatnonzero(alike & (other.t > hits.t[rays]))
        hits.put(rays[farther], other.take(farther))
        hits.object[rays[~alike]] = _CONTESTED
        several: Index = rays[alike]
        return several

    def _gap(self, P0: Floats, d: Floats, hits: Hits) -> Floats:
        """How much of t (n,) may lie between two surfaces that the error can exchange."""
        t, length = hits.t, norm(d)
        normal = self.normals(self.rules.point_at(P0, d, t), hits)
        slope = np.maximum(np.abs(dot(normal, d / length)), 2.0**-20)
        gap: Floats = 2.0 * (self.step / length + self.tilt * t) / slope
        return gap + 2.0 * self.declared.grain * t


def perpendicular(d: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors (3, n) perpendicular to d (3, n) and to each other."""
    if d.strides[1] == 0 and d.shape[1] > 1:  # one vector that stands for all
        first, second = perpendicular(d[:, :1])
        return np.broadcast_to(first, d.shape), np.broadcast_to(second, d.shape)
    first = cross(d, _ASKEW[0])
    parallel = np.flatnonzero(dot(first, first) < 0.1 * dot(d, d))
    put(first, parallel, cross(take(d, parallel), _ASKEW[1]))
    first = unit(first)
    return first, unit(cross(d, first))


def sideways(d: Floats, k: int) -> Floats:
    """The k-th of six unit vectors (3, n) perpendicular to d (3, n): see `turned`."""
    return turned(perpendicular(d), k)


def turned(around: tuple[Floats, Floats], k: int) -> Floats:
    """The k-th of six unit vectors (3, n) in the plane of two that are perpendicular.

    The first three are a third of a turn apart, the others their opposites.
    """
    if k >= 3:
        return -turned(around, k - 3)
    first, second = around
    if k == 0:
        return first
    aside: Floats = -0.5 * first + (0.75**0.5 if k == 1 else -(0.75**0.5)) * second
    return aside


def carried(points: Points, direction: Floats, k: int) -> Floats:
    """`sideways` of rays that arrived at points, carried on to unit directions (3, n) from there.

    Mirrored with the ray where that goes back, turned with it where it goes on: the point is aside
    because its ray was, and what is added to that must not take it away.
    """
    delta = points.delta
    aside, along = sideways(delta, k), dot(delta, direction)
    back = np.where(dot(delta, points.normal) * dot(direction, points.normal) < 0, 1.0, -1.0)
    apart = 1.0 - back * along
    share = np.divide(
        back * dot(direction, aside), apart, where=apart > 2.0**-40, out=np.zeros_like(apart)
    )
    onward: Floats = aside + share * (delta - back * direction)
    return onward


def _facet_tilt(hits: Hits, geometry: Geometry, levers: PerSurface, declared: Declared) -> Floats:
    """The angle (n,) by which moving a facet's vertices can turn it; 0 on spheres."""
    flat = geometry.kind[hits.object] != Kind.SPHERE
    return np.where(flat, 2.0 * declared.vertex / levers.at(hits), 0.0)


def _off_surface(points: Points, side: Floats, start: NormalOffset) -> Floats:
    center = np.array(start.center).reshape(3, 1)
    there = np.abs(start.scale * (points.M - center)).max(axis=0)
    offset = start.factor * (1.0 + there) / start.scale
    started: Floats = points.M + np.copysign(offset, side) * points.normal
    return started
