"""The tree of bounding boxes, eight children a node, which rays walk level by level.

It holds wherever rays have no grid to rasterise over: without it, rays without order in a mesh of
82,000 triangles take nearly a thousand times as long (row 'mesh, 82k, no order' of the bench).
Boxes are padded beyond any rounding error of the boxes, the rays and the kernels.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from minirt.culling.bounding_tests import PAD
from minirt.culling.slabs import Measures, Slabs, precision
from minirt.rays import Rays
from minirt.vectors import Floats, Index, divided

_WIDTH = 8
#: Pairs of a ray and a node below which near nodes are not opened first.
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


def visit(tree: Tree, rays: Rays, t_max: Floats, pad: float) -> Iterator[tuple[Index, Index]]:
    """Yield (rays, primitives): pairs (p,) that may meet, by their boxes.

    Parameters
    ----------
    tree : Tree
    rays : Rays
    t_max : (n,) float64
        Largest t of interest for each ray; the caller may lower it between two steps.
    pad : float
        What boxes grow by.
    """
    center, size = tree.place
    kind = precision(tree.share, pad / size)
    slabs, boxes = Slabs(rays, center, size, pad, kind), tree.placed(kind)
    work = [_Pairs(0, np.arange(rays.count), np.zeros(rays.count, dtype=np.intp))]
    while work:
        now = work.pop()
        latest = slabs.latest(t_max)
        if now.near is not None:
            now = now.take(np.flatnonzero(now.near <= latest.take(now.rays)))
        if now.level == len(boxes):
            yield now.rays, tree.primitives.take(now.nodes)
        elif len(now.rays):
            work += now.opened(slabs, boxes[now.level], latest)


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Pairs (p,) of a ray and a node of one level that are to be opened.

    `near` is where the ray may enter the node, where that is known.
    """

    level: int
    rays: Index
    nodes: Index
    near: Measures | None = None

    def take(self, some: Index) -> _Pairs:
        """Some of the pairs."""
        near = None if self.near is None else self.near.take(some)
        return _Pairs(self.level, self.rays.take(some), self.nodes.take(some), near)

    def opened(self, slabs: Slabs, boxes: Measures, latest: Measures) -> Iterator[_Pairs]:
        """The pairs with the nodes' children that meet; what is to be looked at first comes last.

        That is the nearest child of each pair: what is met in it may hide the others.
        """
        near = slabs.meet(self.rays, boxes, self.nodes, latest)
        best = near.min(axis=0)
        met = np.flatnonzero(near < np.inf)
        child, pair = divided(met, len(self.rays))
        nodes = self.nodes.take(pair) * len(near) + child
        at = near.take(met)
        children = _Pairs(self.level + 1, self.rays.take(pair), nodes, at)
        if len(met) > _MANY:
            first = at <= best.take(pair)
            yield children.take(np.flatnonzero(~first))
            children = children.take(np.flatnonzero(first))
        yield children
