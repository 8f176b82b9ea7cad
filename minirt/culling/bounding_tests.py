"""Culling: whether rays may meet a primitive, told of blocks of them at once and ray by ray."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np

from minirt.culling.packets import PAD, Blocks, Packets
from minirt.vectors import Bools, Floats, Index, dot, take

#: Sine of the angle below which a plane's crossing is not trusted to cull.
GRAZING = 2.0**-8


class BoundingTest(ABC):
    """The primitives of a kind, a little larger than they are, and rays up to t = t_max (n,).

    The caller may lower the t_max between two calls.
    """

    @abstractmethod
    def blocks(self, blocks: Blocks, primitives: Index) -> Bools:
        """Whether any ray of each block may meet primitives (k,), (k, b)."""

    def filled(self, blocks: Blocks, which: Index, primitives: Index) -> Bools:
        """Whether nearly all rays of blocks that may meet primitives will, pair by pair, (p,).

        Only a hint that it does not pay to ask each ray; none is given here.
        """
        return np.zeros(len(which), dtype=np.bool_)

    @abstractmethod
    def rays(self, packets: Packets, which: Index, primitives: Index) -> Bools:
        """Whether rays of packets may meet primitives, pair by pair, (p, s) or (p, 1).

        Parameters
        ----------
        packets : Packets
        which, primitives : (p,) intp
        """


class SphereBoundingTest(BoundingTest):
    """Spheres by their centres (3, m) and radii (m,): all depends on C − P0, as in the kernel."""

    def __init__(self, center: Floats, radius: Floats, t_max: Floats) -> None:
        self._center, self._radius, self._t_max = center, radius, t_max

    def blocks(self, blocks: Blocks, primitives: Index) -> Bools:
        """Whether the middle ray passes within R of the centre, grown by how far others stray.

        At t they are within aside + t·turn of it, and they touch the sphere by t = distance/‖d‖,
        of the farthest point of the sphere from the farthest origin.
        """
        L = take(self._center, primitives)[:, :, None] - blocks.P0[:, None]
        R = self._radius.take(primitives)[:, None] + blocks.aside
        LL, b = dot(L, L), dot(L, blocks.d[:, None])
        away = np.sqrt(LL)
        with np.errstate(all="ignore"):  # not together
            missed: Bools = (away * (1 - PAD) - R) > blocks.latest(self._t_max) * blocks.fastest
            R = R + blocks.turn / blocks.slowest * (away * (1 + PAD) + R)
            apart = LL * (1 - PAD) - R * R * (1 + PAD)
            missed |= (apart > 0) & ((b < 0) | (b * b < blocks.squared * apart))
        return ~missed

    def filled(self, blocks: Blocks, which: Index, primitives: Index) -> Bools:
        """Whether the middle ray passes within R of the centre, shrunk by how far others stray."""
        P0, d, squared, aside, turn, slowest = blocks.of(
            which, blocks.P0, blocks.d, blocks.squared, blocks.aside, blocks.turn, blocks.slowest
        )
        L, R = take(self._center, primitives) - P0, self._radius.take(primitives)
        LL, b = dot(L, L), dot(L, d)
        with np.errstate(all="ignore"):  # not together
            R = R - aside - turn / slowest * (np.sqrt(LL) + R)
            within: Bools = (R > 0) & (b * b > squared * (LL - R * R))
        return within

    def rays(self, packets: Packets, which: Index, primitives: Index) -> Bools:
        """Δ ≥ 0 by products that round as they like.

        Their terms are at most (‖P0‖ + ‖C‖)² and R², or ‖C − P0‖² and R² where all rays leave one
        point, and err by some ten roundings; the pad is a thousand times that.
        """
        d, aa = packets.of(which, packets.d, packets.squared)
        L, radius = take(self._center, primitives).T[:, None], self._radius[primitives, None]
        if packets.one_point:
            L = L - packets.P0[:1, :, 0]
        LL = (L * L).sum(axis=2) * (1 - PAD) - radius * radius * (1 + PAD)
        b = (L @ d)[:, 0]
        if not packets.one_point:
            P0, ahead, size = packets.of(
                which, packets.P0, packets.toward_origin, packets.from_origin
            )
            b = b + ahead
            LL = size * (1 - PAD) - 2.0 * (L @ P0)[:, 0] + LL
        b *= b
        missed: Bools = b < aa * LL
        np.logical_not(missed, out=missed)
        return missed


class PlaneBoundingTest(BoundingTest):
    """PlaneBoundingTest primitives by their planes and sides, grown by a pad.

    Parameters
    ----------
    patches : callable
        Gives (m, 1 + e, 4) float64: of each primitive, the unit normal N of its plane
        X·N = offset, and the offset; and of its sides unit vectors along the plane, inward, of
        which X·side is no less than the fourth number in the primitive; zero where a side is not
        told. Called when first needed.
    """

    def __init__(self, patches: Callable[[], Floats], pad: float, t_max: Floats) -> None:
        self._patches, self._pad, self._t_max = patches, pad, t_max

    def blocks(self, blocks: Blocks, primitives: Index) -> Bools:
        """Intervals that hold what `rays` computes of each ray, unless some graze the plane.

        Crossings behind the origin, up to the pad, are taken to be there: the pad counts twice.
        """
        planes = self._patches().take(primitives, axis=0)
        along = planes[:, :, :3] @ blocks.d
        ahead = planes[:, :, 3:] - planes[:, :, :3] @ blocks.P0
        turn, slack = blocks.turn, blocks.aside + 2.0 * self._pad
        with np.errstate(all="ignore"):  # not together, or grazing
            slope, gap = np.abs(along[:, 0]), np.copysign(1.0, along[:, 0]) * ahead[:, 0]
            least, most = slope - turn, slope + turn
            first, last = gap - slack, gap + slack
            first = np.maximum(np.minimum(first / least, first / most), 0.0)
            last = np.maximum(last / least, last / most)
            missed = (last < 0) | (first * (1 - PAD) > blocks.latest(self._t_max))
            for k in range(1, planes.shape[1]):
                side, needed = along[:, k] + turn, ahead[:, k] - slack
                missed |= np.maximum(first * side, last * side) < needed
        missed &= least > GRAZING * blocks.fastest
        return ~missed

    def rays(self, packets: Packets, which: Index, primitives: Index) -> Bools:
        """The sides and the interval are grown by the pad.

        The crossings come from matrix products, which round as they like: some 2⁻⁴⁴ of the largest
        coordinate in play at the angles where culling is done, less than the pad, unless the plane
        is met at a small angle; there the answer is yes.
        """
        planes = self._patches().take(primitives, axis=0)
        if packets.size == 1:
            return self._singly(planes, packets, which)
        P0, d, length, t0, index = packets.of(
            which, packets.P0, packets.d, packets.length, packets.t0, packets.index
        )
        along, ahead = planes[:, :, :3] @ d, planes[:, :, 3:] - planes[:, :, :3] @ P0
        steep = np.abs(along[:, 0]) > GRAZING * length
        t = ahead[:, 0] / np.where(steep, along[:, 0], 1.0)
        slack = self._pad / length
        within: Bools = (t >= t0 - slack) & (t <= self._t_max[index] + slack)
        ahead -= self._pad
        for k in range(1, planes.shape[1]):
            within &= t * along[:, k] >= ahead[:, k]
        within |= ~steep
        return within

    def _singly(self, planes: Floats, packets: Packets, which: Index) -> Bools:
        """`rays` of packets of one ray, (p, 1): products with one column each cost too much."""
        numbers = packets.table.take(which, axis=0).T
        P0, d, t0, length = numbers[:3], numbers[3:6], numbers[6], numbers[7]
        N, offset = planes[:, 0, :3].T, planes[:, 0, 3]
        slope = dot(N, d)
        steep = np.abs(slope) > GRAZING * length
        t = (offset - dot(N, P0)) / np.where(steep, slope, 1.0)
        slack, latest = self._pad / length, self._t_max.take(packets.index[:, 0].take(which))
        within: Bools = (t >= t0 - slack) & (t <= latest + slack)
        for k in range(1, planes.shape[1]):
            side = planes[:, k, :3].T
            within &= t * dot(side, d) >= planes[:, k, 3] - self._pad - dot(side, P0)
        within |= ~steep
        return within[:, None]
