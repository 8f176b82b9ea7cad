"""Rays that leave one point, or all go one way, as the points of a grid."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from minirt.culling.packets import PAD, Rays
from minirt.vectors import Bools, Floats, Index, cross, dot, norm, unit

#: Rays that are worth a grid.
_LEAST = 256
#: Cells of a row for each of its rays, and lines for each row that is looked for.
_FINE = 4
#: Rays along each side of a block, and blocks along each side of a grid at most.
_BLOCK, _BLOCKS = 8, 256
#: Lines, and cells of a row, at most.
_MANY = 2**15
#: Slopes beyond which rays do not keep together.
_STEEP = 16.0
#: Share of the largest number in play within which things are too close.
_CLOSE = 2.0**-16
#: A length that is none: nothing is divided by less.
NOTHING = 1e-250


class RayGrid:
    """n rays P0 + t·d, t ≥ t0 ≥ 0, as points (u, v).

    Space has coordinates (x, y, depth) along `frame`, from `origin`. If the rays leave one point,
    or nearly, (u, v) is (x, y)/depth; if they are parallel, (x, y). The points are sorted into
    rows of nearly equal v, of equal v if they are those of pixels, and along a row into cells.

    Parameters
    ----------
    rays : Rays
    frame : (3, 3) float64
        Unit vectors at right angles.
    origin : (3, 1) float64
    central : bool
        Whether the rays leave one point.
    pad : float
        How far from a ray something may be that it still meets.
    close : float
        Depth up to which things are too close to be projected.

    Attributes
    ----------
    sound : bool
        Whether all rays go ahead, at no steep slopes; of others nothing else may be asked.
    u : (n,) float64
    earliest : (n,) float64
        Depth of each ray's start.
    """

    def __init__(
        self, rays: Rays, frame: Floats, origin: Floats, central: bool, pad: float, close: float
    ) -> None:
        self.frame, self.origin, self.central = frame, origin, central
        self.pad, self.close = pad, close
        with np.errstate(all="ignore"):  # not sound
            x, y, self._speed = frame @ rays.d
            if central:
                self._begin = np.zeros(1)
                self.u, self._v = x / self._speed, y / self._speed
            else:
                self.u, self._v, self._begin = frame @ (rays.P0 - origin)
            self.earliest = self._begin + self._speed * rays.t0
            low, high = ((f(self.u), f(self._v)) for f in (np.min, np.max))
            self._slope = float(np.abs([low, high]).max()) if central else 0.0
            # |u·ε_z − ε_x| ≤ √(1 + u²)·|ε|
            self._stretch = (1.0 + self._slope**2) ** 0.5 * (1.0 + PAD)
            self._low, self._size = np.array(low), np.array(high) - low
        finite = np.isfinite(self._size).all() and np.isfinite(self.earliest).all()
        self.sound = bool(finite and (self._speed > 0).all() and self._slope < _STEEP)
        if self.sound:
            self._sort()

    @classmethod
    def of(cls, rays: Rays, pad: float, reach: float) -> RayGrid | None:
        """The grid of rays that have one, among things of that largest coordinate magnitude."""
        P0, d = rays.P0, rays.d
        if P0.shape[1] < _LEAST or not (rays.t0 >= 0).all():
            return None
        central = P0.strides[1] == 0
        if central:
            origin = P0[:, :1]
            along, ahead = _screen(d)
        elif d.strides[1] == 0:
            low, high = P0.min(axis=1, keepdims=True), P0.max(axis=1, keepdims=True)
            origin = (low + high) / 2
            along, ahead = high - low, unit(d[:, :1])
        else:
            return None
        grid = cls(rays, _frame(along, ahead), origin, central, pad, _CLOSE * reach)
        return grid if grid.sound else None

    def __len__(self) -> int:
        return len(self._speed)

    def _sort(self) -> None:
        """Into rows, and along them into cells.

        Rows are looked for among lines finer than they are, empty ones left out; where that finds
        too many, lines are made as high as rows should be.
        """
        side = self._along(1)
        for self._lines in (_FINE * side, side):
            line = self._line(self._v)
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
        first, v = self._before[: -1 : self._cells], self._v.take(self._order)
        self._bottom, self._top = np.minimum.reduceat(v, first), np.maximum.reduceat(v, first)

    def _along(self, axis: int) -> int:
        """About how many rays there are along u (0) or v (1), if they are spread evenly."""
        this, other = float(self._size[axis]), float(self._size[1 - axis])
        if min(this, other) > NOTHING:
            return int(min(max(1.0, (len(self) * this / other) ** 0.5), _MANY // _FINE))
        return 1 if this <= NOTHING else min(len(self), _MANY // _FINE)

    def _line(self, v: Floats, low: int = 0, high: int = _MANY) -> Index:
        return _number(v, self._low[1], self._size[1], self._lines, low, high)

    def _cell(self, u: Floats, low: int = 0, high: int = _MANY) -> Index:
        return _number(u, self._low[0], self._size[0], self._cells, low, high)

    def points(self, X: Floats) -> tuple[Floats, Floats, Floats]:
        """u, v and depth (k,) of points X (3, k); u and v of nothing where they are not ahead."""
        x, y, depth = self.frame @ (X - self.origin)
        if not self.central:
            return x, y, depth
        with np.errstate(all="ignore"):
            return x / depth, y / depth, depth

    def beyond(self, depth: Floats) -> Bools:
        """Whether things from that depth (k,) on can be drawn."""
        return depth > self.close if self.central else np.ones(depth.shape, dtype=np.bool_)

    def seen_size(self, length: Floats, depth: Floats) -> Floats:
        """How far from a point's (u, v), (k,), a ray's may be that passes within a length of it.

        +inf where the point is not `beyond`.
        """
        size: Floats = length * self._stretch
        if self.central:
            beyond = self.beyond(depth)
            size = np.divide(size, depth, out=np.full_like(size, np.inf), where=beyond)
        return size

    def grazes(self, X: Floats, N: Floats, far: Floats, sine: float) -> Bools:
        """Whether rays may meet, by a depth, planes at an angle of less than that sine, (k,).

        Parameters
        ----------
        X, N : (3, k) float64
            A point of each plane and its unit normal, good to six digits.
        far : (k,) float64
        sine : float
        """
        if self.central:
            distance, farthest = dot(N, X - self.origin), (1.0 + 2.0 * self._slope) * far
        else:
            distance, farthest = self.frame[2] @ N, np.ones(N.shape[1])
        grazing: Bools = np.abs(distance) <= 1.01 * sine * farthest
        return grazing

    def shows(self, u: Floats, v: Floats, radius: Floats) -> Bools:
        """Whether squares, (k,) by their middles and half sides, reach into the grid."""
        outside = np.zeros(u.shape, dtype=np.bool_)
        for x, low, size in zip((u, v), self._low, self._size, strict=True):
            outside |= (x + radius < low) | (x - radius > low + size)
        return ~outside

    def hides(self, u: Floats, v: Floats, radius: Floats, near: Floats, t_max: Floats) -> Bools:
        """Whether no ray gets as far as squares by t = t_max (n,).

        Parameters
        ----------
        u, v, radius, near : (k,) float64
            The squares' middles, half sides and least depths.
        t_max : (n,) float64
        """
        return self._blocks.hidden(u, v, radius, near, self._begin + self._speed * t_max)

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
        begin = self._begin if self.central else self._begin.take(rays)
        depth: Floats = begin + self._speed.take(rays) * t_max.take(rays)
        return depth

    @cached_property
    def _blocks(self) -> _Blocks:
        shape = [min(max(1, self._along(axis) // _BLOCK), _BLOCKS) for axis in (0, 1)]
        return _Blocks(self.u, self._v, self._low, self._size, shape)


def _frame(along: Floats, ahead: Floats) -> Floats:
    """Three unit vectors as rows, at right angles: about along, and ahead (3, 1) of length one.

    Where `along` says next to nothing but `ahead`, the axis that is most across does.
    """
    across = along - dot(along, ahead) * ahead
    if not norm(across)[0] > 2.0**-10 * norm(along)[0]:
        across = np.zeros((3, 1))
        across[np.abs(ahead).argmin()] = 1.0
    for _ in range(2):  # the second time for the digits that the first has cancelled
        across = unit(across - dot(across, ahead) * ahead)
    return np.concatenate((across, cross(ahead, across), ahead), axis=1).T


def _screen(d: Floats) -> tuple[Floats, Floats]:
    """Vectors (3, 1) along a row of the screen that d (3, n) end on, and straight toward it.

    If there is no such screen, one across their mean.
    """
    along = d[:, 1:2] - d[:, :1]
    ahead = unit(cross(along, d[:, -1:] - d[:, :1]))
    distance = dot(ahead, d)
    if not np.ptp(distance) <= PAD * np.abs(distance[0]):
        return along, unit(unit(d).sum(axis=1, keepdims=True))
    return along, np.copysign(1.0, distance[0]) * ahead


class _Blocks:
    """A grid's points in about square blocks: what lies behind all of a block's is hidden."""

    def __init__(self, u: Floats, v: Floats, low: Floats, size: Floats, shape: list[int]) -> None:
        self._low, self._size, self._shape = low, size, shape
        number = self._place(1, v) * shape[0] + self._place(0, u)
        self._order = _sorted(number)
        count = np.bincount(number, minlength=shape[0] * shape[1])
        self._filled = np.flatnonzero(count)
        self._first = (np.cumsum(count) - count)[self._filled]

    def _place(self, axis: int, x: Floats) -> Index:
        many = self._shape[axis]
        return _number(x, self._low[axis], self._size[axis], many, 0, many - 1)

    def hidden(self, u: Floats, v: Floats, radius: Floats, near: Floats, depth: Floats) -> Bools:
        """Whether squares (k,) begin behind the depths (n,) of all points of their blocks.

        Of squares that lie in more than two blocks along a side, nothing is said.
        """
        ends = np.full(self._shape[0] * self._shape[1], -np.inf)
        ends[self._filled] = np.maximum.reduceat(depth.take(self._order), self._first)
        left, right = self._place(0, u - radius), self._place(0, u + radius)
        bottom, top = self._place(1, v - radius), self._place(1, v + radius)
        far = np.full(len(u), -np.inf)
        for row in (bottom, top):
            for column in (left, right):
                np.maximum(far, ends.take(row * self._shape[0] + column), out=far)
        hidden: Bools = (right - left < 2) & (top - bottom < 2) & (near > far)
        return hidden


def _number(x: Floats, low: float, size: float, many: int, least: int, most: int) -> Index:
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
