"""Culling: which primitives each ray is offered, by whatever way costs least. All offer enough."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import TypeAlias

import numpy as np

from minirt.culling.beams import PAD, WHOLE, Beams, Blocks, Rays
from minirt.culling.bvh import Tree, visit
from minirt.culling.picture import Picture
from minirt.culling.raster import Drawing
from minirt.culling.sieves import Flat, Round, Sieve
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
    sieves = _Sieves(geometry, np.concatenate(P0), np.full(box.shape, np.inf))
    found = np.zeros(box.shape, dtype=np.bool_)
    for sieve, m in sieves.each():
        found |= sieve.blocks(blocks, np.arange(m)).any(axis=0)
    return found


class _Sieves:
    """The sieves of a scene's kinds of primitives.

    Parameters
    ----------
    geometry : Geometry
    P0 : (…, n) float64
        Origins, in any shape.
    limit : (n,) float64
        Largest t of interest for each ray.
    """

    def __init__(self, geometry: Geometry, P0: Floats, limit: Floats) -> None:
        self._geometry, self._P0, self._limit = geometry, P0, limit

    def polygons(self) -> Sieve:
        geometry = self._geometry
        pad = self.pad(geometry.polygon_tree)
        return Flat(lambda: geometry.polygon_patches, pad, self._limit)

    def spheres(self) -> Sieve:
        spheres = self._geometry.spheres
        return Round(spheres.center, spheres.radius, self._limit)

    def triangles(self) -> Sieve:
        triangles = self._geometry.triangles
        return Flat(lambda: triangles.patches, self.pad(triangles.tree), self._limit)

    def each(self) -> Iterator[tuple[Sieve, int]]:
        """The sieve of each kind of which there is any, and how many."""
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


class Offers:
    """The primitives that n rays may meet, kind by kind, near ones first.

    Parameters
    ----------
    geometry : Geometry
    rays : Rays
    limit : (n,) float64
        Largest t of interest for each ray; the caller may lower it between two offers.
    """

    def __init__(self, geometry: Geometry, rays: Rays, limit: Floats) -> None:
        self._geometry, self._rays, self._limit = geometry, rays, limit
        self._sieves = _Sieves(geometry, rays.P0, limit)

    def polygons(self) -> Iterator[Pairs]:
        """Pairs of a ray and a polygon."""
        geometry = self._geometry
        tree = geometry.polygon_tree
        yield from self._any(len(geometry.polygons), tree, self._sieves.polygons())

    def spheres(self) -> Iterator[Pairs]:
        """Pairs of a ray and a sphere."""
        spheres = self._geometry.spheres
        yield from self._drawn(spheres, len(spheres.radius), self._sieves.spheres())

    def triangles(self) -> Iterator[Pairs]:
        """Pairs of a ray and a triangle."""
        triangles = self._geometry.triangles
        yield from self._drawn(triangles, len(triangles.object), self._sieves.triangles())

    def _drawn(self, kind: Spheres | Triangles, m: int, sieve: Sieve) -> Iterator[Pairs]:
        """All m of a kind, drawn over the rays' picture if they have one and it pays."""
        picture = self._picture(kind) if m > _FEW else None
        drawing = None if picture is None else Drawing(picture, kind.groups)
        if drawing is None or not drawing.worth:
            yield from self._any(m, kind.tree, sieve)
        else:
            yield from self._few(drawing.close, sieve)
            yield from drawing.pairs(self._limit)

    def _picture(self, kind: Spheres | Triangles) -> Picture | None:
        """The rays' picture, if they have one; as from one point if they nearly leave one."""
        rays, reach, moved = self._rays, self._sieves.reach(kind.tree), 0.0
        if rays.P0.strides[1] != 0 and rays.d.strides[1] != 0:
            low, high = rays.P0.min(axis=1), rays.P0.max(axis=1)
            with np.errstate(invalid="ignore"):  # not finite
                moved = float((high - low).sum())
            if not moved <= _POINT * np.median(kind.groups.radius):
                return None
            point = ((low + high) / 2)[:, None]
            rays = Rays(np.broadcast_to(point, rays.P0.shape), rays.d, rays.t0)
        return Picture.of(rays, PAD * reach + moved, reach)

    def _any(self, m: int, tree: Tree, sieve: Sieve) -> Iterator[Pairs]:
        """All m of a kind, by their tree if they are many."""
        if m <= _FEW:
            return self._few(np.arange(m), sieve)
        return self._sifted(
            visit(tree, self._rays.beams, self._limit, self._sieves.pad(tree)), sieve
        )

    def _few(self, primitives: Index, sieve: Sieve) -> Iterator[Pairs]:
        """Few primitives: offered to the blocks that they fill, and to rays of others they meet.

        Where many blocks are of the latter kind, crowds of rays are asked instead.
        """
        if not len(primitives):
            return
        rays, blocks = self._rays, self._rays.blocks
        meet = sieve.blocks(blocks, primitives)
        some, which = np.nonzero(meet)
        filled = sieve.filled(blocks, which, primitives.take(some))
        if len(which) - np.count_nonzero(filled) > _SPARSE * meet.size:
            of_one = np.zeros(len(primitives), dtype=np.intp)
            crowds = ((crowd, of_one, primitives) for crowd in rays.crowds(_CROWD))
            yield from self._sifted(crowds, sieve)
            return
        beams = Beams(rays, np.arange(0, len(self._limit), WHOLE), WHOLE)
        whole = np.flatnonzero(filled)
        for part in np.array_split(whole, len(whole) * WHOLE // _PAIRS + 1):
            every = WHOLE * which.take(part)[:, None] + np.arange(WHOLE)
            of_each = np.repeat(primitives.take(some.take(part)), WHOLE)
            yield self._there(every.ravel(), of_each)
        rest = np.flatnonzero(~filled)
        pairs = (beams, which.take(rest), primitives.take(some.take(rest)))
        yield from self._sifted([pairs], sieve)

    def _sifted(self, pairs: Iterable[tuple[Beams, Index, Index]], sieve: Sieve) -> Iterator[Pairs]:
        """Of beams and the primitives that they may meet, rays and those that they may."""
        for beams, which, primitives in pairs:
            step = max(1, _PAIRS // beams.size) if beams.size > 1 else _SINGLE
            for start in range(0, len(which), step):
                some = slice(start, start + step)
                may_meet = sieve.rays(beams, which[some], primitives[some])
                offered = np.flatnonzero(np.broadcast_to(may_meet, (len(may_meet), beams.size)))
                pair, at = divided(offered, beams.size)
                numbers = beams.numbers(which[some].take(pair), at)
                yield self._there(numbers, primitives[some].take(pair))

    def _there(self, rays: Index, primitives: Index) -> Pairs:
        """The pairs of rays that there are: the last block, or beam, may reach beyond them."""
        n = len(self._limit)
        if n % WHOLE == 0:
            return rays, primitives
        there = np.flatnonzero(rays < n)
        return rays.take(there), primitives.take(there)
