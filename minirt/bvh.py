"""Culling: which primitives a ray may meet. It never decides a hit and never changes a bit.

A tree of bounding boxes, eight children a node, is walked level by level by beams: consecutive
rays that are bounded together. Whatever a beam may meet is then sifted ray by ray. Boxes are
padded beyond any rounding error of the boxes, the rays and the kernels, so that whatever a kernel
accepts is offered to it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from minirt.beams import PAD, PARTS, Beams
from minirt.vectors import Bools, Floats, Index, divided, dot, take

_WIDTH = 8
#: Nodes of one level that a beam may meet before it is divided.
_CROWD = 24
#: Pairs of a ray and a node below which neither beams are divided nor near nodes opened first.
_MANY = 65_536
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
    work = [_Open(beams, 0, np.arange(len(beams)), np.zeros(len(beams), np.intp)) for beams in rays]
    while work:
        now = work.pop()
        latest = now.beams.latest(limit)
        if now.near is not None:
            now.keep(now.near <= latest[now.which])
        if now.level == len(tree.boxes):
            yield now.beams, now.which, tree.primitives[now.nodes]
        elif len(now.which):
            work += now.opened(tree.boxes[now.level], latest, pad)


class _Open:
    """Pairs of a beam and a node of one level that are to be opened.

    `near` is the least t at which they may meet, where that is known.
    """

    def __init__(
        self, beams: Beams, level: int, which: Index, nodes: Index, near: Floats | None = None
    ) -> None:
        self.beams, self.level, self.which, self.nodes, self.near = beams, level, which, nodes, near

    def keep(self, mask: Bools) -> None:
        """Some of the pairs."""
        self.which, self.nodes = self.which[mask], self.nodes[mask]

    def opened(self, boxes: Floats, latest: Floats, pad: float) -> Iterator[_Open]:
        """The pairs with the nodes' children that meet; what is to be looked at first comes last.

        That is the nearest child of each pair: what is met in it may hide the others. Beams that
        meet too many are divided, and their parts open the nodes again.
        """
        near = self.beams.span.meet(self.which, boxes, self.nodes, latest, pad)
        best = near.min(axis=0)
        met = np.flatnonzero(near < np.inf)
        child, pair = divided(met, len(self.which))
        which, nodes = self.which[pair], self.nodes[pair] * len(near) + child
        near = near.reshape(-1)[met]
        if len(which) * self.beams.size > _MANY:
            crowded = np.bincount(which, minlength=len(self.beams)) > _CROWD
            if self.beams.size > 1 and crowded.any():
                yield self._in_parts(crowded)
                rest = np.flatnonzero(~crowded[which])
                which, nodes, near, pair = which[rest], nodes[rest], near[rest], pair[rest]
            first = near <= best[pair]
            yield _Open(self.beams, self.level + 1, which[~first], nodes[~first], near[~first])
            which, nodes, near = which[first], nodes[first], near[first]
        yield _Open(self.beams, self.level + 1, which, nodes, near)

    def _in_parts(self, crowded: Bools) -> _Open:
        """The same nodes for the parts of crowded (b,) beams."""
        some = np.flatnonzero(crowded[self.which])
        place = (np.cumsum(crowded) - 1)[self.which[some]]
        parts = (place[:, None] * PARTS + np.arange(PARTS)).ravel()
        finer = self.beams.divided(np.flatnonzero(crowded))
        return _Open(finer, self.level, parts, np.repeat(self.nodes[some], PARTS))


@dataclass(frozen=True, eq=False)
class Patches:
    """Flat primitives as culling sees them: parts of planes, within other planes.

    Attributes
    ----------
    N : (m, 3) float64
        Unit normals of the planes X·N = offset.
    offset : (m,) float64
    sides : (m, e, 3) float64
        Unit vectors, along the plane, from each side inward; zero where a side is not told.
    least : (m, e) float64
        X·side is no less in the primitive.
    """

    N: Floats
    offset: Floats
    sides: Floats
    least: Floats


def may_cross(
    patches: Patches, beams: Beams, which: Index, primitives: Index, pad: float, limit: Floats
) -> Bools:
    """Whether rays of beams, up to t = limit (n,), may meet flat primitives, pair by pair.

    The sides and the interval are grown by a pad. The crossings come from matrix products, which
    round as they like: some 2⁻⁴⁴ of the largest coordinate in play at the angles where culling is
    done, less than the pad, unless the plane is met at a small angle; there the answer is yes.

    Returns
    -------
    (p, s) bool
    """
    if beams.size == 1:
        return _may_cross_singly(patches, beams, which, primitives, pad, limit)
    P0, d, length, t0, index = beams.of(
        which, beams.P0, beams.d, beams.length, beams.t0, beams.index
    )
    N = patches.N[primitives][:, None]
    slope = (N @ d)[:, 0]
    steep = np.abs(slope) > GRAZING * length
    ahead = patches.offset[primitives][:, None] - (N @ P0)[:, 0]
    t = ahead / np.where(steep, slope, 1.0)
    slack = pad / length
    within: Bools = (t >= t0 - slack) & (t <= limit[index] + slack)
    sides = patches.sides[primitives]
    along = sides @ d
    least = (patches.least[primitives] - pad)[:, :, None] - sides @ P0
    for k in range(sides.shape[1]):
        within &= t * along[:, k] >= least[:, k]
    within |= ~steep
    return within


def _may_cross_singly(
    patches: Patches, beams: Beams, which: Index, primitives: Index, pad: float, limit: Floats
) -> Bools:
    """`may_cross` for beams of one ray, (p, 1): products with one column each cost too much."""
    P0, d = (take(v, which) for v in beams.rows)
    t0, length = beams.t0[:, 0].take(which), beams.length[:, 0].take(which)
    N = patches.N.take(primitives, axis=0).T
    slope = dot(N, d)
    steep = np.abs(slope) > GRAZING * length
    t = (patches.offset.take(primitives) - dot(N, P0)) / np.where(steep, slope, 1.0)
    slack, latest = pad / length, limit.take(beams.index[:, 0].take(which))
    within: Bools = (t >= t0 - slack) & (t <= latest + slack)
    sides, least = patches.sides.take(primitives, axis=0), patches.least.take(primitives, axis=0)
    for k in range(sides.shape[1]):
        side = sides[:, k].T
        within &= t * dot(side, d) >= least[:, k] - pad - dot(side, P0)
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
    touched: Bools = ~(b * b < aa * LL)
    return touched
