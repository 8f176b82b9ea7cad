"""Which pairs of a ray and a primitive are worth testing, by whatever way costs least."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np

from minirt.culling.bounding_tests import PAD, BoundingTest
from minirt.culling.index import KindIndex, SceneIndex
from minirt.culling.rasteriser import Rasteriser
from minirt.culling.ray_grid import grid_of
from minirt.culling.tree import visit
from minirt.geometry import Kind
from minirt.rays import Rays
from minirt.vectors import Floats, Index, divided

#: Primitives of a kind that are not worth a tree.
NO_TREE = 32
#: Pairs that are yielded together: enough to make a kernel's call cheap, and so many that its
#: temporaries stay in a few megabytes.
_BATCH, _MOST = 8_192, 65_536
#: Pairs in one pass of a bounding test: the temporaries then stay in a few megabytes; and pairs of
#: single rays, each of which fetches its primitive's numbers.
_PASS, _SINGLE = 32_768, 8_192
#: Share of the usual group's radius within which origins are one point. Without this, a mesh whose
#: rays are displaced takes 2.8 × as long (row 'stability, mesh, 5k' of the bench).
_POINT = 2.0**-7

#: Pairs (p,) of a ray and a primitive of one kind, by number.
Pairs: TypeAlias = tuple[Index, Index]


class Batch(NamedTuple):
    """Pairs (p,) of a ray and a primitive of one kind, by number."""

    kind: Kind
    rays: Index
    primitives: Index


class Candidates(Protocol):
    """A way to choose pairs: those of `every_pair`, but for some that do not meet by t_max (n,).

    The caller may lower t_max between two batches.
    """

    def __call__(self, index: SceneIndex, rays: Rays, t_max: Floats, /) -> Iterator[Batch]:
        """Yield the pairs, batch by batch, kind by kind."""


def every_pair(index: SceneIndex, rays: Rays, t_max: Floats) -> Iterator[Batch]:
    """Every ray with every primitive; of each ray, the primitives in their order."""
    every = np.arange(rays.count)
    step = max(1, _MOST // max(1, len(every)))
    for kind in index.kinds if len(every) else ():
        for start in range(0, kind.count, step):
            some = np.arange(start, min(kind.count, start + step))
            yield Batch(kind.kind, np.tile(every, len(some)), np.repeat(some, len(every)))


def culled_pairs(index: SceneIndex, rays: Rays, t_max: Floats) -> Iterator[Batch]:
    """The pairs that may meet by t_max (n,), near primitives first.

    What is found in one batch can hide what is in the next.
    """
    search = _Search(rays, t_max)
    for kind in index.kinds if rays.count else ():
        waiting: list[Pairs] = []
        size = 0
        for pairs in search.pairs(kind):
            waiting.append(pairs)
            size += len(pairs[0])
            if size >= _BATCH:
                yield Batch(kind.kind, *_joined(waiting))
                waiting, size = [], 0
        if size:
            yield Batch(kind.kind, *_joined(waiting))


class _Search:
    """The primitives that n rays may meet by t_max (n,), which the caller may lower at any time."""

    def __init__(self, rays: Rays, t_max: Floats) -> None:
        self._rays, self._t_max = rays, t_max
        #: The largest coordinate of any origin.
        self._farthest = float(np.fmax.reduce(np.abs(rays.P0), axis=None, initial=0.0))

    def pairs(self, kind: KindIndex) -> Iterator[Pairs]:
        """Pairs of a ray and a primitive: rasterised, from the tree, or all that pass the test."""
        reach = max(kind.tree.reach, self._farthest)
        test = kind.bounding_test(self._rays, self._t_max, PAD * reach)
        if kind.count <= NO_TREE:
            yield from self._few(np.arange(kind.count), test)
            return
        rasteriser = self._rasteriser(kind, reach)
        if rasteriser is None:
            for of, which in visit(kind.tree, self._rays, self._t_max, PAD * reach):
                yield from self._that_pass(of, which, test)
        else:
            yield from self._few(rasteriser.close, test)
            yield from rasteriser.pairs(self._t_max)

    def _rasteriser(self, kind: KindIndex, reach: float) -> Rasteriser | None:
        """The primitives over the rays' grid, if both exist and that costs less than the tree.

        Rays that nearly leave one point are taken to do so: otherwise the displaced rays of an
        error model take 2.7 × as long (row 'stability, mesh, 5k' of the bench).
        """
        if kind.groups is None:
            return None
        rays, moved = self._rays, 0.0
        if not rays.one_origin and not rays.one_direction:
            low, high = rays.P0.min(axis=1), rays.P0.max(axis=1)
            with np.errstate(invalid="ignore"):  # not finite
                moved = float((high - low).sum())
            if not moved <= _POINT * np.median(kind.groups.radius):
                return None
            rays = Rays(((low + high) / 2)[:, None], rays.d, rays.t0, rays.t1, rays.count)
        grid = grid_of(rays, PAD * reach + moved, reach)
        return None if grid is None else Rasteriser.of(grid, kind.groups)

    def _few(self, primitives: Index, test: BoundingTest) -> Iterator[Pairs]:
        """Few primitives with those of all rays that pass their test."""
        n, k = self._rays.count, len(primitives)
        step = max(1, _PASS // max(1, k))
        for start in range(0, n if k else 0, step):
            size = min(step, n - start)
            passed = test.all_pairs(slice(start, start + size), primitives)
            met = np.flatnonzero(np.broadcast_to(passed, (k, size)))
            which, ray = divided(met, size)
            yield start + ray, primitives.take(which)

    def _that_pass(self, of: Index, which: Index, test: BoundingTest) -> Iterator[Pairs]:
        """Those pairs (p,) that pass their test."""
        for start in range(0, len(of), _SINGLE):
            some = slice(start, start + _SINGLE)
            passed = np.flatnonzero(test.pairs(of[some], which[some]))
            yield of[some].take(passed), which[some].take(passed)


def _joined(batch: list[Pairs]) -> Pairs:
    rays, which = zip(*batch, strict=True)
    return np.concatenate(rays), np.concatenate(which)
