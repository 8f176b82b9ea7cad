"""S4, S6: RT(P0, d, t0, t1): what a ray meets first, whether it meets anything, all it meets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from minirt.bvh import Tree, may_cross, may_touch, reciprocal, visit
from minirt.geometry import Geometry, Polygon
from minirt.rules import Rules
from minirt.shapes.triangle import Meeting
from minirt.vectors import Bools, Floats, Index, Ints

#: Ray–primitive pairs in one pass: the kernels' temporaries then stay in a few megabytes.
_PAIRS = 65_536
#: A limit below every t: of a ray whose question is answered.
_ANSWERED = -1e300


@dataclass(frozen=True, eq=False)
class Hits:
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
    def none(cls, shape: tuple[int, ...]) -> Hits:
        """No hit."""
        return cls(
            np.full(shape, np.inf),
            np.full(shape, -1, dtype=np.int32),
            np.full(shape, -1, dtype=np.int32),
            np.full(shape, np.nan),
            np.full(shape, np.nan),
        )

    def take(self, index: Index) -> Hits:
        """Some of the answers."""
        return Hits(*(value[index] for value in vars(self).values()))

    def put(self, index: Index, other: Hits) -> None:
        """Overwrite some of the answers."""
        for name, value in vars(self).items():
            value[index] = getattr(other, name)


def nearest(
    geometry: Geometry, rules: Rules, P0: Floats, d: Floats,
    t0: Floats | float, t1: Floats | float = np.inf,
    later_than: Hits | None = None, earlier_than: Hits | None = None,
) -> Hits:  # fmt: skip
    """RT: the first hit of each ray with t ∈ [t0, t1].

    Parameters
    ----------
    P0, d : (3, n) float64
    t0, t1 : float or (n,) float64
    later_than, earlier_than : Hits, optional
        One face a ray, which is passed over together with all before it, or all after it, in
        the scene's order.
    """
    return _Query(geometry, rules, P0, d, t0, t1, False, later_than, earlier_than).run()


def occluded(
    geometry: Geometry, rules: Rules, P0: Floats, d: Floats, t0: Floats | float, t1: float = np.inf
) -> Bools:
    """Whether RT(P0, d, t0, t1) ≠ ∅, (n,) bool. Source: S12."""
    return _Query(geometry, rules, P0, d, t0, t1, any_hit=True).run().object >= 0


#: Tests rays against primitives, all pairs: the best hit of each of the rays.
_Test: TypeAlias = Callable[[Index, Index], Hits]


class _Query:
    """One call of RT for n rays: walks the primitives and keeps the best hit of each ray."""

    def __init__(
        self, geometry: Geometry, rules: Rules, P0: Floats, d: Floats,
        t0: Floats | float, t1: Floats | float, any_hit: bool = False,
        later_than: Hits | None = None, earlier_than: Hits | None = None,
    ) -> None:  # fmt: skip
        n = P0.shape[1]
        self.geometry, self.rules, self.P0, self.d = geometry, rules, P0, d
        self.inverse = reciprocal(d)
        self.t0 = np.broadcast_to(np.asarray(t0, dtype=np.float64), (n,))
        self.t1 = np.broadcast_to(np.asarray(t1, dtype=np.float64), (n,))
        self.any_hit, self.later_than, self.earlier_than = any_hit, later_than, earlier_than
        self.best = Hits.none((n,))
        #: Largest t that can still matter, for culling only.
        self.limit = self.t1.copy()

    def run(self) -> Hits:
        if self.geometry.polygons:
            self._walk(self.geometry.polygon_tree, self._polygons)
        if len(self.geometry.spheres.radius):
            self._walk(self.geometry.spheres.tree, self._spheres)
        if len(self.geometry.triangles.object):
            self._walk(self.geometry.triangles.tree, self._triangles)
        return self.best

    def _culls(self) -> bool:
        """Boxes hold the lecture's shapes only: a replaced rule is asked about every pair."""
        return not {
            "closer", "in_interval", "sphere", "smallest_root", "triangle", "plane", "polygon",
        }.intersection(self.rules.changed())  # fmt: skip

    def _walk(self, tree: Tree, test: _Test) -> None:
        if self._culls():
            for rays, leaf in visit(tree, self.P0, self.inverse, self.t0, self.limit):
                self._pairs(rays, tree.order[leaf.start : leaf.stop], test)
        else:
            count, every = len(tree.order), np.arange(self.P0.shape[1])
            one = "closer" in self.rules.changed()
            size = 1 if one else max(1, _PAIRS // max(1, len(every)))
            for start in range(0, count, size):
                self._pairs(every, np.arange(start, min(count, start + size)), test)

    def _pairs(self, rays: Index, primitives: Index, test: _Test) -> None:
        size = max(1, _PAIRS // max(1, len(primitives)))
        for start in range(0, len(rays), size):
            chunk = rays[start : start + size]
            self._keep(chunk, test(chunk, primitives))

    def _spheres(self, rays: Index, which: Index) -> Hits:
        spheres, shape = self.geometry.spheres, (len(rays), len(which))
        t = np.full(shape, np.inf)
        pair = self._sphere_pairs(rays, which)
        some, of = rays[pair[0]], which[pair[1]]
        t0, t1, accept = self.t0[some], self.t1[some], self.rules.in_interval
        near, far = self.rules.sphere(
            self.P0[:, some], self.d[:, some], spheres.center[:, of], spheres.radius[of]
        )
        t[pair] = self.rules.smallest_root(near, far, accept(near, t0, t1), accept(far, t0, t1))
        t = self._but(t, rays, spheres.object[which], np.int32(0))
        first = t.argmin(axis=1)
        found = spheres.object[which[first]]
        nan = np.full(len(rays), np.nan)
        return Hits(t[np.arange(len(rays)), first], found, np.zeros_like(found), nan, nan)

    def _sphere_pairs(self, rays: Index, which: Index) -> tuple[Index, ...]:
        """Places in rays and in which of the pairs that the kernel is to decide."""
        spheres = self.geometry.spheres
        if not self._culls():
            return _every_pair(rays, which)
        return np.nonzero(
            may_touch(
                self.P0[:, rays], self.d[:, rays],
                spheres.center[:, which], spheres.radius[which],
            )
        )  # fmt: skip

    def _triangles(self, rays: Index, which: Index) -> Hits:
        tri = self.geometry.triangles
        shape = (len(rays), len(which))
        t, beta, gamma = np.full(shape, np.inf), np.full(shape, np.nan), np.full(shape, np.nan)
        pair = self._triangle_pairs(rays, which)
        some, of = rays[pair[0]], which[pair[1]]
        met = self.rules.triangle(
            self.P0[:, some], self.d[:, some],
            tri.a[:, of], tri.b[:, of], tri.c[:, of], tri.N[:, of],
        )  # fmt: skip
        counts = self.rules.in_interval(met.t, self.t0[some], self.t1[some])
        t[pair] = np.where(counts & (met.case == Meeting.INSIDE), met.t, np.inf)
        beta[pair], gamma[pair] = met.beta, met.gamma
        t = self._but(t, rays, tri.object[which], tri.face[which])
        first = t.argmin(axis=1)
        cell = (np.arange(len(rays)), first)
        found = which[first]
        return Hits(t[cell], tri.object[found], tri.face[found], beta[cell], gamma[cell])

    def _triangle_pairs(self, rays: Index, which: Index) -> tuple[Index, ...]:
        """Places in rays and in which of the pairs that the kernel is to decide."""
        if not self._culls():
            return _every_pair(rays, which)
        tri = self.geometry.triangles
        return np.nonzero(
            may_cross(
                self.P0[:, rays], self.d[:, rays], tri.offset[which],
                tri.N[:, which], tri.lower[:, which], tri.upper[:, which],
            )
        )  # fmt: skip

    def _polygons(self, rays: Index, which: Index) -> Hits:
        for number in which[:-1]:
            self._keep(rays, self._polygon(rays, self.geometry.polygons[number]))
        return self._polygon(rays, self.geometry.polygons[which[-1]])

    def _polygon(self, rays: Index, polygon: Polygon) -> Hits:
        found = Hits.none(rays.shape)
        some = self._near_polygon(rays, polygon) if self._culls() else np.arange(len(rays))
        if not len(some):
            return found
        rays, facets = rays[some], polygon.facets
        met = self.rules.polygon(
            self.P0[:, rays], self.d[:, rays], facets.corners, facets.edge_normals,
            facets.plane, self.rules.plane, self.rules.triangle,
        )  # fmt: skip
        counts = (met.triangle >= 0) & self.rules.in_interval(met.t, self.t0[rays], self.t1[rays])
        object_ = np.full(len(rays), polygon.object, dtype=np.int32)
        t = np.where(counts, met.t, np.inf)
        t = self._but(t[:, None], rays, object_[:1], met.triangle[:, None])[:, 0]
        found.put(some, Hits(t, object_, met.triangle, met.beta, met.gamma))
        return found

    def _near_polygon(self, rays: Index, polygon: Polygon) -> Index:
        """Which of the rays the kernel is to decide."""
        p = polygon.facets.plane
        cross = may_cross(
            self.P0[:, rays], self.d[:, rays], polygon.offset, p, polygon.lower, polygon.upper
        )
        return np.flatnonzero(cross[:, 0])

    def _but(self, t: Floats, rays: Index, object_: Ints, face: Ints | np.int32) -> Floats:
        """t (rays, primitives) without the faces that each ray is to pass over."""
        if self.later_than is not None:
            known = self.later_than.take(rays)
            o, f = known.object[:, None], known.triangle[:, None]
            t = np.where((object_ > o) | ((object_ == o) & (face > f)), t, np.inf)
        if self.earlier_than is not None:
            known = self.earlier_than.take(rays)
            o, f = known.object[:, None], known.triangle[:, None]
            t = np.where((object_ < o) | ((object_ == o) & (face < f)), t, np.inf)
        return t

    def _keep(self, rays: Index, found: Hits) -> None:
        best = self.best.take(rays)
        better = np.isfinite(found.t) & self.rules.closer(
            found.t, found.object, found.triangle, best.t, best.object, best.triangle
        )
        chosen = rays[better]
        self.best.put(chosen, found.take(np.flatnonzero(better)))
        self.limit[chosen] = _ANSWERED if self.any_hit else found.t[better]


def _every_pair(rays: Index, which: Index) -> tuple[Index, ...]:
    return np.nonzero(np.ones((len(rays), len(which)), dtype=np.bool_))
