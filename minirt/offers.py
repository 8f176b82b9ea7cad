"""Culling: which primitives each ray is offered, by whatever way costs least. All offer enough."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import TypeAlias

import numpy as np

from minirt.beams import PAD, WHOLE, Beams, Rays
from minirt.bvh import Tree, visit
from minirt.geometry import Geometry, Spheres, Triangles
from minirt.picture import Picture
from minirt.raster import Drawing
from minirt.sieves import Flat, Round, Sieve
from minirt.vectors import Floats, Index, divided

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


class Offers:
    """The primitives that n rays may meet, kind by kind, near ones first.

    Parameters
    ----------
    rays : Rays
    limit : (n,) float64
        Largest t of interest for each ray; the caller may lower it between two offers.
    """

    def __init__(self, rays: Rays, limit: Floats) -> None:
        self._rays, self._limit = rays, limit

    def polygons(self, geometry: Geometry) -> Iterator[Pairs]:
        """Pairs of a ray and a polygon."""
        tree = geometry.polygon_tree
        sieve = Flat(lambda: geometry.polygon_patches, self._pad(tree), self._limit)
        yield from self._any(len(geometry.polygons), tree, sieve)

    def spheres(self, spheres: Spheres) -> Iterator[Pairs]:
        """Pairs of a ray and a sphere."""
        sieve = Round(spheres.center, spheres.radius, self._limit)
        yield from self._drawn(spheres, len(spheres.radius), sieve)

    def triangles(self, triangles: Triangles) -> Iterator[Pairs]:
        """Pairs of a ray and a triangle."""
        sieve = Flat(lambda: triangles.patches, self._pad(triangles.tree), self._limit)
        yield from self._drawn(triangles, len(triangles.object), sieve)

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
        rays, reach, moved = self._rays, max(kind.tree.reach, self._magnitude), 0.0
        if rays.P0.strides[1] != 0 and rays.d.strides[1] != 0:
            low, high = rays.P0.min(axis=1), rays.P0.max(axis=1)
            with np.errstate(invalid="ignore"):  # not finite
                moved = float((high - low).sum())
            if not moved <= _POINT * np.median(kind.groups.radius):
                return None
            point = ((low + high) / 2)[:, None]
            rays = Rays(np.broadcast_to(point, rays.P0.shape), rays.d, rays.t0)
        return Picture.of(rays, PAD * reach + moved, reach)

    @cached_property
    def _magnitude(self) -> float:
        """The largest coordinate of any origin."""
        return float(np.fmax.reduce(np.abs(self._rays.P0), axis=None, initial=0.0))

    def _pad(self, tree: Tree) -> float:
        """What primitives and their boxes grow by."""
        return PAD * max(tree.reach, self._magnitude)

    def _any(self, m: int, tree: Tree, sieve: Sieve) -> Iterator[Pairs]:
        """All m of a kind, by their tree if they are many."""
        if m <= _FEW:
            return self._few(np.arange(m), sieve)
        return self._sifted(visit(tree, self._rays.beams, self._limit, self._pad(tree)), sieve)

    def _few(self, primitives: Index, sieve: Sieve) -> Iterator[Pairs]:
        """Few primitives: offered block by block, or to crowds of rays where many blocks meet."""
        if not len(primitives):
            return iter(())
        rays = self._rays
        meet = sieve.blocks(rays.blocks, primitives)
        if meet.mean() <= _SPARSE:
            some, which = np.nonzero(meet)
            beams = Beams(rays, np.arange(0, len(self._limit), WHOLE), WHOLE)
            return self._sifted([(beams, which, primitives.take(some))], sieve)
        of_one = np.zeros(len(primitives), dtype=np.intp)
        crowds = ((crowd, of_one, primitives) for crowd in rays.crowds(_CROWD))
        return self._sifted(crowds, sieve)

    def _sifted(self, pairs: Iterable[tuple[Beams, Index, Index]], sieve: Sieve) -> Iterator[Pairs]:
        """Of beams and the primitives that they may meet, rays and those that they may."""
        for beams, which, primitives in pairs:
            step = max(1, _PAIRS // beams.size) if beams.size > 1 else _SINGLE
            for start in range(0, len(which), step):
                some = slice(start, start + step)
                may_meet = sieve.rays(beams, which[some], primitives[some])
                offered = np.flatnonzero(np.broadcast_to(may_meet, (len(may_meet), beams.size)))
                pair, at = divided(offered, beams.size)
                yield beams.numbers(which[some].take(pair), at), primitives[some].take(pair)
