"""The lecture's algorithm with displaced rays, as another renderer's errors might move them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from minirt.geometry import Kind
from minirt.hits import RayHits
from minirt.points import Branch, Points
from minirt.rays import Rays
from minirt.render import Tile
from minirt.rules import SLIDES
from minirt.scene import Scene
from minirt.vectors import Bools, Floats, column, cross, dot, norm, put, take, unit
from reference.compare.contested import CONTESTED, ContestedSearch
from reference.compare.paths import SignedPaths
from reference.compare.surfaces import PerSurface
from reference.source import AlongRay, Declared, NormalOffset

_CONTESTED_PATH = np.uint64(0xC0)

#: Two vectors to which few rays or edges are parallel.
_ASKEW = column((0.48, 0.6, 0.64)), column((0.8, -0.64, 0.0))


class Displaced(SignedPaths):
    """The lecture's algorithm with every ray moved sideways by some δ, in direction k of six.

    Secondary rays start as the other renderer starts them. A hit is contested, and belongs to no
    object, if surfaces of several objects lie within the error of the first.

    Parameters
    ----------
    scene : Scene
    declared : Declared
    levers : PerSurface
    k : int
        0…5: the direction around each ray.
    step : float
        The displacement in units of δ.
    """

    def __init__(
        self, scene: Scene, declared: Declared, levers: PerSurface, k: int, step: float
    ) -> None:
        super().__init__(scene, replace(SLIDES, refract=self.refracted_direction))
        self.declared, self.levers, self.k = declared, levers, k
        self.sample, self.step, self.tilt = step, step * declared.delta, step * declared.slope
        self.search = ContestedSearch(self.world, self.step, self.tilt, declared.grain)

    def tile(self, d: Floats, around: tuple[Floats, Floats], wanted: frozenset[str]) -> Tile:
        """The wanted quantities of the pixels whose rays should go along d (3, n).

        `around` is `perpendicular` of d.
        """
        aside = turned(around, self.k)
        if self.tilt:
            d = d + self.tilt * norm(d) * aside
        screen = self.scene.screen
        near = self.declared.near / abs(screen.nu)  # the other renderer may miss what is nearer
        rays = Rays.of(column(screen.P0) + self.step * aside, d, near)
        hits, several = self.search.first_hits(rays)
        tile = self.signed_tile(rays, hits, wanted)
        tile["hit"] = tile["t"] < np.inf
        tile["triangle"] = tile["triangle"].copy()
        tile["triangle"][several] = CONTESTED
        return tile

    def refracted_direction(self, delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
        """ϱ (3, n) with the square of its cosine larger by a rounding error; smaller for odd k.

        The square root of 1 − η²(1 − cos²), η = ν/ν_t, involves two roundings near 1: u/2·(1 + η²)
        together, while a unit vector's error is 4·u or more. If ϱ grazes the surface, this turns it
        by more than any other error, even to the other side of a surface with equal indices.
        """
        exact = SLIDES.refract(delta, s, nu, nu_t)
        cosine = dot(exact, s)
        rounding = self.declared.angle / 8.0 * (1.0 + (nu / nu_t) ** 2)
        square = cosine**2 + (rounding if self.k % 2 == 0 else -rounding)
        moved = np.copysign(np.sqrt(np.maximum(square, 0.0)), cosine)
        bent: Floats = exact + (moved - cosine) * s
        return bent

    def secondary_rays(self, points: Points, direction: Floats) -> Rays:
        """Secondary rays from where the other renderer starts them, displaced."""
        start = self.declared.start
        if isinstance(start, NormalOffset):
            origin, t0 = _off_surface(points, self._side(points, direction), start), 0.0
        elif isinstance(start, AlongRay):
            origin, t0 = points.M, start.length
        else:
            origin, t0 = points.M, self.epsilon
        return Rays.of(origin + self.step * carried(points, direction, self.k), direction, t0)

    def leave(self, points: Points, direction: Floats) -> Branch:
        """The secondary rays, with lengths measured from the points themselves."""
        branch = super().leave(points, direction)
        ahead = dot(branch.origin - points.M, direction)
        return replace(branch, length=branch.hits.t + ahead)

    def _side(self, points: Points, direction: Floats) -> Floats:
        """The side of a surface to which rays leave, (n,), by its sign; either side if along it."""
        slope = dot(points.normal, direction)
        return np.where(slope == 0, 1.0 if self.k % 2 == 0 else -1.0, slope)

    def points(self, rays: Rays, hits: RayHits) -> Points:
        """Points with s tilted: of facets by the error of their vertices, of all by the angle's."""
        points = super().points(rays, hits)
        tilt = self.declared.angle + self._facet_tilt(points.hits)
        s = unit(points.normal + self.sample * tilt * sideways(points.normal, self.k))
        return replace(points, s=s)

    def shadow(self, points: Points) -> Bools:
        """Shadow; facets that the light may pass on either side shade themselves for even k only.

        A facet exactly parallel to the light, such as a wall along an axis, is so for any renderer.
        """
        dark = super().shadow(points)
        slope = np.abs(dot(points.normal, unit(self.to_light)))
        tilt = self._facet_tilt(points.hits)
        return np.where((slope > 0) & (slope < tilt), self.k % 2 == 0, dark)

    def _facet_tilt(self, hits: RayHits) -> Floats:
        """The angle (n,) by which moving a facet's vertices can turn it; 0 on spheres."""
        flat = self.world.geometry.kind[hits.object] != Kind.SPHERE
        return np.where(flat, 2.0 * self.declared.vertex / self.levers.at(hits), 0.0)

    def first_hits(self, rays: Rays) -> RayHits:
        """The first hits; contested ones have no object, but keep their t."""
        hits, several = self.search.first_hits(rays)
        hits.object[several] = CONTESTED
        return hits

    def color(self, rays: Rays, hits: RayHits, generation: int = 0) -> Floats:
        """As the lecture's, with a signature of its own for contested hits."""
        result = super().color(rays, hits, generation)
        self.signature[hits.object == CONTESTED] = _CONTESTED_PATH
        return result


def perpendicular(d: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors (3, n) perpendicular to d (3, n) and to each other."""
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
    """`sideways` of the rays that arrived at points, for unit directions (3, n) that leave them.

    It is mirrored with a reflected ray and turned with a refracted one: the point is displaced
    because its ray was, and the next displacement must add to that and not cancel it.
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


def _off_surface(points: Points, side: Floats, start: NormalOffset) -> Floats:
    center = np.array(start.center).reshape(3, 1)
    there = np.abs(start.scale * (points.M - center)).max(axis=0)
    offset = start.factor * (1.0 + there) / start.scale
    started: Floats = points.M + np.copysign(offset, side) * points.normal
    return started
