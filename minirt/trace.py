"""S6: RT(P0, d, t0, t1), the first hit of each ray; S8, S9, S11 for pairs of ray and primitive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from minirt.culling import Candidates, SceneIndex, culled_pairs, every_pair
from minirt.geometry import Fans, Geometry, Kind
from minirt.hits import AnyHits, FirstHits, RayHits
from minirt.rays import Rays
from minirt.rules import Rules
from minirt.shapes.triangle import TriangleCase
from minirt.vectors import Bools, Floats, Index, put, take

#: Rules that decide what a ray meets. Bounding volumes hold the lecture's shapes only: once one of
#: these is replaced, every pair of a ray and a primitive is tested.
ASKED_OF_EVERY_PAIR = frozenset(
    {"closer", "in_interval", "sphere", "smallest_root", "triangle", "plane", "polygon"}
)


@dataclass(frozen=True, eq=False)
class World:
    """What rays are traced through.

    Attributes
    ----------
    geometry : Geometry
    index : SceneIndex
    rules : Rules
    candidates : Candidates
        Which pairs of a ray and a primitive are tested by the rules.
    """

    geometry: Geometry
    index: SceneIndex
    rules: Rules
    candidates: Candidates

    @classmethod
    def of(cls, geometry: Geometry, rules: Rules) -> World:
        """A scene's primitives under some rules."""
        own = ASKED_OF_EVERY_PAIR.isdisjoint(rules.changed())
        return cls(geometry, SceneIndex.of(geometry), rules, culled_pairs if own else every_pair)

    @property
    def culls(self) -> bool:
        """Whether the rules are the lecture's own, which take one vector for many as (3, 1)."""
        return self.candidates is not every_pair

    def origins(self, rays: Rays, of: Index) -> Floats:
        """P0 of some rays, (3, k); (3, 1) where the lecture's own rules may have one for all."""
        return rays.P0 if self.culls and rays.one_origin else take(rays.P0, of)


def RT(world: World, rays: Rays, best: FirstHits | None = None) -> RayHits:
    """The first hit of each ray with t ∈ [t0, t1]; ∅ is t = +inf.

    Parameters
    ----------
    world : World
    rays : Rays
    best : FirstHits, optional
        What is kept of the hits.

    Source: S6, S4.
    """
    best = FirstHits(rays, world.rules) if best is None else best
    for kind, of, which in world.candidates(world.index, rays, best.t_max):
        if kind == Kind.SPHERE:
            found = meet_spheres(world, rays, of, which)
        elif kind == Kind.POLYGON:
            found = meet_polygons(world, rays, of, which)
        else:
            found = meet_triangles(world, rays, of, which)
        best.keep(kind, of, found)
    return best.hits


def occluded(world: World, rays: Rays) -> Bools:
    """Whether RT(P0, d, t0, t1) ≠ ∅, (n,) bool. Source: S12."""
    return RT(world, rays, AnyHits(rays, world.rules)).object >= 0


def meet_spheres(world: World, rays: Rays, of: Index, which: Index) -> RayHits:
    """S8 for k pairs of a ray and a sphere, by number: the smallest root in the interval."""
    spheres, rules = world.geometry.spheres, world.rules
    C, R = spheres.center, spheres.radius
    if len(R) > 1 or not world.culls:
        C, R = take(C, which), R[which]
    t0, t1 = rays.interval(of)
    near, far = rules.sphere(world.origins(rays, of), take(rays.d, of), C, R)
    in_near, in_far = rules.in_interval(near, t0, t1), rules.in_interval(far, t0, t1)
    t = rules.smallest_root(near, far, in_near, in_far)
    nan = np.full(len(of), np.nan)
    return RayHits(t, spheres.object[which], np.zeros(len(of), dtype=np.int32), nan, nan)


def meet_triangles(world: World, rays: Rays, of: Index, which: Index) -> RayHits:
    """S9 for k pairs of a ray and a triangle, by number."""
    triangles, rules = world.geometry.triangles, world.rules
    a, b, c, N = (take(v, which) for v in (triangles.a, triangles.b, triangles.c, triangles.N))
    met = rules.triangle(world.origins(rays, of), take(rays.d, of), a, b, c, N)
    counts = rules.in_interval(met.t, *rays.interval(of)) & (met.case == TriangleCase.INSIDE)
    t = np.where(counts, met.t, np.inf)
    return RayHits(t, triangles.object[which], triangles.face[which], met.beta, met.gamma)


def meet_polygons(world: World, rays: Rays, of: Index, which: Index) -> RayHits:
    """S11 for k pairs of a ray and a polygon, by number; those of as many vertices together."""
    found = RayHits.none(of.shape)
    for fans in world.geometry.fans:
        some = np.flatnonzero(fans.place[which] >= 0)
        if len(some):
            found.put(some, _meet_fans(world, rays, of[some], fans, fans.place[which[some]]))
    return found


def _meet_fans(world: World, rays: Rays, of: Index, fans: Fans, which: Index) -> RayHits:
    rules = world.rules
    a, b, c, N, p = (*fans.corners, fans.normals, fans.plane)
    if len(fans.object) > 1:
        a, b, c, N, p = (v.take(which, axis=-1) for v in (a, b, c, N, p))
    P0, d = world.origins(rays, of), take(rays.d, of)
    met = rules.polygon(P0, d, (a, b, c), N, p, rules.plane, rules.triangle)
    counts = (met.triangle >= 0) & rules.in_interval(met.t, *rays.interval(of))
    t = np.where(counts, met.t, np.inf)
    return RayHits(t, fans.object[which], met.triangle, met.beta, met.gamma)


def normals(world: World, M: Floats, hits: RayHits) -> Floats:
    """The unit geometric normals (3, n) on the outside of what is hit at M (3, n)."""
    geometry, rules = world.geometry, world.rules
    normal = np.full_like(M, np.nan)
    kind, first = geometry.kind[hits.object], geometry.first[hits.object]
    on = np.flatnonzero(kind == Kind.SPHERE)
    put(normal, on, rules.sphere_normal(take(M, on), take(geometry.spheres.center, first[on])))
    on = np.flatnonzero(kind == Kind.TRIANGLES)
    which = first[on] + hits.triangle[on]
    put(normal, on, rules.face_normal(take(geometry.triangles.N, which)))
    for fans in geometry.fans:
        on = np.flatnonzero(kind == Kind.POLYGON)
        on = on[fans.place[first[on]] >= 0]
        put(normal, on, rules.face_normal(take(fans.plane, fans.place[first[on]])))
    return normal
