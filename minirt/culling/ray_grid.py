"""Rays that leave one point, or all go one way, as the points of a grid."""

from __future__ import annotations

import numpy as np

from minirt.culling.projection import NOTHING, Projection, axes_of
from minirt.rays import Rays
from minirt.vectors import Bools, Floats, Index

#: Rays that are worth a grid.
_LEAST = 256
#: Cells of a row for each of its rays, and lines for each row that is looked for.
_FINE = 4
#: Lines, and cells of a row, at most.
_MANY = 2**15
#: Slopes beyond which rays do not keep together.
_STEEP = 16.0
#: Share of the largest number in play within which things are too close.
_CLOSE = 2.0**-16


class RayGrid:
    """n rays P0 + t·d, t ≥ t0 ≥ 0, as points (u, v) of a projection.

    The points are sorted into rows of nearly equal v, of equal v if they are those of pixels, and
    along a row into cells.

    Parameters
    ----------
    projection : Projection
    u, v : (n,) float64
    begin : (n,) or (1,) float64
        Depth of each ray's origin.
    speed : (n,) float64
        Depth of each ray's d.
    t0 : (n,) or (1,) float64

    Attributes
    ----------
    low, size : (2,) float64
        The least u and v, and what u and v span.
    earliest : (n,) float64
        Depth of each ray's start.
    """

    def __init__(
        self, projection: Projection, u: Floats, v: Floats, begin: Floats, speed: Floats, t0: Floats
    ) -> None:
        self.projection, self.u, self.v, self.begin, self.speed = projection, u, v, begin, speed
        self.earliest = begin + speed * t0
        self.low = np.array([u.min(), v.min()])
        self.size = np.array([u.max(), v.max()]) - self.low
        self._sort()

    def __len__(self) -> int:
        return len(self.speed)

    def _sort(self) -> None:
        """Into rows, and along them into cells.

        Rows are looked for among lines finer than they are, empty ones left out; where that finds
        too many, lines are made as high as rows should be.
        """
        side = self.along(1)
        for self._lines in (_FINE * side, side):
            line = self._line(self.v)
            filled = np.bincount(line, minlength=self._lines) > 0
            rows = int(filled.sum())
            if rows <= 1.5 * side:
                break
        self._rows_before = np.cumsum(np.append(0, filled))
        self._cells = min(_FINE * max(1, len(self) // rows), _MANY)
        row, cell = self._rows_before.take(line), self._cell(self.u)
        number = row * self._cells + cell
        self._order = _sorted(row)
        if (np.diff(number.take(self._order)) < 0).any():
            order = _sorted(cell)
            self._order = order.take(_sorted(row.take(order)))
        self._before = np.cumsum(np.append(0, np.bincount(number, minlength=rows * self._cells)))
        first, v = self._before[: -1 : self._cells], self.v.take(self._order)
        self._bottom, self._top = np.minimum.reduceat(v, first), np.maximum.reduceat(v, first)

    def along(self, axis: int) -> int:
        """About how many rays there are along u (0) or v (1), if they are spread evenly."""
        this, other = float(self.size[axis]), float(self.size[1 - axis])
        if min(this, other) > NOTHING:
            return int(min(max(1.0, (len(self) * this / other) ** 0.5), _MANY // _FINE))
        return 1 if this <= NOTHING else min(len(self), _MANY // _FINE)

    def _line(self, v: Floats, low: int = 0, high: int = _MANY) -> Index:
        return numbered(v, self.low[1], self.size[1], self._lines, low, high)

    def _cell(self, u: Floats, low: int = 0, high: int = _MANY) -> Index:
        return numbered(u, self.low[0], self.size[0], self._cells, low, high)

    def shows(self, u: Floats, v: Floats, radius: Floats) -> Bools:
        """Whether squares, (k,) by their middles and half sides, reach into the grid."""
        outside = np.zeros(u.shape, dtype=np.bool_)
        for x, low, size in zip((u, v), self.low, self.size, strict=True):
            outside |= (x + radius < low) | (x - radius > low + size)
        return ~outside

    def rows(self, bottom: Floats, top: Floats) -> tuple[Index, Index]:
        """The first row (k,) that meets bottom ≤ v ≤ top, (k,) each, and how many do, if any."""
        first = self._rows_before.take(self._line(bottom, 0, self._lines))
        end = self._rows_before.take(self._line(top, -1, self._lines - 1) + 1)
        return np.minimum(first, len(self._bottom) - 1), end - first

    def band(self, rows: Index) -> tuple[Floats, Floats]:
        """The least and the largest v of rows (k,)."""
        return self._bottom.take(rows), self._top.take(rows)

    def run(self, rows: Index, left: Floats, right: Floats) -> tuple[Index, Index]:
        """Those of the rows' points that have left ≤ u ≤ right, and a few beside them.

        Returns
        -------
        first, count : (k,) intp
            Places in the grid's order: see `rays`.
        """
        base = rows * self._cells
        first = self._before.take(base + self._cell(left, 0, self._cells))
        end = self._before.take(base + self._cell(right, -1, self._cells - 1) + 1)
        return first, end - first

    def rays(self, places: Index) -> Index:
        """The numbers of the rays at places of the grid's order."""
        return self._order.take(places)

    def latest(self, t_max: Floats, rays: Index) -> Floats:
        """The depth (k,) of some rays (k,) at t = t_max (n,)."""
        begin = self.begin if self.projection.central else self.begin.take(rays)
        depth: Floats = begin + self.speed.take(rays) * t_max.take(rays)
        return depth


def grid_of(rays: Rays, pad: float, reach: float) -> RayGrid | None:
    """The grid of rays that all go ahead, at no steep slopes; None of others.

    Parameters
    ----------
    rays : Rays
    pad : float
        How far from a ray something may be that it still meets.
    reach : float
        The largest coordinate in play.
    """
    if rays.count < _LEAST or not (rays.t0 >= 0).all():
        return None
    with np.errstate(all="ignore"):  # not finite, or not ahead
        axes = axes_of(rays)
        if axes is None:
            return None
        (frame, origin), central = axes, rays.one_origin
        x, y, speed = frame @ rays.directions
        if central:
            u, v, begin = x / speed, y / speed, np.zeros(1)
        else:
            u, v, begin = frame @ (rays.P0 - origin)
        ends = np.array([u.min(), u.max(), v.min(), v.max()])
        slope = float(np.abs(ends).max()) if central else 0.0
        finite = np.isfinite(ends).all() and np.isfinite(begin + speed * rays.t0).all()
    if not (finite and (speed > 0).all() and slope < _STEEP):
        return None
    projection = Projection(frame, origin, central, slope, pad, _CLOSE * reach)
    return RayGrid(projection, u, v, begin, speed, rays.t0)


def numbered(x: Floats, low: float, size: float, many: int, least: int, most: int) -> Index:
    """In which of many equal parts x (k,) is; a little early, so that the end is in the last."""
    if size <= NOTHING:
        return np.zeros(x.shape, dtype=np.intp)
    scaled = (x - low) * (many * (1.0 - 2.0**-40) / size)
    np.maximum(scaled, least, out=scaled)
    np.minimum(scaled, most, out=scaled)
    return scaled.astype(np.intp)


def _sorted(numbers: Index) -> Index:
    """The order of numbers below 2¹⁶; equal ones keep theirs."""
    return np.argsort(numbers.astype(np.uint16), kind="stable")
