"""Single rays and boxes: where each ray is within a box's three pairs of planes.

A ray without neighbours opens some ten nodes of a tree, each elsewhere in memory: what that costs
is the fetching. So boxes and rays are held in single precision, around the tree's centre and in
units of its size, and each ray begins where it enters the tree. Boxes grow by what that rounds.
"""

from __future__ import annotations

import numpy as np

from minirt.beams import Beams, Bounds, Measures
from minirt.vectors import Floats, Index

#: What boxes of a tree of size 1 grow by. Coordinates are within ±1: a plane, a ray's point and
#: their difference round by 2⁻²³ in all. The way to a plane, at most 4 where it matters, is a
#: product of two rounded factors and errs by 2⁻²¹, which is worth no more across the plane.
NARROW = 2.0**-18
#: Margin of the tree's own box, within which rays begin.
_MARGIN = 2.0**-10
#: 1/0, for a ray's way through a slab that it does not cross: it is farther than any box, even
#: where the plane is as near as what boxes grow by.
_NEVER = 2.0**60
#: Whose square makes infinity of every positive normal number.
_HUGE = np.float32(2.0**127)
#: By octant of a direction, numbers of the three planes that a ray comes to first, and last.
_PLANES = np.array(
    [
        [axis + 3 * (octant >> axis & 1 ^ last) for last in (0, 1) for axis in range(3)]
        for octant in range(8)
    ]
)


class Slabs(Bounds):
    """The bounds of single rays.

    A ray's ways are counted along its main axis, from where it enters the tree; it is mirrored
    where it goes back along an axis.

    Parameters
    ----------
    beams : Beams
        Of one ray each.
    center : (3, 1) float64
        Of the tree.
    size : float
        Largest distance along an axis from there to any box.
    pad : float
        What boxes grow by, in scene units.
    """

    def __init__(self, beams: Beams, center: Floats, size: float, pad: float) -> None:
        P0, d = beams.rows
        speed = np.abs(d).max(axis=0)
        P = np.copysign(1.0, d) * (P0 - center) / size
        edge = 1.0 + _MARGIN + pad / size
        with np.errstate(all="ignore"):  # without a direction: all boxes are missed
            along = np.abs(d) / speed
            inverse = np.minimum(1.0 / along, _NEVER)
            begin = np.maximum(((-edge - P) * inverse).max(axis=0), beams.t0[:, 0] * speed / size)
            enters = begin <= ((edge - P) * inverse).min(axis=0)
            entry = P + begin * along
        self._speed, self._begin = np.where(enters, speed / size, np.nan), begin
        self._slack = NARROW + pad / size
        # What a ray is asked for lies together: its cost is that of fetching it.
        self._numbers = np.empty((len(beams), 6), dtype=np.float32)
        self._numbers[:, :3], self._numbers[:, 3:] = entry.T, inverse.T
        self._numbers[~enters] = 0.0
        self._octant = np.signbit(d).T @ np.array([1, 2, 4], dtype=np.int8)
        self._index = beams.index[:, 0]

    def latest(self, limit: Floats) -> Measures:
        """Ways (b,) to the largest t of interest; none at all where the tree is missed."""
        way = limit.take(self._index)
        with np.errstate(all="ignore"):
            way *= self._speed
            way -= self._begin
            way += self._slack
            narrow: Measures = way.astype(np.float32)
        return narrow

    def _meet(
        self, which: Index, planes: Measures, base: Index, latest: Measures, pad: float,
        near: Measures,
    ) -> None:  # fmt: skip
        far, cut = np.empty((2, *near.shape), dtype=np.float32)
        numbers = self._numbers.take(which, axis=0).T.copy()
        rows = _PLANES.take(self._octant.take(which), axis=0).T + base
        slack = np.float32(pad)
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
        cut *= _HUGE
        cut *= _HUGE
        near += cut
