"""Bounding tests: whether a ray may meet a primitive that is a little larger than it is.

A test costs a part of what a kernel does, and most pairs end here: without it, ten spheres take
3.1 × as long, 25 spheres in colour 3.8 × and three objects 1.7 × (rows '10 spheres', 'image, 25
spheres' and 'image, 3 objects' of the bench).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np

from minirt.rays import Rays
from minirt.vectors import Bools, Floats, Index, dot, norm, take

#: Boxes and bounds grow by this share of the largest number in play: some 4,000 times its rounding.
PAD = 2.0**-40
#: Sine of the angle below which a plane's crossing is not trusted to cull.
GRAZING = 2.0**-8


class BoundingTest(ABC):
    """The primitives of a kind, a little larger than they are, and rays up to t = t_max (n,).

    The caller may lower t_max between two calls.
    """

    def __init__(self, rays: Rays, t_max: Floats) -> None:
        self._rays, self._t_max = rays, t_max

    @abstractmethod
    def all_pairs(self, some: slice, primitives: Index) -> Bools:
        """Whether each of some rays may meet each of k primitives, (k, s) or (k, 1)."""

    @abstractmethod
    def pairs(self, of: Index, primitives: Index) -> Bools:
        """Whether rays (p,) may meet primitives (p,), pair by pair."""

    def _part(self, some: slice) -> tuple[Floats, Floats]:
        """P0 and d of some rays, (3, s) or (3, 1)."""
        rays = self._rays
        P0 = rays.P0 if rays.one_origin else rays.P0[:, some]
        return P0, rays.d if rays.one_direction else rays.d[:, some]

    @cached_property
    def _table(self) -> Floats:
        """P0, d, t0 and ‖d‖ of each ray, (n, 8), so that one fetch brings them all."""
        rays = self._rays
        table = np.empty((rays.count, 8))
        table[:, :3], table[:, 3:6] = rays.P0.T, rays.d.T
        table[:, 6], table[:, 7] = rays.t0, norm(rays.d)
        return table


class SphereBoundingTest(BoundingTest):
    """Spheres by their centres (3, m) and radii (m,): Δ ≥ 0 by products that round as they like."""

    def __init__(self, rays: Rays, t_max: Floats, center: Floats, radius: Floats) -> None:
        super().__init__(rays, t_max)
        self._center, self._radius = center, radius

    def all_pairs(self, some: slice, primitives: Index) -> Bools:
        """Δ ≥ 0 by matrix products.

        Their terms are at most (‖P0‖ + ‖C‖)² and R², or ‖C − P0‖² and R² where all rays leave one
        point, and err by some ten roundings; the pad is a thousand times that.
        """
        P0, d = self._part(some)
        L, R = take(self._center, primitives), self._radius.take(primitives)[:, None]
        if self._rays.one_origin:
            L = L - P0
        LL = dot(L, L)[:, None] * (1 - PAD) - R * R * (1 + PAD)
        b = L.T @ d
        if not self._rays.one_origin:
            b = b - dot(d, P0)
            LL = dot(P0, P0) * (1 - PAD) - 2.0 * (L.T @ P0) + LL
        missed: Bools = b * b < dot(d, d) * LL
        return ~missed

    def pairs(self, of: Index, primitives: Index) -> Bools:
        """Δ ≥ 0, all of which depends on C − P0, as in the kernel."""
        numbers = self._table.take(of, axis=0).T
        L, R = take(self._center, primitives) - numbers[:3], self._radius.take(primitives)
        b = dot(L, numbers[3:6])
        missed: Bools = b * b < numbers[7] ** 2 * (dot(L, L) * (1 - PAD) - R * R * (1 + PAD))
        return ~missed


class PlaneBoundingTest(BoundingTest):
    """Flat primitives by their planes and sides, grown by a pad.

    The crossings come from products that round as they like: some 2⁻⁴⁴ of the largest coordinate in
    play at the angles where culling is done, less than the pad, unless the plane is met at a small
    angle; there the answer is yes.

    Parameters
    ----------
    rays, t_max
        See `BoundingTest`.
    planes : (m, 1 + e, 4) float64
        Of each primitive, the unit normal N of its plane X·N = offset, and the offset; and of its
        sides unit vectors along the plane, inward, of which X·side is no less than the fourth
        number in the primitive; zero where a side is not told.
    pad : float
    """

    def __init__(self, rays: Rays, t_max: Floats, planes: Floats, pad: float) -> None:
        super().__init__(rays, t_max)
        self._planes, self._pad = planes, pad

    def all_pairs(self, some: slice, primitives: Index) -> Bools:
        """The crossing of each plane, by matrix products, is within t0, t_max and the sides."""
        P0, d = self._part(some)
        planes = self._planes.take(primitives, axis=0).transpose(1, 0, 2)
        flat = planes.reshape(-1, 4)
        along = (flat[:, :3] @ d).reshape(*planes.shape[:2], -1)
        ahead = (flat[:, 3:] - flat[:, :3] @ P0).reshape(*planes.shape[:2], -1)
        length, t0 = norm(d), self._rays.t0
        steep = np.abs(along[0]) > GRAZING * length
        t = ahead[0] / np.where(steep, along[0], 1.0)
        slack = self._pad / length
        begun = t >= (t0 if len(t0) == 1 else t0[some]) - slack
        within: Bools = begun & (t <= self._t_max[some] + slack)
        ahead -= self._pad
        for side, needed in zip(along[1:], ahead[1:], strict=True):
            within &= t * side >= needed
        within |= ~steep
        return within

    def pairs(self, of: Index, primitives: Index) -> Bools:
        """The same of single pairs: products with one column each would cost too much."""
        planes = self._planes.take(primitives, axis=0)
        numbers = self._table.take(of, axis=0).T
        P0, d, t0, length = numbers[:3], numbers[3:6], numbers[6], numbers[7]
        N, offset = planes[:, 0, :3].T, planes[:, 0, 3]
        slope = dot(N, d)
        steep = np.abs(slope) > GRAZING * length
        t = (offset - dot(N, P0)) / np.where(steep, slope, 1.0)
        slack = self._pad / length
        within: Bools = (t >= t0 - slack) & (t <= self._t_max.take(of) + slack)
        for k in range(1, planes.shape[1]):
            side = planes[:, k, :3].T
            within &= t * dot(side, d) >= planes[:, k, 3] - self._pad - dot(side, P0)
        within |= ~steep
        return within
