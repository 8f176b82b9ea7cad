"""Culling: which primitives a ray may meet. It never decides a hit and never changes a bit.

A tree of bounding boxes, eight children a node, is walked depth first by streams of rays: each
node is visited once for all the rays still alive in it. Boxes are padded beyond any rounding
error of the boxes, the rays and the kernels, so that whatever a kernel accepts is offered to it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from minirt.vectors import Bools, Floats, Index, dot, norm

_WIDTH = 8
#: Rays whose spans in a node's boxes fit into a processor's cache.
_NEARBY = 4_096
#: Boxes grow by this share of the largest coordinate in play: some 4,000 times the rounding of it.
_PAD = 2.0**-40
#: Stands in for the reciprocal of a component that is zero; times any legal length it is finite.
_FLAT = 1e-250
#: Sine of the angle below which a plane's crossing is not trusted to cull.
_GRAZING = 2.0**-8


@dataclass(frozen=True, eq=False)
class Leaf:
    """Primitives start…stop−1 in the tree's order."""

    start: int
    stop: int


@dataclass(frozen=True, eq=False)
class Node:
    """Children with their boxes, lower and upper corners (3, c)."""

    lower: Floats
    upper: Floats
    children: tuple[Node | Leaf, ...]


@dataclass(frozen=True, eq=False)
class Tree:
    """A tree over m primitives.

    Attributes
    ----------
    order : (m,) intp
        Primitive numbers, leaf after leaf; ascending within a leaf.
    root : Node or Leaf
    reach : float
        Largest coordinate magnitude of any box.
    """

    order: Index
    root: Node | Leaf
    reach: float


def build(lower: Floats, upper: Floats, leaf: int = 12) -> Tree:
    """A tree over boxes given by their corners (3, m), by balanced median splits.

    A leaf holds at most `leaf` of them.
    """
    order = np.arange(lower.shape[1])
    root = _branch(order, 0, len(order), (lower, upper, lower + upper), leaf)
    return Tree(order, root, float(max(np.abs(lower).max(), np.abs(upper).max())))


def _branch(
    order: Index, start: int, stop: int, boxes: tuple[Floats, Floats, Floats], leaf: int
) -> Node | Leaf:
    if stop - start <= leaf:
        order[start:stop].sort()
        return Leaf(start, stop)
    lower, upper, middle = boxes
    ranges = [(start, stop)]
    while len(ranges) < _WIDTH and max(b - a for a, b in ranges) > leaf:
        ranges = [half for r in ranges for half in _halves(order, *r, middle, leaf)]
    low = np.stack([lower[:, order[a:b]].min(axis=1) for a, b in ranges], axis=1)
    high = np.stack([upper[:, order[a:b]].max(axis=1) for a, b in ranges], axis=1)
    return Node(low, high, tuple(_branch(order, a, b, boxes, leaf) for a, b in ranges))


def _halves(
    order: Index, start: int, stop: int, middle: Floats, leaf: int
) -> list[tuple[int, int]]:
    if stop - start <= leaf:
        return [(start, stop)]
    part = order[start:stop]
    points = middle[:, part]
    axis = int(np.argmax(points.max(axis=1) - points.min(axis=1)))
    half = (stop - start) // 2
    order[start:stop] = part[np.argpartition(points[axis], half)]
    return [(start, start + half), (start + half, stop)]


def visit(
    tree: Tree, P0: Floats, inverse: Floats, t0: Floats, limit: Floats
) -> Iterator[tuple[Index, Leaf]]:
    """Yield (rays, leaf) for every leaf that some rays may hit something in, t0 ≤ t ≤ limit.

    Parameters
    ----------
    P0, inverse : (3, n) float64
        Origins, and the `reciprocal` of the directions.
    t0, limit : (n,) float64
        Smallest and largest t of interest for each ray; the caller may lower it between two steps.
    """
    pad = padding(P0, tree.reach)
    stack: list[tuple[Node | Leaf, Index, Floats | None]] = [
        (tree.root, np.arange(P0.shape[1]), None)
    ]
    while stack:
        node, rays, entry = stack.pop()
        if entry is not None:
            rays = rays[entry <= _beyond(limit[rays])]
        if not len(rays):
            continue
        if isinstance(node, Leaf):
            yield rays, node
            continue
        near, far = _box_span(P0[:, rays], inverse[:, rays], node.lower - pad, node.upper + pad)
        beyond = _beyond(far)
        meets = (near <= beyond) & (beyond >= t0[rays]) & (near <= _beyond(limit[rays]))
        distance = np.where(meets, near, np.inf).min(axis=1)
        for child in np.argsort(-distance, kind="stable"):
            chosen = np.flatnonzero(meets[child])
            if len(chosen):
                stack.append((node.children[child], rays[chosen], near[child, chosen]))


@dataclass(frozen=True, eq=False)
class Patches:
    """Flat primitives as culling sees them: parts of planes X·N = offset, within boxes.

    Attributes
    ----------
    offset : (m,) float64
    N, lower, upper : (3, m) float64
        Normals of any length, and the corners of the boxes.
    """

    offset: Floats
    N: Floats
    lower: Floats
    upper: Floats

    def take(self, index: Index) -> Patches:
        """Some of them."""
        return Patches(*(np.take(value, index, axis=-1) for value in vars(self).values()))


def may_cross(
    P0: Floats, d: Floats, patches: Patches, pad: float, t0: Floats, limit: Floats
) -> Bools:
    """Whether n rays P0 + t·d (3, n), t0 ≤ t ≤ limit (n,), may meet c patches inside their boxes.

    The boxes and the interval are grown by a pad. The crossings come from matrix products, which
    round as they like: some 2⁻⁴⁴ of the largest coordinate in play at the angles where culling is
    done, less than the pad, unless the plane is met at a small angle; there the answer is yes.

    Returns
    -------
    (c, n) bool
    """
    low, high = (patches.lower - pad)[:, :, None], (patches.upper + pad)[:, :, None]
    length = norm(d)
    slope = patches.N.T @ d
    steep = np.abs(slope) > np.outer(_GRAZING * norm(patches.N), length)
    t = patches.offset[:, None] - patches.N.T @ P0
    np.divide(t, slope, out=t, where=steep)
    slack = pad / length
    within: Bools = (t >= t0 - slack) & (t <= limit + slack)
    for k in range(3):
        X = t * d[k]
        X += P0[k]
        within &= low[k] <= X
        within &= high[k] >= X
    within |= ~steep
    return within


def may_touch(P0: Floats, d: Floats, C: Floats, R: Floats) -> Bools:
    """Whether the lines of n rays (3, n) may meet spheres with centres (3, c) and radii (c,).

    Δ ≥ 0 by matrix products, which round as they like. Their terms are at most (‖P0‖ + ‖C‖)² and
    R², and err by some ten roundings; the pad is a thousand times that.

    Returns
    -------
    (c, n) bool
    """
    dd, PP, CC = dot(d, d), dot(P0, P0), dot(C, C)[:, None]
    b = C.T @ d - dot(d, P0)
    LL = PP + CC - 2.0 * (C.T @ P0)
    RR = (R * R)[:, None]
    touched: Bools = b * b >= dd * (LL - RR - _PAD * (PP + CC + RR))
    return touched


def _box_span(P0: Floats, inverse: Floats, lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """Where n lines enter and leave c boxes, (c, n): entry above exit where they miss."""
    shape = lower.shape[1], P0.shape[1]
    near, far = np.full(shape, -np.inf), np.full(shape, np.inf)
    for start in range(0, shape[1], _NEARBY):
        rays = slice(start, start + _NEARBY)
        for k in range(3):
            a = (lower[k, :, None] - P0[k, rays]) * inverse[k, rays]
            b = (upper[k, :, None] - P0[k, rays]) * inverse[k, rays]
            np.maximum(near[:, rays], np.minimum(a, b), out=near[:, rays])
            np.minimum(far[:, rays], np.maximum(a, b), out=far[:, rays])
    return near, far


def reciprocal(d: Floats) -> Floats:
    """1/d by component, finite where a component is zero."""
    return 1.0 / np.where(np.abs(d) < _FLAT, np.copysign(_FLAT, d), d)


def padding(P0: Floats, reach: float) -> float:
    """What boxes of that reach grow by for rays from P0 (3, n)."""
    return _PAD * max(reach, float(np.abs(P0).max(initial=0.0)))


def _beyond(t: Floats) -> Floats:
    """t and a little more: parameters themselves carry a few roundings."""
    return t + _PAD * np.abs(t)
