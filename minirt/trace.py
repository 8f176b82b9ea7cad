"""S4, S6: RT(P0, d, t0, t1): what a ray meets first, whether it meets anything, all it meets."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from minirt.culling.candidates import CandidatePairs, Pairs
from minirt.culling.packets import Rays
from minirt.geometry import Fans, Geometry
from minirt.memory import keep_freed_memory
from minirt.rules import Rules
from minirt.shapes.triangle import TriangleCase
from minirt.vectors import Bools, Floats, Index, Ints, take

keep_freed_memory()

#: Pairs for which a kernel is called: enough to make a call's own cost small, and so many that
#: its temporaries stay in a few megabytes.
_BATCH, _PAIRS = 8_192, 65_536
#: A t_max below every t: of a ray whose question is answered.
_ANSWERED = -1e300
#: Rules that decide what a ray meets: once replaced, they are asked about every pair.
ASKED_OF_EVERY_PAIR = frozenset(
    {"closer", "in_interval", "sphere", "smallest_root", "triangle", "plane", "polygon"}
)

#: Objects (n,), and a face of each; all of its faces for None.
Faces: TypeAlias = tuple[Ints, Ints | None]


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
        return Hits(*(value.take(index) for value in vars(self).values()))

    def put(self, index: Index, other: Hits) -> None:
        """Overwrite some of the answers."""
        for name, value in vars(self).items():
            value[index] = getattr(other, name)


def nearest(
    geometry: Geometry, rules: Rules, P0: Floats, d: Floats,
    t0: Floats | float, t1: Floats | float = np.inf,
    other_than: Faces | None = None,
) -> Hits:  # fmt: skip
    """RT: the first hit of each ray with t ∈ [t0, t1].

    Parameters
    ----------
    P0, d : (3, n) float64
    t0, t1 : float or (n,) float64
    other_than : Faces, optional
        One a ray, which is passed over; a sphere or a polygon as a whole.
    """
    return _Query(geometry, rules, P0, d, t0, t1, False, other_than).run()


def nearest_two(
    geometry: Geometry, rules: Rules, P0: Floats, d: Floats, t0: Floats | float,
    fixed: Floats | float, relative: float,
) -> tuple[Hits, Floats]:  # fmt: skip
    """The first hit of each ray with t ≥ t0, and the t of the next.

    Parameters
    ----------
    fixed, relative : (n,) float64 or float, float
        How far the next is looked for: up to t·(1 + relative) + fixed.

    Returns
    -------
    first : Hits
    t : (n,) float64
        Of the next hit of any other primitive; if that is farther, anything that is farther too.
        A primitive may count as its own next.
    """
    query = _Query(geometry, rules, P0, d, t0, np.inf)
    next_t = query.watch(fixed, relative)
    return query.run(), next_t


def occluded(
    geometry: Geometry, rules: Rules, P0: Floats, d: Floats, t0: Floats | float, t1: float = np.inf
) -> Bools:
    """Whether RT(P0, d, t0, t1) ≠ ∅, (n,) bool. Source: S12."""
    return _Query(geometry, rules, P0, d, t0, t1, any_hit=True).run().object >= 0


#: Decides pairs of a ray and a primitive: a hit a pair.
_Kernel: TypeAlias = Callable[[Index, Index], Hits]


class _Query:
    """One call of RT for n rays: walks the primitives and keeps the best hit of each ray."""

    def __init__(
        self, geometry: Geometry, rules: Rules, P0: Floats, d: Floats,
        t0: Floats | float, t1: Floats | float, any_hit: bool = False,
        other_than: Faces | None = None,
    ) -> None:  # fmt: skip
        n = P0.shape[1]
        self.geometry, self.rules, self.P0, self.d = geometry, rules, P0, d
        self.t0 = np.broadcast_to(np.asarray(t0, dtype=np.float64), (n,))
        self.t1 = np.broadcast_to(np.asarray(t1, dtype=np.float64), (n,))
        self.any_hit, self.other_than = any_hit, other_than
        self.best = Hits.none((n,))
        #: Largest t that can still matter, for culling only.
        self.t_max = self.t1.copy()
        #: t of the second best hit, if that is watched.
        self.next_t: Floats | None = None
        #: Scratch: whose turn it is among the hits of a ray.
        self.turn = np.empty(n, dtype=np.intp)
        #: Boxes hold the lecture's shapes only: a replaced rule is asked about every pair.
        self.culls = ASKED_OF_EVERY_PAIR.isdisjoint(rules.changed())

    def watch(self, fixed: Floats | float, relative: float) -> Floats:
        """t of the second best hit, once `run`: see `nearest_two`."""
        self.next_t = np.full(self.t_max.shape, np.inf)
        self.relative = relative
        self.fixed = np.broadcast_to(np.asarray(fixed, dtype=np.float64), self.t_max.shape)
        return self.next_t

    def run(self) -> Hits:
        if not len(self.t_max):
            return self.best
        geometry = self.geometry
        candidates = CandidatePairs(geometry, Rays(self.P0, self.d, self.t0), self.t_max)
        if geometry.polygons:
            objects = np.array([polygon.object for polygon in geometry.polygons])
            self._walk(candidates.polygons(), self._polygons, objects)
        if len(geometry.spheres.radius):
            spheres = geometry.spheres
            self._walk(candidates.spheres(), self._spheres, spheres.object)
        if len(geometry.triangles.object):
            triangles = geometry.triangles
            offered = candidates.triangles()
            self._walk(offered, self._triangles, triangles.object, triangles.face)
        return self.best

    def _walk(
        self, offered: Iterable[Pairs], kernel: _Kernel, object_: Ints, face: Ints | None = None
    ) -> None:
        """Decide primitives of one kind, whose objects, and faces if more than one, are given."""
        batches = (
            self._batches(offered, object_, face) if self.culls else self._every_pair(len(object_))
        )
        for rays, which in batches:
            self._keep(rays, kernel(rays, which), alone=face is None)

    def _batches(
        self, offered: Iterable[Pairs], object_: Ints, face: Ints | None
    ) -> Iterator[Pairs]:
        """Offered pairs, gathered until they are worth a kernel's call.

        What is kept of one batch shortens the candidates from the next on.
        """
        waiting: list[Pairs] = []
        size = 0
        for rays, which in offered:
            pairs = self._unless_passed_over(rays, which, object_, face)
            waiting.append(pairs)
            size += len(pairs[0])
            if size >= _BATCH:
                yield _joined(waiting)
                waiting, size = [], 0
        if size:
            yield _joined(waiting)

    def _unless_passed_over(
        self, rays: Index, which: Index, object_: Ints, face: Ints | None
    ) -> Pairs:
        """The pairs whose hit could count: a ray has one hit at most on an object of one face."""
        if self.other_than is None:
            return rays, which
        f = None if face is None else face[which]
        some = np.flatnonzero(self._wanted(rays, object_[which], f, self.other_than))
        return rays[some], which[some]

    def _every_pair(self, primitives: int) -> Iterator[Pairs]:
        """Every ray with every primitive; one primitive a batch where `closer` is to choose."""
        every = np.arange(self.P0.shape[1])
        size = 1 if "closer" in self.rules.changed() else max(1, _PAIRS // max(1, len(every)))
        for start in range(0, primitives, size):
            some = np.arange(start, min(primitives, start + size))
            yield np.repeat(every, len(some)), np.tile(some, len(every))

    def _origins(self, rays: Index) -> Floats:
        """Of some rays, (3, k); as (3, 1) where the lecture's own kernels may have one for all."""
        one = self.culls and self.P0.strides[1] == 0
        return self.P0[:, :1] if one else take(self.P0, rays)

    def _spheres(self, rays: Index, which: Index) -> Hits:
        spheres, accept = self.geometry.spheres, self.rules.in_interval
        t0, t1 = _of(self.t0, rays), _of(self.t1, rays)
        center, radius = spheres.center, spheres.radius
        if len(radius) > 1 or not self.culls:
            center, radius = take(center, which), radius[which]
        near, far = self.rules.sphere(self._origins(rays), take(self.d, rays), center, radius)
        t = self.rules.smallest_root(near, far, accept(near, t0, t1), accept(far, t0, t1))
        nan = np.full(len(rays), np.nan)
        return Hits(t, spheres.object[which], np.zeros(len(rays), dtype=np.int32), nan, nan)

    def _triangles(self, rays: Index, which: Index) -> Hits:
        tri = self.geometry.triangles
        met = self.rules.triangle(
            self._origins(rays), take(self.d, rays),
            take(tri.a, which), take(tri.b, which), take(tri.c, which), take(tri.N, which),
        )  # fmt: skip
        counts = self.rules.in_interval(met.t, _of(self.t0, rays), _of(self.t1, rays))
        t = np.where(counts & (met.case == TriangleCase.INSIDE), met.t, np.inf)
        return Hits(t, tri.object[which], tri.face[which], met.beta, met.gamma)

    def _polygons(self, rays: Index, which: Index) -> Hits:
        found = Hits.none(rays.shape)
        for fans in self.geometry.fans:
            some = np.flatnonzero(fans.place[which] >= 0)
            if len(some):
                found.put(some, self._polygons_alike(rays[some], fans, fans.place[which[some]]))
        return found

    def _polygons_alike(self, rays: Index, fans: Fans, which: Index) -> Hits:
        """Pairs of a ray and a polygon, all with as many vertices."""
        a, b, c, N, p = (*fans.corners, fans.normals, fans.plane)
        if len(fans.object) > 1:
            a, b, c, N, p = (v.take(which, axis=-1) for v in (a, b, c, N, p))
        met = self.rules.polygon(
            self._origins(rays), take(self.d, rays), (a, b, c), N, p,
            self.rules.plane, self.rules.triangle,
        )  # fmt: skip
        t0, t1 = _of(self.t0, rays), _of(self.t1, rays)
        counts = (met.triangle >= 0) & self.rules.in_interval(met.t, t0, t1)
        t = np.where(counts, met.t, np.inf)
        return Hits(t, fans.object[which], met.triangle, met.beta, met.gamma)

    def _keep(self, rays: Index, found: Hits, *, alone: bool) -> None:
        """Take over, of hits of rays, the best of each ray that is better than what it has.

        `alone` says that a ray has one hit at most on each of these objects.
        """
        counts: Bools = np.isfinite(found.t)
        if self.other_than is not None:
            face = None if alone else found.triangle
            counts &= self._wanted(rays, found.object, face, self.other_than)
        if not counts.all():
            at = np.flatnonzero(counts)
            rays, found = rays[at], found.take(at)
        while (rays[1:] <= rays[:-1]).any():  # one hit of each ray at a time
            each = np.arange(len(rays))
            self.turn[rays] = each
            mine = self.turn[rays] == each
            one, others = np.flatnonzero(mine), np.flatnonzero(~mine)
            self._keep_one(rays[one], found.take(one))
            rays, found = rays[others], found.take(others)
        self._keep_one(rays, found)

    def _keep_one(self, rays: Index, found: Hits) -> None:
        best = self.best
        t = best.t[rays]
        closer = self.rules.closer(
            found.t, found.object, found.triangle, t, best.object[rays], best.triangle[rays]
        )
        if self.next_t is not None:
            self.next_t[rays] = np.minimum(self.next_t[rays], np.where(closer, t, found.t))
        if not closer.all():
            better = np.flatnonzero(closer)
            rays, found = rays[better], found.take(better)
        best.put(rays, found)
        self.t_max[rays] = _ANSWERED if self.any_hit else self._latest(rays, found.t)

    def _latest(self, rays: Index, t: Floats) -> Floats:
        """Largest t of interest for rays whose best hits are at t."""
        return t if self.next_t is None else t * (1.0 + self.relative) + self.fixed[rays]

    @staticmethod
    def _wanted(rays: Index, o: Ints, f: Ints | None, other_than: Faces) -> Bools:
        """Whether a face, by object and number, if it has one, is none that its ray passes over."""
        object_, face = other_than
        wanted: Bools = o != object_[rays]
        return wanted if f is None or face is None else wanted | (f != face[rays])


def _of(values: Floats, rays: Index) -> Floats:
    """The values (n,) of some rays, (k,)."""
    some: Floats = take(values[None], rays)[0]
    return some


def _joined(batch: list[Pairs]) -> Pairs:
    rays, which = zip(*batch, strict=True)
    return np.concatenate(rays), np.concatenate(which)
