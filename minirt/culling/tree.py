"""Culling: which primitives a ray may meet. It never decides a hit and never changes a bit.

A tree of bounding boxes, eight children a node, is walked level by level by packets: consecutive
rays that are bounded together. Boxes are padded beyond any rounding error of the boxes, the rays
and the kernels, so that whatever a kernel accepts is offered to it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from minirt.culling.packets import PAD, PARTS, Measures, Packets, RayBounds
from minirt.culling.slabs import Slabs, precision
from minirt.vectors import Bools, Floats, Index, divided

_WIDTH = 8
#: Nodes of one level that a packet may meet before it is divided.
_CROWD = 24
#: Pairs of a ray and a node below which neither packets are divided nor near nodes opened first.
_MANY = 65_536
#: The least size of a tree, so that no coordinate overflows in units of it.
_TINY = 2.0**-500


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
    tree: Tree, rays: Iterable[Packets], t_max: Floats, pad: float
) -> Iterator[tuple[Packets, Index, Index]]:
    """Yield (packets, which, primitives): pairs of a packet and a primitive that its rays may meet.

    Parameters
    ----------
    tree : Tree
    rays : iterable of Packets
    t_max : (n,) float64
        Largest t of interest for each ray; the caller may lower it between two steps.
    pad : float
        What boxes grow by.
    """
    views = (_View(tree, pad, packets) for packets in rays)
    work = [
        _Open(view, 0, np.arange(len(view.packets)), np.zeros(len(view.packets), np.intp))
        for view in views
    ]
    while work:
        now = work.pop()
        latest = now.view.bounds.latest(t_max)
        if now.near is not None:
            now = now.take(np.flatnonzero(now.near <= latest.take(now.which)))
        if now.level == len(tree.boxes):
            yield now.view.packets, now.which, tree.primitives.take(now.nodes)
        elif len(now.which):
            work += now.opened(latest)


class _View:
    """What packets look at: the tree's boxes, in its own measure for single rays, and their pad."""

    def __init__(self, tree: Tree, pad: float, packets: Packets) -> None:
        self._tree, self._pad, self.packets = tree, pad, packets
        self.bounds: RayBounds
        self.boxes: tuple[Measures, ...]
        if packets.size > 1:
            self.bounds, self.boxes, self.pad = packets.span, tree.boxes, pad
        else:
            center, size = tree.place
            kind = precision(tree.share, pad / size)
            slabs = Slabs(packets, center, size, pad, kind)
            self.bounds, self.boxes, self.pad = slabs, tree.placed(kind), slabs.slack

    def divided(self, index: Index) -> _View:
        """Some of the packets, in their parts."""
        return _View(self._tree, self._pad, self.packets.divided(index))


class _Open:
    """Pairs of a packet and a node of one level that are to be opened.

    `near` is where the packet may enter the node, where that is known.
    """

    def __init__(
        self, view: _View, level: int, which: Index, nodes: Index, near: Measures | None = None
    ) -> None:
        self.view, self.level, self.which, self.nodes, self.near = view, level, which, nodes, near

    def take(self, some: Index) -> _Open:
        """Some of the pairs."""
        near = None if self.near is None else self.near.take(some)
        return _Open(self.view, self.level, self.which.take(some), self.nodes.take(some), near)

    def opened(self, latest: Measures) -> Iterator[_Open]:
        """The pairs with the nodes' children that meet; what is to be looked at first comes last.

        That is the nearest child of each pair: what is met in it may hide the others. Packets that
        meet too many are divided, and their parts open the nodes again.
        """
        view, packets = self.view, self.view.packets
        near = view.bounds.meet(self.which, view.boxes[self.level], self.nodes, latest, view.pad)
        best = near.min(axis=0)
        met = np.flatnonzero(near < np.inf)
        child, pair = divided(met, len(self.which))
        nodes = self.nodes.take(pair) * len(near) + child
        children = _Open(view, self.level + 1, self.which.take(pair), nodes, near.take(met))
        if len(met) * packets.size > _MANY:
            first = children.near <= best.take(pair)
            if packets.size > 1:
                crowded = np.bincount(children.which, minlength=len(packets)) > _CROWD
                if crowded.any():
                    yield self._in_parts(crowded)
                    rest = np.flatnonzero(~crowded[children.which])
                    children, first = children.take(rest), first[rest]
            yield children.take(np.flatnonzero(~first))
            children = children.take(np.flatnonzero(first))
        yield children

    def _in_parts(self, crowded: Bools) -> _Open:
        """The same nodes for the parts of crowded (b,) packets."""
        some = np.flatnonzero(crowded[self.which])
        place = (np.cumsum(crowded) - 1)[self.which[some]]
        parts = (place[:, None] * PARTS + np.arange(PARTS)).ravel()
        finer = self.view.divided(np.flatnonzero(crowded))
        return _Open(finer, self.level, parts, np.repeat(self.nodes[some], PARTS))
