"""S4, S7, S12–S16: what is at a ray's hit, the rays that leave from there, and their colour."""

from __future__ import annotations

import numpy as np

from minirt.errors import InputError
from minirt.geometry import Geometry
from minirt.hits import RayHits
from minirt.points import NOTHING_TRACED, Branch, Points, SecondaryRays
from minirt.rays import Rays
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene
from minirt.screen import image_pixels
from minirt.shading import in_total_reflection, object_materials
from minirt.trace import RT, World, normals, occluded
from minirt.vectors import Bools, Floats, Index, column, dot, norm, put, take


class RayTree:
    """The rays of the lecture's algorithm on one scene, under given rules.

    This class and `Whitted` are what a harness extends: to ask what would change if another
    renderer did a step a little differently, or to note what happens, it overrides the method of
    that step. Nothing in here is there for a harness alone.

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
        self.world = World.of(Geometry.of(scene), rules)
        self.materials = object_materials(scene)
        self.epsilon = rules.start_of_secondary(scene.epsilon)
        self.to_light = rules.to_light(column(scene.light_direction))

    def rays_of(self, pixels: Index) -> Rays:
        """The rays from the observer through the centres of pixels (n,). Source: S1–S3, S5."""
        d = primary_directions(self.scene, self.rules, pixels)
        return Rays.of(column(self.scene.screen.P0), d)

    def secondary_rays(self, points: Points, direction: Floats) -> Rays:
        """The rays from points along unit directions (3, n), or all along one (3, 1), from ε on.

        Source: S12, S14, S16.
        """
        return Rays.of(points.M, direction, self.epsilon)

    def first_hits(self, rays: Rays) -> RayHits:
        """What rays meet first. Source: S4, S6."""
        return RT(self.world, rays)

    def points(self, rays: Rays, hits: RayHits) -> Points:
        """The surface points of those rays that hit something. Source: S4."""
        of = np.flatnonzero(hits.object >= 0)
        hits = hits.take(of)
        d = take(rays.d, of)
        M = self.rules.point_at(take(rays.P0, of), d, hits.t)
        s = normals(self.world, M, hits)
        return Points(of, M, d / norm(d), s, s, hits, self.materials.take(hits.object))

    def shadow(self, points: Points) -> Bools:
        """Whether each point is in shadow: RT(M, −l, ε, ∞) ≠ ∅. Source: S12."""
        return occluded(self.world, self.secondary_rays(points, self.to_light))

    def reflected(self, points: Points) -> Branch:
        """ρ and what RT(P, ρ, ε, ∞) meets. Source: S14."""
        s = self.rules.toward_viewer(points.s, points.delta)
        return self.leave(points, self.rules.reflect(points.delta, s))

    def refracted(self, points: Points) -> Branch:
        """ϱ and what RT(P, ϱ, ε, ∞) meets, of points whose material has an index. Source: S16.

        The direction is NaN, and nothing is met, at total internal reflection (E2).
        """
        leaving = dot(points.delta, points.s) > 0
        nu, nu_t = self.rules.indices(points.material.ior, leaving)
        direction = self.rules.refract(points.delta, points.s, nu, nu_t)
        passing = np.flatnonzero(~np.isnan(direction[0]))
        some = self.leave(points.take(passing), take(direction, passing))
        hits, length = RayHits.none(leaving.shape), np.full(leaving.shape, np.inf)
        hits.put(passing, some.hits)
        length[passing] = some.length
        origin = points.M.copy()
        put(origin, passing, some.origin)
        return Branch(origin, direction, hits, length)

    def leave(self, points: Points, direction: Floats) -> Branch:
        """RT of the rays from points along unit directions (3, n)."""
        rays = self.secondary_rays(points, direction)
        hits = self.first_hits(rays)
        return Branch(rays.P0, direction, hits, hits.t)


class Whitted(RayTree):
    """The lecture's algorithm: the colour that each ray brings. Parameters as of `RayTree`."""

    def color(self, rays: Rays, hits: RayHits, generation: int = 0) -> Floats:
        """rayColor: linear RGB (3, n) of rays, of which some hit something. Source: S7."""
        return self.color_of(self.points(rays, hits), rays.count, generation)

    def color_of(
        self,
        points: Points,
        n: int,
        generation: int = 0,
        traced: SecondaryRays = NOTHING_TRACED,
    ) -> Floats:
        """`color` of n rays with those points; what is `traced` already is not traced again."""
        result = np.broadcast_to(column(self.scene.background), (3, n)).copy()
        if len(points.rays):
            put(result, points.rays, self._point_color(points, generation, traced))
        return result

    def _point_color(self, points: Points, generation: int, traced: SecondaryRays) -> Floats:
        dark = self.shadow(points) if traced.dark is None else traced.dark
        transparent = np.flatnonzero(points.material.transmittance > 0)
        through = self._refracted_of(points, transparent, traced)
        total = np.zeros(len(points.rays), dtype=np.bool_)
        total[transparent] = np.isnan(through.direction[0])
        k_r, k_t = self.shares(points, total)
        mirrored, transmitted = np.zeros_like(points.M), np.zeros_like(points.M)
        if generation < self.scene.max_depth:
            shiny, passing = np.flatnonzero(k_r > 0), np.flatnonzero(~total[transparent])
            if len(shiny):
                back = self._reflected_of(points, shiny, traced)
                put(mirrored, shiny, self.branch_color(shiny, back, generation))
            if len(passing):
                on, ahead = transparent[passing], through.take(passing)
                put(transmitted, on, self.branch_color(on, ahead, generation))
        local = self.local_color(points, dark)
        return self.rules.combine(local, mirrored, transmitted, k_r, k_t)

    def shares(self, points: Points, total: Bools) -> tuple[Floats, Floats]:
        """k_r and k_t (n,) of S7, given which points reflect totally. Source: S7, E2."""
        material = points.material
        return in_total_reflection(material.reflectance, material.transmittance, total)

    def branch_color(self, of: Index, branch: Branch, generation: int) -> Floats:
        """rayColor of the rays that leave from some points (k,). Source: S7."""
        return self.color(branch.rays, branch.hits, generation + 1)

    def _reflected_of(self, points: Points, some: Index, traced: SecondaryRays) -> Branch:
        if traced.reflected is None:
            return self.reflected(points.take(some))
        return traced.reflected.take(some)

    def _refracted_of(self, points: Points, some: Index, traced: SecondaryRays) -> Branch:
        if traced.refracted is None:
            return self.refracted(points.take(some))
        return traced.refracted.take(np.searchsorted(points.refractive, some))

    def local_color(self, points: Points, dark: Bools) -> Floats:
        """The colour of the points themselves, (3, n), lit or in shadow. Source: S13."""
        s = self.rules.toward_viewer(points.s, points.delta)
        light = np.broadcast_to(self.to_light, s.shape)
        mirror = self.rules.reflect(-light, s)
        lit = self.rules.illuminate(
            points.material, column(self.scene.light_color), light, s, points.delta, mirror
        )
        shadow = self.rules.shadow_color(points.material, self.scene.shadow_color)
        return np.where(dark, shadow, lit)


def primary_directions(scene: Scene, rules: Rules, pixels: Index) -> Floats:
    """d (3, n) of the rays through the centres of pixels (n,). Source: S1–S3, S5."""
    i, j = image_pixels(scene.screen, pixels)
    frame = rules.view_frame(scene.screen)
    u_s, v_s = rules.pixel_center(scene.screen, i, j)
    return rules.ray_direction(rules.model_from_view(frame, u_s, v_s))


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
