"""S4, S7, S12–S16 along a ray: what is at the hit, and the rays that leave from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from minirt.errors import InputError
from minirt.geometry import Geometry, Kind
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene
from minirt.shading import Surfaces, in_total_reflection, object_materials
from minirt.trace import Hits, nearest, occluded
from minirt.vectors import Bools, Floats, Index, column, dot, norm, put, take

Signature = NDArray[np.uint64]
_PRIME = np.uint64(1099511628211)  # multiplier of the 64-bit FNV hash
_SALT = np.uint64(0x9E3779B9)  # so that a zero changes the hash too


@dataclass(frozen=True, eq=False)
class Points:
    """Surface points that rays have hit.

    Attributes
    ----------
    rays : (n,) intp
        Which of the rays they belong to.
    M, delta : (3, n) float64
        The points, and the unit directions of the rays that arrived.
    normal, s : (3, n) float64
        Unit geometric normal on the outside, and the one that light is reflected by.
    hits : Hits
    material : Surfaces
    """

    rays: Index
    M: Floats
    delta: Floats
    normal: Floats
    s: Floats
    hits: Hits
    material: Surfaces

    def take(self, index: Index) -> Points:
        """Some of the points."""
        return Points(
            self.rays[index],
            take(self.M, index),
            take(self.delta, index),
            take(self.normal, index),
            take(self.s, index),
            self.hits.take(index),
            self.material.take(index),
        )


@dataclass(frozen=True, eq=False)
class Branch:
    """Rays that leave from points: origin and unit direction (3, n), and what they meet.

    `length` is the distance from the point itself to what is met, wherever the ray was started.
    """

    origin: Floats
    direction: Floats
    hits: Hits
    length: Floats

    def take(self, index: Index) -> Branch:
        """Some of the rays."""
        return Branch(
            take(self.origin, index),
            take(self.direction, index),
            self.hits.take(index),
            self.length[index],
        )


@dataclass(frozen=True, eq=False)
class SecondaryRays:
    """Secondary rays of points that have been traced already; None where it has not.

    Attributes
    ----------
    dark : (n,) bool
        Whether each point is in shadow.
    reflected : Branch
        Of every point.
    refracted : Branch
        Of the points whose material has an index, in their order.
    """

    dark: Bools | None = None
    reflected: Branch | None = None
    refracted: Branch | None = None


class Whitted:
    """The lecture's algorithm on one scene, under given rules.

    How rays leave (`primary_origin`, `secondary_start`), what they meet first (`primary_hits`,
    `first_hits`) and which normal light obeys (`optical_normal`) are methods of their own, so that
    a harness can ask what would change if another renderer did them a little differently.

    Parameters
    ----------
    scene : Scene
    rules : Rules

    Raises
    ------
    InputError
        Anything else in the place of the two.
    """

    def __init__(self, scene: Scene, rules: Rules = SLIDES) -> None:
        self.scene, self.rules = checked_scene(scene), checked_rules(rules)
        self.geometry = Geometry.of(scene)
        self.materials = object_materials(scene)
        self.epsilon = rules.start_of_secondary(scene.epsilon)
        self.to_light = rules.to_light(column(scene.light_direction))

    def primary_origin(self, d: Floats) -> Floats:
        """Origins (3, n) of the primary rays along d (3, n): the observer."""
        return np.broadcast_to(column(self.scene.screen.P0), d.shape)

    def secondary_start(self, points: Points, direction: Floats) -> tuple[Floats, float]:
        """Origins (3, n) and t0 of rays that leave points along unit directions (3, n).

        Source: S12, S14, S16.
        """
        return points.M, self.epsilon

    def optical_normal(self, normal: Floats, hits: Hits) -> Floats:
        """The unit normal (3, n) that light is reflected and refracted by: the geometric one."""
        return normal

    def primary_hits(self, P0: Floats, d: Floats) -> Hits:
        """What the observer's rays (3, n) meet first. Source: S4."""
        return self.first_hits(P0, d)

    def first_hits(self, P0: Floats, d: Floats, t0: float = 0.0) -> Hits:
        """RT(P0, d, t0, ∞) for rays (3, n)."""
        return nearest(self.geometry, self.rules, P0, d, t0)

    def points(self, P0: Floats, d: Floats, hits: Hits) -> Points:
        """The surface points of those rays (3, n) that hit something. Source: S4."""
        rays = np.flatnonzero(hits.object >= 0)
        hits = hits.take(rays)
        d = take(d, rays)
        M = self.rules.point_at(take(P0, rays), d, hits.t)
        normal = self.normals(M, hits)
        s = self.optical_normal(normal, hits)
        return Points(rays, M, d / norm(d), normal, s, hits, self.materials.take(hits.object))

    def normals(self, M: Floats, hits: Hits) -> Floats:
        """The unit geometric normals (3, n) on the outside of what is hit at M (3, n)."""
        geometry = self.geometry
        normal = np.full_like(M, np.nan)
        kind, first = geometry.kind[hits.object], geometry.first[hits.object]
        on = np.flatnonzero(kind == Kind.SPHERE)
        centers = take(geometry.spheres.center, first[on])
        put(normal, on, self.rules.sphere_normal(take(M, on), centers))
        on = np.flatnonzero(kind == Kind.TRIANGLES)
        which = first[on] + hits.triangle[on]
        put(normal, on, self.rules.face_normal(take(geometry.triangles.N, which)))
        for fans in geometry.fans:
            on = np.flatnonzero(kind == Kind.POLYGON)
            on = on[fans.place[first[on]] >= 0]
            put(normal, on, self.rules.face_normal(take(fans.plane, fans.place[first[on]])))
        return normal

    def shadow(self, points: Points) -> Bools:
        """Whether each point is in shadow: RT(M, −l, ε, ∞) ≠ ∅. Source: S12."""
        direction = np.broadcast_to(self.to_light, points.M.shape)
        origin, t0 = self.secondary_start(points, direction)
        return occluded(self.geometry, self.rules, origin, direction, t0)

    def reflected(self, points: Points) -> Branch:
        """ρ and what RT(P, ρ, ε, ∞) meets. Source: S14."""
        s = self.rules.toward_viewer(points.s, points.delta)
        return self._leave(points, self.rules.reflect(points.delta, s))

    def refracted(self, points: Points) -> Branch:
        """ϱ and what RT(P, ϱ, ε, ∞) meets, of points whose material has an index. Source: S16.

        The direction is NaN, and nothing is met, at total internal reflection (E2).
        """
        leaving = dot(points.delta, points.s) > 0
        nu, nu_t = self.rules.indices(points.material.ior, leaving)
        direction = self.rules.refract(points.delta, points.s, nu, nu_t)
        passing = np.flatnonzero(~np.isnan(direction[0]))
        some = self._leave(points.take(passing), take(direction, passing))
        hits, length = Hits.none(leaving.shape), np.full(leaving.shape, np.inf)
        hits.put(passing, some.hits)
        length[passing] = some.length
        origin = points.M.copy()
        put(origin, passing, some.origin)
        return Branch(origin, direction, hits, length)

    def _leave(self, points: Points, direction: Floats) -> Branch:
        origin, t0 = self.secondary_start(points, direction)
        hits = self.first_hits(origin, direction, t0)
        ahead = dot(origin - points.M, direction) if origin is not points.M else 0.0
        return Branch(origin, direction, hits, hits.t + ahead)

    def color(
        self, P0: Floats, d: Floats, hits: Hits, generation: int = 0
    ) -> tuple[Floats, Signature]:
        """rayColor: linear RGB (3, n) of rays, and a hash of every discrete answer on the way.

        Two rays of one signature met the same faces, in shadow and light alike, along their whole
        tree of reflected and refracted rays. Source: S7.
        """
        return self.color_of(self.points(P0, d, hits), P0.shape[1], generation)

    def color_of(
        self, points: Points, n: int, generation: int = 0, traced: SecondaryRays = SecondaryRays()
    ) -> tuple[Floats, Signature]:
        """As `color`, for n rays of which some have hit points; `traced` saves tracing again."""
        result = np.broadcast_to(column(self.scene.background), (3, n)).copy()
        signature = np.full(n, generation, dtype=np.uint64)
        if len(points.rays):
            color, path = self._point_color(points, generation, traced)
            put(result, points.rays, color)
            signature[points.rays] = path
        return result, signature

    def _point_color(
        self, points: Points, generation: int, traced: SecondaryRays
    ) -> tuple[Floats, Signature]:
        dark = self.shadow(points) if traced.dark is None else traced.dark
        path = _mix(points.hits.object, points.hits.triangle, dark)
        material = points.material
        transparent = np.flatnonzero(material.transmittance > 0)
        through = self._refracted_of(points, transparent, traced)
        total = np.zeros(len(points.rays), dtype=np.bool_)
        total[transparent] = np.isnan(through.direction[0])
        k_r, k_t = in_total_reflection(material.reflectance, material.transmittance, total)
        mirrored, transmitted = np.zeros_like(points.M), np.zeros_like(points.M)
        if generation < self.scene.max_depth:
            shiny, passing = np.flatnonzero(k_r > 0), np.flatnonzero(~total[transparent])
            if len(shiny):
                back = self._reflected_of(points, shiny, traced)
                color, far = self._branch_color(back, generation)
                put(mirrored, shiny, color)
                path[shiny] = _mix(path[shiny], far)
            if len(passing):
                on = transparent[passing]
                color, far = self._branch_color(through.take(passing), generation)
                put(transmitted, on, color)
                path[on] = _mix(path[on], far)
        local = self.local_color(points, dark)
        return self.rules.combine(local, mirrored, transmitted, k_r, k_t), _mix(path, total)

    def _reflected_of(self, points: Points, some: Index, traced: SecondaryRays) -> Branch:
        if traced.reflected is None:
            return self.reflected(points.take(some))
        return traced.reflected.take(some)

    def _refracted_of(self, points: Points, some: Index, traced: SecondaryRays) -> Branch:
        if traced.refracted is None:
            return self.refracted(points.take(some))
        return traced.refracted.take(np.searchsorted(refractive(points), some))

    def _branch_color(self, branch: Branch, generation: int) -> tuple[Floats, Signature]:
        return self.color(branch.origin, branch.direction, branch.hits, generation + 1)

    def local_color(self, points: Points, dark: Bools) -> Floats:
        """The colour of the points themselves, (3, n), lit or in shadow. Source: S13."""
        s = self.rules.toward_viewer(points.s, points.delta)
        light = np.broadcast_to(self.to_light, s.shape)
        mirror = self.rules.reflect(-light, s)
        lit = self.rules.illuminate(
            points.material, column(self.scene.light_color), light, s, points.delta, mirror
        )
        return np.where(
            dark, self.rules.shadow_color(points.material, self.scene.shadow_color), lit
        )


def refractive(points: Points) -> Index:
    """Numbers of the points whose material has an index."""
    return np.flatnonzero(~np.isnan(points.material.ior))


def _mix(first: NDArray[Any], *others: NDArray[Any]) -> Signature:
    result: Signature = _words(first)
    for value in others:
        result = (result ^ (_words(value) + _SALT)) * _PRIME
    return result


def _words(values: NDArray[Any]) -> Signature:
    return values.astype(np.uint64) if values.dtype != np.uint64 else values


def checked_scene(scene: object) -> Scene:
    """The scene itself, if it is one.

    Raises
    ------
    InputError
        A path, a dict, or anything else that `load_scene` has not made.
    """
    if not isinstance(scene, Scene):
        raise InputError(
            "not a scene: call minirt.load_scene first",
            where="scene",
            got=type(scene).__name__,
            expected="a minirt.Scene",
        )
    return scene


def checked_rules(rules: object) -> Rules:
    """The record of rules itself, if it is one.

    Raises
    ------
    InputError
    """
    if not isinstance(rules, Rules):
        raise InputError(
            "not a record of rules",
            where="rules",
            got=type(rules).__name__,
            expected="minirt.SLIDES or SLIDES.replace(…); other arguments by name: quantities=…",
        )
    return rules
