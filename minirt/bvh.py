"""Culling: which primitives a ray may meet. It never decides a hit and never changes a bit.

A tree of bounding boxes, eight children a node, is walked level by level by beams: consecutive
rays that are bounded together. Whatever a beam may meet is then sifted ray by ray. Boxes are
padded beyond any rounding error of the boxes, the rays and the kernels, so that whatever a kernel
accepts is offered to it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from minirt.beams import PAD, PARTS, Beams, Bounds, Measures
from minirt.slabs import Slabs, precision
from minirt.vectors import Bools, Floats, Index, divided, dot, take

_WIDTH = 8
#: Nodes of one level that a beam may meet before it is divided.
_CROWD = 24
#: Pairs of a ray and a node below which neither beams are divided nor near nodes opened first.
_MANY = 65_536
#: The least size of a tree, so that no coordinate overflows in units of it.
_TINY = 2.0**-500
#: Sine of the angle below which a plane's crossing is not trusted to cull.
GRAZING = 2.0**-8


@dataclass(frozen=True, eq=False)
class Tree:
    """A tree over m primitives, complete: all of them are equally far from its root.

    Attributes
    ----------
    primitives : (l,) intp
        By number of the last level's boxes; some stand in two places.
    boxes : tuple of (n, 6, c) float64
        Level by level, for each of n nodes its children's boxes: lower corners and, negated,
        upper ones. Children are numbered node by node; they are the nodes of the next level.
    reach : float
        Largest coordinate magnitude of any box.
    """

    primitives: Index
    boxes: tuple[Floats, ...]
    reach: float

    @cached_property
    def place(self) -> tuple[Floats, float]:
        """Its centre (3, 1), and the largest distance along an axis from there to any box."""
        low, high = self.boxes[0][:, :3].min(axis=(0, 2)), -self.boxes[0][:, 3:].min(axis=(0, 2))
        center = (low + high) / 2
        size = float(np.maximum(high - center, center - low).max())
        return center[:, None], max(size, PAD * self.reach, _TINY)

    @cached_property
    def share(self) -> float:
        """Of its size, that of the small ones among the last boxes: the hundredth part is less."""
        extents = -(self.boxes[-1][:, :3] + self.boxes[-1][:, 3:]).max(axis=1)
        return float(np.quantile(extents, 0.01)) / self.place[1]

    def placed(self, kind: type[np.floating[Any]]) -> tuple[Measures, ...]:
        """Its boxes around its centre in units of its size, in numbers of some kind."""
        if kind not in self._placed:
            center, size = self.place
            shift = np.concatenate((-center, center))
            self._placed[kind] = tuple(
                ((level + shift) / size).astype(kind) for level in self.boxes
            )
        return self._placed[kind]

    @cached_property
    def _placed(self) -> dict[type[np.floating[Any]], tuple[Measures, ...]]:
        return {}


def build(lower: Floats, upper: Floats) -> Tree:
    """A tree over boxes given by their corners (3, m), by balanced median splits."""
    m = lower.shape[1]
    halvings = max(0, int(np.ceil(np.log2(m / _WIDTH))))
    order = np.resize(np.arange(m), (1, -(-m // 2**halvings) * 2**halvings))
    middle = lower + upper
    for _ in range(halvings):
        points = middle[:, order]
        axis = np.argmax(np.ptp(points, axis=2), axis=0)
        along = points[axis, np.arange(len(order))]
        half = order.shape[1] // 2
        part = np.argpartition(along, half, axis=1)
        order = np.take_along_axis(order, part, axis=1).reshape(-1, half)
    corners = np.concatenate((lower, -upper))[:, order]
    boxes = [corners.transpose(1, 0, 2).copy()]
    while len(boxes[0]) > 1:
        fan = min(_WIDTH, len(boxes[0]))
        nodes = boxes[0].min(axis=2)
        boxes.insert(0, nodes.reshape(-1, fan, 6).transpose(0, 2, 1).copy())
    reach = float(max(np.abs(lower).max(), np.abs(upper).max()))
    return Tree(order.ravel(), tuple(boxes), reach)


def visit(
    tree: Tree, rays: Iterable[Beams], limit: Floats, pad: float
) -> Iterator[tuple[Beams, Index, Index]]:
    """Yield (beams, which, primitives): pairs of a beam and a primitive that its rays may meet.

    Parameters
    ----------
    tree : Tree
    rays : iterable of Beams
    limit : (n,) float64
        Largest t of interest for each ray; the caller may lower it between two steps.
    pad : float
        What boxes grow by.
    """
    sights = (_Sight(tree, pad, beams) for beams in rays)
    work = [
        _Open(sight, 0, np.arange(len(sight.beams)), np.zeros(len(sight.beams), np.intp))
        for sight in sights
    ]
    while work:
        now = work.pop()
        latest = now.sight.bounds.latest(limit)
        if now.near is not None:
            now = now.take(np.flatnonzero(now.near <= latest.take(now.which)))
        if now.level == len(tree.boxes):
            yield now.sight.beams, now.which, tree.primitives.take(now.nodes)
        elif len(now.which):
            work += now.opened(latest)


class _Sight:
    """What beams look at: the tree's boxes, in its own measure for single rays, and their pad."""

    def __init__(self, tree: Tree, pad: float, beams: Beams) -> None:
        self._tree, self._pad, self.beams = tree, pad, beams
        self.bounds: Bounds
        self.boxes: tuple[Measures, ...]
        if beams.size > 1:
            self.bounds, self.boxes, self.pad = beams.span, tree.boxes, pad
        else:
            center, size = tree.place
            kind = precision(tree.share, pad / size)
            slabs = Slabs(beams, center, size, pad, kind)
            self.bounds, self.boxes, self.pad = slabs, tree.placed(kind), slabs.slack

    def divided(self, index: Index) -> _Sight:
        """Some of the beams, in their parts."""
        return _Sight(self._tree, self._pad, self.beams.divided(index))


class _Open:
    """Pairs of a beam and a node of one level that are to be opened.

    `near` is where the beam may enter the node, where that is known.
    """

    def __init__(
        self, sight: _Sight, level: int, which: Index, nodes: Index, near: Measures | None = None
    ) -> None:
        self.sight, self.level, self.which, self.nodes, self.near = sight, level, which, nodes, near

    def take(self, some: Index) -> _Open:
        """Some of the pairs."""
        near = None if self.near is None else self.near.take(some)
        return _Open(self.sight, self.level, self.which.take(some), self.nodes.take(some), near)

    def opened(self, latest: Measures) -> Iterator[_Open]:
        """The pairs with the nodes' children that meet; what is to be looked at first comes last.

        That is the nearest child of each pair: what is met in it may hide the others. Beams that
        meet too many are divided, and their parts open the nodes again.
        """
        sight, beams = self.sight, self.sight.beams
        near = sight.bounds.meet(self.which, sight.boxes[self.level], self.nodes, latest, sight.pad)
        best = near.min(axis=0)
        met = np.flatnonzero(near < np.inf)
        child, pair = divided(met, len(self.which))
        nodes = self.nodes.take(pair) * len(near) + child
        children = _Open(sight, self.level + 1, self.which.take(pair), nodes, near.take(met))
        if len(met) * beams.size > _MANY:
            first = children.near <= best.take(pair)
            if beams.size > 1:
                crowded = np.bincount(children.which, minlength=len(beams)) > _CROWD
                if crowded.any():
                    yield self._in_parts(crowded)
                    rest = np.flatnonzero(~crowded[children.which])
                    children, first = children.take(rest), first[rest]
            yield children.take(np.flatnonzero(~first))
            children = children.take(np.flatnonzero(first))
        yield children

    def _in_parts(self, crowded: Bools) -> _Open:
        """The same nodes for the parts of crowded (b,) beams."""
        some = np.flatnonzero(crowded[self.which])
        place = (np.cumsum(crowded) - 1)[self.which[some]]
        parts = (place[:, None] * PARTS + np.arange(PARTS)).ravel()
        finer = self.sight.divided(np.flatnonzero(crowded))
        return _Open(finer, self.level, parts, np.repeat(self.nodes[some], PARTS))


def may_cross(
    patches: Floats, beams: Beams, which: Index, primitives: Index, pad: float, limit: Floats
) -> Bools:
    """Whether rays of beams, up to t = limit (n,), may meet flat primitives, pair by pair.

    The sides and the interval are grown by a pad. The crossings come from matrix products, which
    round as they like: some 2⁻⁴⁴ of the largest coordinate in play at the angles where culling is
    done, less than the pad, unless the plane is met at a small angle; there the answer is yes.

    Parameters
    ----------
    patches : (m, 1 + e, 4) float64
        Of each primitive, the unit normal N of its plane X·N = offset, and the offset; and of its
        sides unit vectors along the plane, inward, of which X·side is no less than the fourth
        number in the primitive; zero where a side is not told.
    beams : Beams
    which, primitives : (p,) intp

    Returns
    -------
    (p, s) bool
    """
    planes = patches.take(primitives, axis=0)
    if beams.size == 1:
        return _may_cross_singly(planes, beams, which, pad, limit)
    P0, d, length, t0, index = beams.of(
        which, beams.P0, beams.d, beams.length, beams.t0, beams.index
    )
    along, ahead = planes[:, :, :3] @ d, planes[:, :, 3:] - planes[:, :, :3] @ P0
    steep = np.abs(along[:, 0]) > GRAZING * length
    t = ahead[:, 0] / np.where(steep, along[:, 0], 1.0)
    slack = pad / length
    within: Bools = (t >= t0 - slack) & (t <= limit[index] + slack)
    ahead -= pad
    for k in range(1, planes.shape[1]):
        within &= t * along[:, k] >= ahead[:, k]
    within |= ~steep
    return within


def _may_cross_singly(
    planes: Floats, beams: Beams, which: Index, pad: float, limit: Floats
) -> Bools:
    """`may_cross` for beams of one ray, (p, 1): products with one column each cost too much."""
    numbers = beams.table.take(which, axis=0).T
    P0, d, t0, length = numbers[:3], numbers[3:6], numbers[6], numbers[7]
    N, offset = planes[:, 0, :3].T, planes[:, 0, 3]
    slope = dot(N, d)
    steep = np.abs(slope) > GRAZING * length
    t = (offset - dot(N, P0)) / np.where(steep, slope, 1.0)
    slack, latest = pad / length, limit.take(beams.index[:, 0].take(which))
    within: Bools = (t >= t0 - slack) & (t <= latest + slack)
    for k in range(1, planes.shape[1]):
        side = planes[:, k, :3].T
        within &= t * dot(side, d) >= planes[:, k, 3] - pad - dot(side, P0)
    within |= ~steep
    return within[:, None]


def may_touch(C: Floats, R: Floats, beams: Beams, which: Index, primitives: Index) -> Bools:
    """Whether the lines of rays of beams may meet spheres, pair by pair.

    Δ ≥ 0 by products that round as they like. Their terms are at most (‖P0‖ + ‖C‖)² and R², or
    ‖C − P0‖² and R² where all rays leave one point, and err by some ten roundings; the pad is a
    thousand times that.

    Parameters
    ----------
    C : (3, m) float64
    R : (m,) float64
    beams : Beams
    which, primitives : (p,) intp

    Returns
    -------
    (p, s) bool
    """
    P0, d, aa = beams.of(which, beams.P0, beams.d, beams.squared)
    center, radius = take(C, primitives).T[:, None], R[primitives, None]
    one_point = len(beams) == 1 and P0.shape[2] == 1
    if one_point:
        center = center - P0[:, None, :, 0]
    LL = (center * center).sum(axis=2) * (1 - PAD) - radius * radius * (1 + PAD)
    b = (center @ d)[:, 0]
    if not one_point:
        ahead, size = beams.of(which, beams.toward_origin, beams.from_origin)
        b = b + ahead
        LL = size * (1 - PAD) - 2.0 * (center @ P0)[:, 0] + LL
    b *= b
    missed: Bools = b < aa * LL
    np.logical_not(missed, out=missed)
    return missed
