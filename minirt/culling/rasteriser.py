"""Culling by conservative rasterization: which primitives lie over the points of a grid.

They are drawn a little larger than they are, row by row, and near ones first, so that what
rays have met hides what lies behind. Like a tree's boxes, this only candidates primitives to rays.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from minirt.culling.bounding_tests import GRAZING
from minirt.culling.ray_grid import NOTHING, RayGrid
from minirt.culling.tree import Tree
from minirt.vectors import Floats, Index, norm, take

#: Primitives a ray that are worth rasteriser.
_MOST = 16
#: Primitives that are too close to be drawn, at most.
_FEW = 128
#: Primitives drawn at once, their rows gone through at once, and pairs with rays yielded at once.
_CHUNK, _ROWS, _PAIRS = 32_768, 65_536, 16_384


@dataclass(frozen=True, eq=False)
class Projected:
    """Triangles as they lie in a grid, grown by as much as rays may pass by them.

    What is round is a triangle of no size that is grown by its radius.

    Attributes
    ----------
    which : (k,) intp
        Their numbers.
    u, v : (3, k) float64
        Of their vertices.
    near, far : (k,) float64
        Least and largest depth.
    grown : (k,) float64
        By how much they are larger in u and v.
    """

    which: Index
    u: Floats
    v: Floats
    near: Floats
    far: Floats
    grown: Floats

    def take(self, index: Index) -> Projected:
        """Some of them."""
        return Projected(*(value.take(index, axis=-1) for value in vars(self).values()))


@dataclass(frozen=True, eq=False)
class Groups(ABC):
    """Primitives in k groups of s neighbours.

    Attributes
    ----------
    members : (k, s) intp
        Their numbers; some stand in two places.
    middle : (3, k) float64
    radius : (k,) float64
        Of a ball around each group.
    """

    members: Index
    middle: Floats
    radius: Floats

    @abstractmethod
    def placed(self, grid: RayGrid, groups: Index) -> Projected:
        """The members of some groups; of those that are not `beyond` only the depths count."""


@dataclass(frozen=True, eq=False)
class TriangleGroups(Groups):
    """Triangles by their corners (3, 3, k, s), by coordinate and vertex, and unit normals."""

    corners: Floats
    N: NDArray[np.float32]

    @classmethod
    def of(cls, tree: Tree, corners: tuple[Floats, Floats, Floats], N: Floats) -> TriangleGroups:
        """Triangles with those vertices (3, m), as they stand together in their tree."""
        members = _neighbours(tree)
        gathered = np.empty((3, 3, *members.shape))
        for k, vertex in enumerate(corners):
            np.take(vertex, members, axis=1, out=gathered[:, k])
        low, high = gathered.min(axis=(1, 3)), gathered.max(axis=(1, 3))
        normals = N.astype(np.float32).take(members, axis=1)
        return cls(members, (low + high) / 2, norm(high - low) / 2, gathered, normals)

    def placed(self, grid: RayGrid, groups: Index) -> Projected:
        """The triangles of some groups.

        Where rays meet a plane at a small angle, a kernel's point of it may be anywhere near the
        triangle: it grows by its own length.
        """
        which = self.members.take(groups, axis=0).ravel()
        X = self.corners.take(groups, axis=2).reshape(3, 3, -1)
        N = self.N.take(groups, axis=1).reshape(3, -1).astype(np.float64)
        u, v, depth = (c.reshape(3, -1) for c in grid.points(X.reshape(3, -1)))
        near, far = reduce(np.minimum, depth), reduce(np.maximum, depth)
        grown = np.full(len(which), grid.pad)
        flat = np.flatnonzero(grid.grazes(X[:, 0], N, far, GRAZING))
        corners = X[:, :, flat]
        edges = corners - corners[:, [1, 2, 0]]
        grown[flat] += np.sqrt((edges * edges).sum(axis=0).max(axis=0))
        near, far = near - grown, far + grown
        return Projected(which, u, v, near, far, grid.seen_size(grown, near))


@dataclass(frozen=True, eq=False)
class SphereGroups(Groups):
    """Spheres by their centers (3, k, s) and radii (k, s)."""

    centers: Floats
    radii: Floats

    @classmethod
    def of(cls, tree: Tree, center: Floats, radius: Floats) -> SphereGroups:
        """Spheres of those centers (3, m) and radii (m,), as they stand together in their tree."""
        members = _neighbours(tree)
        centers, radii = center.take(members, axis=1), radius.take(members)
        low, high = (centers - radii).min(axis=2), (centers + radii).max(axis=2)
        return cls(members, (low + high) / 2, norm(high - low) / 2, centers, radii)

    def placed(self, grid: RayGrid, groups: Index) -> Projected:
        """The spheres of some groups."""
        which = self.members.take(groups, axis=0).ravel()
        grown = self.radii.take(groups, axis=0).ravel() + grid.pad
        u, v, depth = grid.points(self.centers.take(groups, axis=1).reshape(3, -1))
        near, far = depth - grown, depth + grown
        u, v = (np.broadcast_to(x, (3, len(x))) for x in (u, v))
        return Projected(which, u, v, near, far, grid.seen_size(grown, near))


def _neighbours(tree: Tree) -> Index:
    """The primitives (k, s) of a tree that stand together on its last two levels."""
    return tree.primitives.reshape(-1, int(np.prod([boxes.shape[2] for boxes in tree.boxes[-2:]])))


class Rasteriser:
    """Primitives to be drawn over a grid.

    Attributes
    ----------
    worth : bool
        Whether that costs less than asking a tree for them; nothing else may be asked where not.
    close : (k,) intp
        Those that are too close to be drawn: any ray may meet them.
    """

    def __init__(self, grid: RayGrid, groups: Groups) -> None:
        self._grid, self._groups = grid, groups
        u, v, depth = grid.points(groups.middle)
        reach = groups.radius + grid.pad
        # A triangle may be grown by its own length, and then still is within three radii.
        sure = grid.beyond(depth - 3.0 * reach)
        size = grid.seen_size(reach, np.where(sure, depth, 0.0))
        u, v = np.where(sure, u, 0.0), np.where(sure, v, 0.0)  # of others, anywhere
        self._balls = np.stack((u, v, size, depth - reach))
        seen = grid.shows(u, v, size) & (depth + reach >= grid.earliest.min())
        some, unsure = np.flatnonzero(seen), np.flatnonzero(seen & ~sure)
        self._order = some[np.argsort(self._balls[3].take(some))]
        n, many = len(grid), groups.members.shape[1]
        self.worth = len(some) * many <= _MOST * n and len(unsure) * many <= n
        if self.worth:
            placed = groups.placed(grid, unsure)
            close = ~grid.beyond(placed.near) & (placed.far >= 0)
            self.close = np.unique(placed.which[close])
            self.worth = len(self.close) <= _FEW

    def pairs(self, t_max: Floats) -> Iterator[tuple[Index, Index]]:
        """Yield (rays, primitives): pairs (p,) that may meet by t = t_max (n,), near ones first.

        The caller may lower the t_max between two steps.
        """
        step = max(1, _CHUNK // self._groups.members.shape[1])
        for start in range(0, len(self._order), step):
            some = self._order[start : start + step]
            if start or t_max.min() < np.inf:
                u, v, radius, near = take(self._balls, some)
                some = some[~self._grid.hides(u, v, radius, near, t_max)]
            placed = self._groups.placed(self._grid, some)
            drawable = self._grid.beyond(placed.near)
            if not drawable.all():
                placed = placed.take(np.flatnonzero(drawable))
            yield from self._drawn(placed, t_max)

    def _drawn(self, placed: Projected, t_max: Floats) -> Iterator[tuple[Index, Index]]:
        """The pairs of some primitives."""
        grid, grown = self._grid, placed.grown
        (left, right), (bottom, top) = _ends(placed.u, grown), _ends(placed.v, grown)
        first, count = grid.rows(bottom, top)
        in_first = grid.run(first, left, right)[1]
        some = np.flatnonzero((count > 1) | (count == 1) & (in_first > 0))
        placed, first, count = placed.take(some), first.take(some), count.take(some)
        outlines = _Outlines.of(placed)
        for one in _pieces(count, _ROWS):
            row = _each(first[one], count[one])
            which = np.repeat(np.arange(one.start, one.stop), count[one])
            left, right = outlines.within(*grid.band(row), which)
            at, many = grid.run(row, left, right)
            some = np.flatnonzero(many > 0)
            at, many, which = at.take(some), many.take(some), which.take(some)
            left, right = left.take(some), right.take(some)
            for few in _pieces(many, _PAIRS):
                run = np.repeat(np.arange(few.start, few.stop), many[few])
                rays, drawn = grid.rays(_each(at[few], many[few])), which.take(run)
                u = grid.u.take(rays)
                over = (left.take(run) <= u) & (u <= right.take(run))
                over &= placed.far.take(drawn) >= grid.earliest.take(rays)
                over &= placed.near.take(drawn) <= grid.latest(t_max, rays)
                some = np.flatnonzero(over)
                yield rays.take(some), placed.which.take(drawn.take(some))


@dataclass(frozen=True, eq=False)
class _Outlines:
    """Grown triangles of a grid: their vertices by v, and the slopes of u from one to another.

    Attributes
    ----------
    grown : (k,) float64
    u0, u1, v0, v1, v2 : (k,) float64
    slope, lower, upper : (k,) float64
        From the first vertex to the last, from the first to the second, from the second to the
        last; 0 where v is the same: such a triangle is seen edge-on, and grown by its length.
    """

    grown: Floats
    u0: Floats
    u1: Floats
    v0: Floats
    v1: Floats
    v2: Floats
    slope: Floats
    lower: Floats
    upper: Floats

    @classmethod
    def of(cls, placed: Projected) -> _Outlines:
        """The outlines of triangles."""
        u, v = list(placed.u), list(placed.v)
        for i, j in ((0, 1), (1, 2), (0, 1)):
            swap = v[i] > v[j]
            for c in (u, v):
                c[i], c[j] = np.where(swap, c[j], c[i]), np.where(swap, c[i], c[j])
        (u0, u1, u2), (v0, v1, v2) = u, v
        slopes = (_slope(u2 - u0, v2 - v0), _slope(u1 - u0, v1 - v0), _slope(u2 - u1, v2 - v1))
        return cls(placed.grown, u0, u1, v0, v1, v2, *slopes)

    def within(self, bottom: Floats, top: Floats, which: Index) -> tuple[Floats, Floats]:
        """The least and the largest u, (p,), of some of them, in a band of v each."""
        grown, first, second = self.grown.take(which), self.v0.take(which), self.v1.take(which)
        last = self.v2.take(which)
        low = np.minimum(np.maximum(bottom - grown, first), last)
        high = np.minimum(np.maximum(top + grown, first), last)
        u, slope = self.u0.take(which), self.slope.take(which)
        ends = [u + (low - first) * slope, u + (high - first) * slope]
        low -= second
        high -= second
        u, lower, upper = self.u1.take(which), self.lower.take(which), self.upper.take(which)
        ends += [u + v * np.where(v < 0, lower, upper) for v in (low, high)]
        ends += [np.where((low <= 0) & (high >= 0), u, ends[0])]
        return _ends(ends, grown)


def _ends(x: Floats | list[Floats], grown: Floats) -> tuple[Floats, Floats]:
    """The least and the largest of several x, (·, k), and a little more."""
    return reduce(np.minimum, x) - grown, reduce(np.maximum, x) + grown


def _slope(du: Floats, dv: Floats) -> Floats:
    return np.divide(du, dv, out=np.zeros_like(du), where=dv > NOTHING)


def _each(first: Index, count: Index) -> Index:
    """Of runs of numbers, by their first and their lengths, all the numbers."""
    end = np.cumsum(count)
    return np.arange(end[-1] if len(end) else 0) + np.repeat(first - end + count, count)


def _pieces(count: Index, size: int) -> Iterator[slice]:
    """Slices whose counts are of so many together, or of one that has more."""
    end = np.cumsum(count)
    start = 0
    while start < len(count):
        before = end[start - 1] if start else 0
        stop = max(start + 1, int(np.searchsorted(end, before + size, side="right")))
        yield slice(start, stop)
        start = stop
