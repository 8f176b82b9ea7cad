"""Single rays and boxes: where each ray is within a box's three pairs of planes.

A ray opens some ten nodes of a tree, each elsewhere in memory: what that costs is the fetching. So
boxes and rays are held in single precision, around the tree's centre and in units of its size, and
each ray begins where it enters the tree; in double precision it takes 1.3 × as long (row 'mesh,
82k, no order' of the bench). Boxes grow by what that rounds; in a tree of which they are too small
a share for that, all is in double precision.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from minirt.rays import Rays
from minirt.vectors import Floats, Index

#: Numbers in double or in single precision.
Measures: TypeAlias = NDArray[np.floating[Any]]

#: What boxes of a tree of size 1 grow by, in roundings. Coordinates are within ±1: a plane, a ray's
#: point and their difference round by 2u in all. The way to a plane, at most 4 where it matters, is
#: a product of two rounded factors and errs by 8u, which is worth no more across the plane.
_ROUNDINGS = 64
#: Share of a tree that boxes need for single precision to be fine enough, and the pad, in sizes of
#: the tree, up to which its numbers do not overflow.
_FINE, _WIDEST = 2.0**-12, 2.0**40
#: Margin of the tree's own box, within which rays begin.
_MARGIN = 2.0**-10
#: 1/0, for a ray's way through a slab that it does not cross: it is farther than any box, even
#: where the plane is as near as what boxes grow by.
_NEVER = 2.0**60
#: Pairs of a ray and a box whose numbers stay in a processor's caches.
_NEARBY = 65_536
#: By octant of a direction, numbers of the three planes that a ray comes to first, and last.
_PLANES = np.array(
    [
        [axis + 3 * (octant >> axis & 1 ^ last) for last in (0, 1) for axis in range(3)]
        for octant in range(8)
    ]
)


def precision(share: float, pad: float) -> type[np.floating[Any]]:
    """What to hold a tree in: float32 if it will do.

    Parameters
    ----------
    share : float
        Of the tree's size, that of small boxes in it.
    pad : float
        What boxes grow by, in sizes of the tree.
    """
    return np.float32 if share >= _FINE and pad <= _WIDEST else np.float64


def rounding(kind: type[np.floating[Any]]) -> float:
    """What boxes of a tree of size 1 grow by, held in numbers of a kind."""
    return _ROUNDINGS * float(np.finfo(kind).epsneg)


class Slabs:
    """Where single rays are within boxes.

    A ray's ways are counted along its main axis, from where it enters the tree; it is mirrored
    where it goes back along an axis.

    Parameters
    ----------
    rays : Rays
    center : (3, 1) float64
        Of the tree.
    size : float
        Largest distance along an axis from there to any box.
    pad : float
        What boxes grow by, in scene units.
    kind : type
        What numbers are held in: see `precision`.
    """

    def __init__(
        self, rays: Rays, center: Floats, size: float, pad: float, kind: type[np.floating[Any]]
    ) -> None:
        P0, d, t0 = rays.origins, rays.directions, rays.t0
        speed = np.abs(d).max(axis=0)
        P = np.copysign(1.0, d) * (P0 - center) / size
        edge = 1.0 + _MARGIN + pad / size
        with np.errstate(all="ignore"):  # without a direction: all boxes are missed
            along = np.abs(d) / speed
            inverse = np.minimum(1.0 / along, _NEVER)
            begin = np.maximum(((-edge - P) * inverse).max(axis=0), t0 * speed / size)
            enters = begin <= ((edge - P) * inverse).min(axis=0)
            entry = P + begin * along
        entry[:, ~enters] = 0.0
        self._speed, self._begin = np.where(enters, speed / size, np.nan), begin
        self._slack, self._kind = rounding(kind) + pad / size, kind
        #: Whose square makes infinity of every positive normal number.
        self._huge = kind(2.0 ** (np.finfo(kind).maxexp - 1))
        # One ray's numbers lie together: what they cost is the fetching.
        self._numbers = np.empty((rays.count, 6), dtype=kind)
        self._numbers[:, :3], self._numbers[:, 3:] = entry.T, inverse.T
        self._octant = np.signbit(d).T @ np.array([1, 2, 4], dtype=np.int8)

    def latest(self, t_max: Floats) -> Measures:
        """Ways (n,) to the largest t of interest; none at all where the tree is missed."""
        with np.errstate(all="ignore"):
            way = t_max * self._speed
            way -= self._begin
            way += self._slack
            narrow: Measures = way.astype(self._kind)
        return narrow

    def meet(self, of: Index, boxes: Measures, nodes: Index, latest: Measures) -> Measures:
        """Where rays may enter the boxes of nodes: +inf for never, or not by the latest.

        Parameters
        ----------
        of, nodes : (p,) intp
            Numbers of rays and of nodes, pair by pair.
        boxes : (n, 6, c) float
            Of each node's children: lower corners and, negated, upper ones.
        latest : (n,) float

        Returns
        -------
        (c, p) float
        """
        planes = boxes.reshape(-1, boxes.shape[2])
        near = np.empty((boxes.shape[2], len(of)), dtype=boxes.dtype)
        step = max(1, _NEARBY // boxes.shape[2])
        for start in range(0, len(of), step):
            some = slice(start, start + step)
            with np.errstate(all="ignore"):  # without a direction
                self._meet(of[some], planes, 6 * nodes[some], latest, near[:, some])
        return near

    def _meet(
        self, which: Index, planes: Measures, base: Index, latest: Measures, near: Measures
    ) -> None:
        """`meet` for few pairs, into near (c, p)."""
        far, cut = np.empty((2, *near.shape), dtype=self._kind)
        numbers = self._numbers.take(which, axis=0).T.copy()
        rows = _PLANES.take(self._octant.take(which), axis=0).T + base
        slack = self._kind(self._slack)
        near[:] = 0.0
        far[:] = latest.take(which)
        for axis in range(3):
            P, inverse = numbers[axis], numbers[3 + axis]
            np.subtract(planes.take(rows[axis], axis=0).T, P + slack, out=cut)
            cut *= inverse
            np.maximum(near, cut, out=near)
            np.add(planes.take(rows[3 + axis], axis=0).T, P - slack, out=cut)
            cut *= -inverse
            np.minimum(far, cut, out=far)
        np.subtract(near, far, out=cut)  # +inf where that is positive, faster than by choice
        np.maximum(cut, 0.0, out=cut)
        cut *= self._huge
        cut *= self._huge
        near += cut
