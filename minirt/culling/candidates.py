"""Culling: which primitives each ray is offered, by whatever way costs least. All offer enough."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import TypeAlias

import numpy as np

from minirt.culling.bounding_tests import BoundingTest, PlaneBoundingTest, SphereBoundingTest
from minirt.culling.packets import PACKET, PAD, Blocks, Packets, Rays
from minirt.culling.rasteriser import Rasteriser
from minirt.culling.ray_grid import RayGrid
from minirt.culling.tree import Tree, visit
from minirt.geometry import Geometry, Spheres, Triangles
from minirt.vectors import Bools, Floats, Index, divided

#: Ray–primitive pairs in one pass: the temporaries then stay in a few megabytes; and pairs of
#: single rays, each of which fetches its primitive's numbers.
_PAIRS, _SINGLE = 16_384, 8_192
#: Primitives of a kind that are not worth a tree, and rays that they are offered to together.
_FEW, _CROWD = 32, 16_384
#: Share of the pairs of blocks and primitives that may meet below which blocks are told apart.
_SPARSE = 0.25

#: Share of the usual group's radius within which origins are one point.
_POINT = 2.0**-7

#: Pairs (p,) of a ray and a primitive, by number.
Pairs: TypeAlias = tuple[Index, Index]


def few(geometry: Geometry) -> bool:
    """Whether there are so few primitives of each kind that none is worth a tree."""
    counts = (geometry.polygons, geometry.spheres.radius, geometry.triangles.object)
    return max(map(len, counts)) <= _FEW


def may_show(geometry: Geometry, P0: tuple[Floats, Floats], d: tuple[Floats, Floats]) -> Bools:
    """Whether any ray may meet anything, (b,), of all whose P0 and d lie in b boxes.

    Parameters
    ----------
    geometry : Geometry
        Of `few` objects.
    P0, d : pair of (3, b) or (3, 1) float64
        Lower and upper corners.
    """
    box = np.arange(d[0].shape[1])
    blocks = Blocks(box, P0, d)
    tests = _BoundingTests(geometry, np.concatenate(P0), np.full(box.shape, np.inf))
    found = np.zeros(box.shape, dtype=np.bool_)
    for test, m in tests.each():
        found |= test.blocks(blocks, np.arange(m)).any(axis=0)
    return found


class _BoundingTests:
    """The bounding tests of a scene's kinds of primitives.

    Parameters
    ----------
    geometry : Geometry
    P0 : (…, n) float64
        Origins, in any shape.
    t_max : (n,) float64
        Largest t of interest for each ray.
    """

    def __init__(self, geometry: Geometry, P0: Floats, t_max: Floats) -> None:
        self._geometry, self._P0, self._t_max = geometry, P0, t_max

    def polygons(self) -> BoundingTest:
        geometry = self._geometry
        pad = self.pad(geometry.polygon_tree)
        return PlaneBoundingTest(lambda: geometry.polygon_patches, pad, self._t_max)

    def spheres(self) -> BoundingTest:
        spheres = self._geometry.spheres
        return SphereBoundingTest(spheres.center, spheres.radius, self._t_max)

    def triangles(self) -> BoundingTest:
        triangles = self._geometry.triangles
        return PlaneBoundingTest(lambda: triangles.patches, self.pad(triangles.tree), self._t_max)

    def each(self) -> Iterator[tuple[BoundingTest, int]]:
        """The test of each kind of which there is any, and how many."""
        geometry = self._geometry
        if geometry.polygons:
            yield self.polygons(), len(geometry.polygons)
        if len(geometry.spheres.radius):
            yield self.spheres(), len(geometry.spheres.radius)
        if len(geometry.triangles.object):
            yield self.triangles(), len(geometry.triangles.object)

    def pad(self, tree: Tree) -> float:
        """What primitives and their boxes grow by."""
        return PAD * self.reach(tree)

    def reach(self, tree: Tree) -> float:
        """The largest coordinate of any box and of any origin."""
        return max(tree.reach, self._magnitude)

    @cached_property
    def _magnitude(self) -> float:
        return float(np.fmax.reduce(np.abs(self._P0), axis=None, initial=0.0))


class CandidatePairs:
    """The primitives that n rays may meet, kind by kind, near ones first.

    Parameters
    ----------
    geometry : Geometry
    rays : Rays
    t_max : (n,) float64
        Largest t of interest for each ray; the caller may lower it between two candidates.
    """

    def __init__(self, geometry: Geometry, rays: Rays, t_max: Floats) -> None:
        self._geometry, self._rays, self._t_max = geometry, rays, t_max
        self._tests = _BoundingTests(geometry, rays.P0, t_max)

    def polygons(self) -> Iterator[Pairs]:
        """Pairs of a ray and a polygon."""
        geometry = self._geometry
        tree = geometry.polygon_tree
        yield from self._any(len(geometry.polygons), tree, self._tests.polygons())

    def spheres(self) -> Iterator[Pairs]:
        """Pairs of a ray and a sphere."""
        spheres = self._geometry.spheres
        yield from self._drawn(spheres, len(spheres.radius), self._tests.spheres())

    def triangles(self) -> Iterator[Pairs]:
        """Pairs of a ray and a triangle."""
        triangles = self._geometry.triangles
        yield from self._drawn(triangles, len(triangles.object), self._tests.triangles())

    def _drawn(self, kind: Spheres | Triangles, m: int, test: BoundingTest) -> Iterator[Pairs]:
        """All m of a kind, drawn over the rays' grid if they have one and it pays."""
        grid = self._grid(kind) if m > _FEW else None
        rasteriser = None if grid is None else Rasteriser(grid, kind.groups)
        if rasteriser is None or not rasteriser.worth:
            yield from self._any(m, kind.tree, test)
        else:
            yield from self._few(rasteriser.close, test)
            yield from rasteriser.pairs(self._t_max)

    def _grid(self, kind: Spheres | Triangles) -> RayGrid | None:
        """The rays' grid, if they have one; as from one point if they nearly leave one."""
        rays, reach, moved = self._rays, self._tests.reach(kind.tree), 0.0
        if rays.P0.strides[1] != 0 and rays.d.strides[1] != 0:
            low, high = rays.P0.min(axis=1), rays.P0.max(axis=1)
            with np.errstate(invalid="ignore"):  # not finite
                moved = float((high - low).sum())
            if not moved <= _POINT * np.median(kind.groups.radius):
                return None
            point = ((low + high) / 2)[:, None]
            rays = Rays(np.broadcast_to(point, rays.P0.shape), rays.d, rays.t0)
        return RayGrid.of(rays, PAD * reach + moved, reach)

    def _any(self, m: int, tree: Tree, test: BoundingTest) -> Iterator[Pairs]:
        """All m of a kind, by their tree if they are many."""
        if m <= _FEW:
            return self._few(np.arange(m), test)
        return self._tested(
            visit(tree, self._rays.packets, self._t_max, self._tests.pad(tree)), test
        )

    def _few(self, primitives: Index, test: BoundingTest) -> Iterator[Pairs]:
        """Few primitives: offered to the blocks that they fill, and to rays of others they meet.

        Where many blocks are of the latter kind, crowds of rays are asked instead.
        """
        if not len(primitives):
            return
        rays, blocks = self._rays, self._rays.blocks
        meet = test.blocks(blocks, primitives)
        some, which = np.nonzero(meet)
        filled = test.filled(blocks, which, primitives.take(some))
        if len(which) - np.count_nonzero(filled) > _SPARSE * meet.size:
            of_one = np.zeros(len(primitives), dtype=np.intp)
            crowds = ((crowd, of_one, primitives) for crowd in rays.crowds(_CROWD))
            yield from self._tested(crowds, test)
            return
        packets = Packets(rays, np.arange(0, len(self._t_max), PACKET), PACKET)
        whole = np.flatnonzero(filled)
        for part in np.array_split(whole, len(whole) * PACKET // _PAIRS + 1):
            every = PACKET * which.take(part)[:, None] + np.arange(PACKET)
            of_each = np.repeat(primitives.take(some.take(part)), PACKET)
            yield self._there(every.ravel(), of_each)
        rest = np.flatnonzero(~filled)
        pairs = (packets, which.take(rest), primitives.take(some.take(rest)))
        yield from self._tested([pairs], test)

    def _tested(
        self, pairs: Iterable[tuple[Packets, Index, Index]], test: BoundingTest
    ) -> Iterator[Pairs]:
        """Of packets and the primitives that they may meet, rays and those that they may."""
        for packets, which, primitives in pairs:
            step = max(1, _PAIRS // packets.size) if packets.size > 1 else _SINGLE
            for start in range(0, len(which), step):
                some = slice(start, start + step)
                may_meet = test.rays(packets, which[some], primitives[some])
                offered = np.flatnonzero(np.broadcast_to(may_meet, (len(may_meet), packets.size)))
                pair, at = divided(offered, packets.size)
                numbers = packets.numbers(which[some].take(pair), at)
                yield self._there(numbers, primitives[some].take(pair))

    def _there(self, rays: Index, primitives: Index) -> Pairs:
        """The pairs of rays that there are: the last block, or packet, may reach beyond them."""
        n = len(self._t_max)
        if n % PACKET == 0:
            return rays, primitives
        there = np.flatnonzero(rays < n)
        return rays.take(there), primitives.take(there)
