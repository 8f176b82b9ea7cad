"""Culling: which primitives each ray is offered, by whatever way costs least. All offer enough."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TypeAlias

import numpy as np

from minirt.beams import PAD, Beams, Rays
from minirt.bvh import GRAZING, Patches, Tree, may_cross, may_touch, visit
from minirt.geometry import Geometry, Spheres, Triangles
from minirt.picture import Picture
from minirt.raster import Drawing, Groups
from minirt.vectors import Bools, Floats, Index

#: Ray–primitive pairs in one pass: the temporaries then stay in a few megabytes.
_PAIRS = 65_536
#: Primitives of a kind that are not worth a tree, and rays that they are offered to together.
_FEW, _CROWD = 32, 16_384

#: Share of the largest number in play within which origins are one point.
_POINT = 2.0**-16

#: Pairs (p,) of a ray and a primitive, by number.
Pairs: TypeAlias = tuple[Index, Index]
#: Of beams, numbers of beams and of primitives: whether each ray may meet them, (p, s).
_Sieve: TypeAlias = Callable[[Beams, Index, Index], Bools]


@dataclass(frozen=True)
class _View:
    """A kind's tree, and the rays as it sees them.

    Attributes
    ----------
    tree : Tree
    rays : Rays
    moved : float
        By how much their origins may be beside the true ones.
    reach : float
        Largest coordinate magnitude in play.
    """

    tree: Tree
    rays: Rays
    moved: float
    reach: float

    @property
    def pad(self) -> float:
        """What primitives and their boxes grow by."""
        return PAD * self.reach + self.moved


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
        view = self._view(geometry.polygon_tree)
        sieve = self._flat(lambda: geometry.polygon_patches, view)
        yield from self._any(len(geometry.polygons), view, sieve)

    def spheres(self, spheres: Spheres) -> Iterator[Pairs]:
        """Pairs of a ray and a sphere."""
        view = self._view(spheres.tree)
        sieve = partial(may_touch, spheres.center, spheres.radius + view.moved)
        yield from self._drawn(len(spheres.radius), lambda: spheres.groups, view, sieve)

    def triangles(self, triangles: Triangles) -> Iterator[Pairs]:
        """Pairs of a ray and a triangle."""
        view = self._view(triangles.tree)
        sieve = self._flat(lambda: triangles.patches, view)
        yield from self._drawn(len(triangles.object), lambda: triangles.groups, view, sieve)

    def _view(self, tree: Tree) -> _View:
        """The rays as a kind's culling sees them: from one point if they nearly leave one."""
        reach = max(tree.reach, self._magnitude)
        if self._rays.P0.strides[1] != 0 and 0 <= self._spread <= _POINT * reach:
            return _View(tree, self._from_one_point, self._spread, reach)
        return _View(tree, self._rays, 0.0, reach)

    @cached_property
    def _ends(self) -> Floats:
        """Least and largest coordinates of P0, (2, 3)."""
        P0 = self._rays.P0
        P0 = P0[:, :1] if P0.strides[1] == 0 else P0
        return np.stack((P0.min(axis=1, initial=np.inf), P0.max(axis=1, initial=-np.inf)))

    @cached_property
    def _spread(self) -> float:
        with np.errstate(invalid="ignore"):  # not finite: no point
            return float((self._ends[1] - self._ends[0]).sum())

    @cached_property
    def _magnitude(self) -> float:
        return float(np.fmax.reduce(np.abs(self._rays.P0), axis=None, initial=0.0))

    @cached_property
    def _from_one_point(self) -> Rays:
        point = self._ends.mean(axis=0)[:, None]
        rays = self._rays
        return Rays(np.broadcast_to(point, rays.P0.shape), rays.d, rays.t0)

    def _flat(self, patches: Callable[[], Patches], view: _View) -> _Sieve:
        """The sieve of flat primitives, whose patches are only asked for when it is used.

        A plane is crossed elsewhere by as much as the origin is moved, over the angle's sine.
        """
        pad = view.pad + 1.01 / GRAZING * view.moved
        return lambda beams, which, primitives: may_cross(
            patches(), beams, which, primitives, pad, self._limit
        )

    def _drawn(
        self, m: int, groups: Callable[[], Groups], view: _View, sieve: _Sieve
    ) -> Iterator[Pairs]:
        """All m of a kind, drawn over the rays' picture if they have one and it pays."""
        picture = Picture.of(view.rays, view.pad, view.reach) if m > _FEW else None
        drawing = None if picture is None else Drawing(picture, groups())
        if drawing is None or not drawing.worth:
            yield from self._any(m, view, sieve)
        else:
            yield from self._few(drawing.close, view, sieve)
            yield from drawing.pairs(self._limit)

    def _any(self, m: int, view: _View, sieve: _Sieve) -> Iterator[Pairs]:
        """All m of a kind, by their tree if they are many."""
        if m <= _FEW:
            return self._few(np.arange(m), view, sieve)
        return self._sifted(visit(view.tree, view.rays.beams, self._limit, view.pad), sieve)

    def _few(self, primitives: Index, view: _View, sieve: _Sieve) -> Iterator[Pairs]:
        """Few primitives, offered to crowds of rays."""
        if not len(primitives):
            return iter(())
        of_one = np.zeros(len(primitives), dtype=np.intp)
        crowds = ((crowd, of_one, primitives) for crowd in view.rays.crowds(_CROWD))
        return self._sifted(crowds, sieve)

    def _sifted(
        self, pairs: Iterator[tuple[Beams, Index, Index]], sieve: _Sieve
    ) -> Iterator[Pairs]:
        """Of beams and the primitives that they may meet, rays and those that they may."""
        for beams, which, primitives in pairs:
            step = max(1, _PAIRS // beams.size)
            for start in range(0, len(which), step):
                some = slice(start, start + step)
                may_meet = sieve(beams, which[some], primitives[some])
                offered = np.flatnonzero(np.broadcast_to(may_meet, (len(may_meet), beams.size)))
                pair, at = np.divmod(offered, beams.size)
                yield beams.index[which[some][pair], at], primitives[some][pair]
