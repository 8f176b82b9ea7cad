"""Packets: consecutive rays, bounded together, so that all of them are known to miss a box."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from minirt.vectors import Floats, Index

#: Rays of a whole packet, and the number of parts that it is divided into.
PACKET, PARTS = 64, 4
#: Boxes and limits grow by this share of the largest number in play: some 4,000 times its rounding.
PAD = 2.0**-40
#: Pairs of a packet and a box whose numbers stay in a processor's caches.
_NEARBY = 65_536
#: Slopes that its rays may differ by: a wider packet meets so much that its parts cost less.
_WIDE = 0.05
#: Share of packets that keep together below which the rays of the others are taken one by one.
_RARE = 1 / 16

#: Numbers in double or in single precision.
Measures: TypeAlias = NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class Rays:
    """n rays P0 + t·d, t ≥ t0; neighbours should follow each other.

    Attributes
    ----------
    P0, d : (3, n) float64
    t0 : (n,) float64
    """

    P0: Floats
    d: Floats
    t0: Floats

    @cached_property
    def packets(self) -> list[Packets]:
        """All of them: in whole packets where they keep together, in parts of such where not."""
        n, size = self.P0.shape[1], PACKET
        first = np.arange(0, n, size)
        found: list[Packets] = []
        while len(first):
            packets = Packets(self, first, size)
            if size == 1:
                return [*found, packets]
            together = packets.span.together
            if together.all():
                return [*found, packets]
            if together.any():
                found.append(Packets(self, first[together], size))
            parts = size if together.mean() < _RARE else PARTS
            first = _parts(first[~together], size, parts)
            first, size = first[first < n], size // parts
        return found

    @cached_property
    def blocks(self) -> Blocks:
        """All of them, PACKET by PACKET."""
        first = np.arange(0, self.P0.shape[1], PACKET)
        return Blocks(first, _least_and_most(self.P0, first), _least_and_most(self.d, first))

    def crowds(self, size: int) -> Iterator[Packets]:
        """All of them in single packets of up to so many, which nothing bounds."""
        n = self.P0.shape[1]
        for first in range(0, n, size):
            yield Packets(self, np.array([first]), min(size, n - first))


class Blocks:
    """b blocks of consecutive rays, each as its middle one, and how far the others stray.

    Where a ray is not finite, its block's numbers are NaN or +inf: nothing shows that it misses.

    Parameters
    ----------
    first : (b,) intp
        Number of each block's first ray.
    P0, d : pair of (3, b) or (3, 1) float64
        The least and the largest that each number of a block's rays may be.

    Attributes
    ----------
    P0, d : (3, b) or (3, 1) float64
        The middle rays.
    aside, turn : (b,) or (1,) float64
        The largest ‖difference‖ of any ray's P0 and d from that.
    squared : (b,) or (1,) float64
        ‖d‖² of the middle rays.
    slowest, fastest : (b,) or (1,) float64
        RayBounds of ‖d‖ of all rays.
    """

    def __init__(self, first: Index, P0: tuple[Floats, Floats], d: tuple[Floats, Floats]) -> None:
        self._first = first
        self.P0, self.aside = _middle(*P0)
        self.d, self.turn = _middle(*d)
        self.squared = (self.d * self.d).sum(axis=0)
        length = np.sqrt(self.squared)
        self.slowest = np.maximum(length * (1 - PAD) - self.turn, 0.0)
        self.fastest = length * (1 + PAD) + self.turn

    def of(self, which: Index, *values: Floats) -> list[Floats]:
        """Values (…, b) or (…, 1) of blocks, block by block: (…, p) or (…, 1)."""
        return [value if value.shape[-1] == 1 else value.take(which, axis=-1) for value in values]

    def latest(self, t_max: Floats) -> Floats:
        """The largest t_max (n,) of t in each block, and a little more, (b,)."""
        t: Floats = np.maximum.reduceat(t_max, self._first)
        return t + PAD * np.abs(t)


def _least_and_most(vectors: Floats, first: Index) -> tuple[Floats, Floats]:
    """Of vectors (3, n), what their numbers span from each of some to the next; (3, 1) of one."""
    if vectors.strides[1] == 0:
        vector = vectors[:, :1]
        return vector, vector
    return np.minimum.reduceat(vectors, first, axis=1), np.maximum.reduceat(vectors, first, axis=1)


def _middle(low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """The middle (3, b) of boxes, and how far from it anything in them is, (b,) or (1,)."""
    if low is high:
        return low, np.zeros(1)
    middle, half = (low + high) / 2, (high - low) / 2
    stray = np.sqrt((half * half).sum(axis=0)) + PAD * np.abs(middle).max(axis=0)
    return middle, stray * (1 + PAD)


class Packets:
    """b packets of s consecutive rays each; the last ray stands in for those beyond it.

    Parameters
    ----------
    rays : Rays
    first : (b,) intp
        Each packet's first ray.
    size : int
        s.

    Attributes
    ----------
    index : (b, s) intp
        Numbers of the rays.
    P0, d : (b, 3, s) float64
    t0 : (b, s) float64
        A last axis of 1 says that all rays have the same.
    one_point : bool
        Whether one P0 stands for all.
    """

    def __init__(self, rays: Rays, first: Index, size: int) -> None:
        self.size, self._rays, self._first = size, rays, first
        self.one_point = rays.P0.strides[1] == 0
        self.index = np.minimum(first[:, None] + np.arange(size), rays.P0.shape[1] - 1)
        self.P0, self.d = _of(rays.P0, self.index), _of(rays.d, self.index)
        self.t0 = _of(rays.t0[None], self.index)[:, 0]

    def __len__(self) -> int:
        return len(self._first)

    def numbers(self, which: Index, at: Index) -> Index:
        """Numbers (p,) of the rays at some places in packets; n or more beyond the last."""
        return self._first.take(which) + at

    @cached_property
    def squared(self) -> Floats:
        """‖d‖², (b, s) or (b, 1)."""
        squares: Floats = np.einsum("bks,bks->bs", self.d, self.d)
        return squares

    @cached_property
    def length(self) -> Floats:
        """‖d‖, (b, s) or (b, 1)."""
        return np.sqrt(self.squared)

    @cached_property
    def table(self) -> Floats:
        """P0, d, t0 and ‖d‖ of single rays, (b, 8)."""
        table = np.empty((len(self), 8))
        table[:, :3], table[:, 3:6] = self.P0[:, :, 0], self.d[:, :, 0]
        table[:, 6], table[:, 7] = self.t0[:, 0], self.length[:, 0]
        return table

    @cached_property
    def toward_origin(self) -> Floats:
        """−d·P0, (b, s)."""
        along: Floats = np.einsum("bks,bks->bs", self.d, self.P0)
        return -along

    @cached_property
    def from_origin(self) -> Floats:
        """‖P0‖², (b, s) or (b, 1)."""
        squares: Floats = np.einsum("bks,bks->bs", self.P0, self.P0)
        return squares

    def of(self, which: Index, *values: NDArray[Any]) -> list[NDArray[Any]]:
        """Values (b, …) of packets, packet by packet: (p, …); (1, …) if there is but one packet."""
        return [value if len(self) == 1 else value[which] for value in values]

    @cached_property
    def span(self) -> PacketBounds:
        """What bounds them."""
        return PacketBounds(self)

    def divided(self, index: Index) -> Packets:
        """Some of them, each in its parts, which follow each other."""
        parts = _parts(self._first[index], self.size, PARTS)
        return Packets(self._rays, parts, self.size // PARTS)


class RayBounds(ABC):
    """What bounds packets, so that boxes can be told that they miss.

    How far along a packet they are is told in a measure of the bounds' own.
    """

    @abstractmethod
    def latest(self, t_max: Floats) -> Measures:
        """How far along each packet is of interest, (b,), of t ≤ t_max (n,); rather too far."""

    def meet(
        self, which: Index, boxes: Measures, nodes: Index, latest: Measures, pad: float
    ) -> Measures:
        """Where packets may enter the boxes of nodes: +inf for never, or not by the latest.

        Parameters
        ----------
        which, nodes : (p,) intp
            Numbers of packets and of nodes, pair by pair.
        boxes : (n, 6, c) float
            Of each node's children: lower corners and, negated, upper ones.
        latest : (b,) float
        pad : float
            What boxes grow by, in their unit.

        Returns
        -------
        (c, p) float
        """
        planes = boxes.reshape(-1, boxes.shape[2])
        near = np.empty((boxes.shape[2], len(which)), dtype=boxes.dtype)
        step = max(1, _NEARBY // boxes.shape[2])
        for start in range(0, len(which), step):
            some = slice(start, start + step)
            with np.errstate(all="ignore"):  # not together
                self._meet(which[some], planes, 6 * nodes[some], latest, pad, near[:, some])
        return near

    @abstractmethod
    def _meet(
        self, which: Index, planes: Measures, base: Index, latest: Measures, pad: float,
        near: Measures,
    ) -> None:  # fmt: skip
        """`meet` for few pairs, into near (c, p)."""


class PacketBounds(RayBounds):
    """The bounds of packets, along which t is told.

    A packet has a main axis, along which all of its rays advance one way. At a distance x along
    that axis a ray is at P + x·slope in the two others; a packet holds whatever its P and slopes
    span.

    Attributes
    ----------
    together : (b,) bool
        Whether the rays of a packet keep so close together that `meet` can tell any.
    """

    def __init__(self, packets: Packets) -> None:
        self._index = packets.index
        slow, fast = packets.d.min(axis=2), packets.d.max(axis=2)
        low, high = packets.P0.min(axis=2), packets.P0.max(axis=2)
        speed = np.where(slow > 0, slow, np.where(fast < 0, -fast, 0.0))
        packet, main = np.arange(len(packets)), np.argmax(speed, axis=1)
        forward = slow[packet, main] > 0
        self._slowest = speed[packet, main]
        self._fastest = np.where(forward, fast[packet, main], -slow[packet, main])
        self._enter, self._leave = np.where(forward, (main, main + 3), (main + 3, main))
        self._low = np.where(forward, low[packet, main], -high[packet, main])
        self._high = np.where(forward, high[packet, main], -low[packet, main])
        start = packets.t0.min(axis=1)
        start = start - PAD * np.abs(start)
        self._start = np.minimum(start * self._slowest, start * self._fastest)
        self._ahead = bool((self._start >= 0).all())
        step = np.abs(packets.d[packet, main])
        self._aside = []
        together = (self._slowest > 0) & np.isfinite(low - high).all(axis=1)
        for axis in ((main + 1) % 3, (main + 2) % 3):
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # not together
                slope = packets.d[packet, axis] / step
            least, most = slope.min(axis=1), slope.max(axis=1)
            together &= most - least < _WIDE
            self._aside.append((axis, low[packet, axis], high[packet, axis], least, most))
        self.together = together

    def latest(self, t_max: Floats) -> Floats:
        """The largest t_max (n,) of t in each packet, and a little more, (b,)."""
        t: Floats = t_max[self._index].max(axis=1)
        return t + PAD * np.abs(t)

    def _meet(
        self, which: Index, planes: Measures, base: Index, latest: Measures, pad: float,
        near: Measures,
    ) -> None:  # fmt: skip
        slowest, fastest, last = self._slowest[which], self._fastest[which], latest[which]
        x0, x1, lower, upper, other = np.empty((5, *near.shape))
        enter, leave = (base + plane[which] for plane in (self._enter, self._leave))
        np.subtract(planes.take(enter, axis=0).T, self._high[which] + pad, out=x0)
        np.maximum(x0, self._start[which], out=x0)
        np.subtract(pad - self._low[which], planes.take(leave, axis=0).T, out=x1)
        np.minimum(x1, np.maximum(last * slowest, last * fastest) + pad, out=x1)
        meets = x0 <= x1
        for axis, low, high, least, most in self._aside:
            k = base + axis[which]
            s, e = least[which], most[which]
            np.multiply(s, x0, out=lower)
            np.minimum(lower, np.multiply(s, x1, out=other), out=lower)
            np.multiply(e, x0, out=upper)
            np.maximum(upper, np.multiply(e, x1, out=other), out=upper)
            if not self._ahead:  # where x < 0, steep slopes lead down
                np.minimum(lower, np.minimum(e * x0, e * x1), out=lower)
                np.maximum(upper, np.maximum(s * x0, s * x1), out=upper)
            lower += planes.take(k + 3, axis=0).T
            meets &= lower <= pad - low[which]
            upper -= planes.take(k, axis=0).T
            meets &= upper >= -pad - high[which]
        np.minimum(x0 / slowest, x0 / fastest, out=near)
        near[~meets] = np.inf


def _parts(first: Index, size: int, parts: int) -> Index:
    return (first[:, None] + size // parts * np.arange(parts)).ravel()


def _of(vectors: Floats, index: Index) -> Floats:
    """Vectors (k, n) of rays (b, s), as (b, k, s); as (b, k, 1) where all are one."""
    if vectors.strides[1] == 0:
        return np.broadcast_to(vectors[:, :1], (len(index), len(vectors), 1))
    first, last = index[0, 0], index[-1, -1]
    if last - first == index.size - 1:  # one after another
        return vectors[:, first : last + 1].reshape(-1, *index.shape).swapaxes(0, 1)
    return np.ascontiguousarray(vectors.take(index, axis=1).transpose(1, 0, 2))
