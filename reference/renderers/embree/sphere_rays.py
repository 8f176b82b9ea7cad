"""Intersect rays with spheres, by a formula that is used nowhere else.

Embree is given triangles only; this takes the place of the callback of an Embree user geometry.
Half a chord is computed at a time: from the ray's start to the foot of the perpendicular from the
centre, and from there to the sphere by Pythagoras. No quadratic equation is solved, and none of
minirt's rules is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from minirt.vectors import Bools, Floats, dot

#: Ray–sphere pairs in one pass: intermediate results then stay in the processor's cache.
_PAIRS = 2**17
#: Margin for the rounding of a squared distance, in coordinates of at most 1.
_MARGIN = 1e-12


@dataclass(frozen=True, eq=False)
class SphereSet:
    """Spheres: center (3, m) and radius (m,), in coordinates of at most 1."""

    center: Floats
    radius: Floats

    def nearest(self, origins: Floats, directions: Floats) -> tuple[NDArray[np.intp], Floats]:
        """Number of the first sphere (−1: none) and distance (+inf) for rays (3, n)."""
        n, m = origins.shape[1], len(self.radius)
        number, distance = np.full(n, -1), np.full(n, np.inf)
        size = max(1, _PAIRS // max(1, m))
        for start in range(0, n if m else 0, size):
            part = slice(start, start + size)
            O, d = origins[:, part], directions[:, part]
            ray, ball = np.nonzero(self._near(O, d))
            ahead = self._distance(O[:, ray], d[:, ray], ball)
            farthest_first = np.argsort(-ahead, kind="stable")
            ray, ball, ahead = ray[farthest_first], ball[farthest_first], ahead[farthest_first]
            distance[start + ray], number[start + ray] = ahead, ball
        return np.where(np.isfinite(distance), number, -1), distance

    def _near(self, O: Floats, d: Floats) -> Bools:
        """Whether lines may meet spheres, (n, m): by matrix products, with a margin."""
        foot = d.T @ self.center - dot(d, O)[:, None]
        apart = dot(self.center, self.center) - 2.0 * (O.T @ self.center) + dot(O, O)[:, None]
        near: Bools = apart - foot * foot <= self.radius * self.radius + _MARGIN
        return near

    def _distance(self, O: Floats, d: Floats, ball: NDArray[np.intp]) -> Floats:
        """Distance (n,) to the sphere of each ray; +inf where it is missed or behind."""
        to_center, radius = self.center[:, ball] - O, self.radius[ball]
        foot = dot(to_center, d)
        across = to_center - foot * d
        with np.errstate(invalid="ignore"):
            half = np.sqrt(radius * radius - dot(across, across))
        first = np.where(foot - half > 0, foot - half, foot + half)
        return np.where(first > 0, first, np.inf)
