"""How rays that leave one point, or all go one way, project space onto a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from minirt.culling.bounding_tests import PAD
from minirt.rays import Rays
from minirt.vectors import Bools, Floats, cross, dot, norm, unit

#: A length that is none: nothing is divided by less.
NOTHING = 1e-250


@dataclass(frozen=True, eq=False)
class Projection:
    """Space in coordinates (x, y, depth), and its points as (u, v).

    If the rays leave one point, or nearly, (u, v) is (x, y)/depth; if they are parallel, (x, y).

    Attributes
    ----------
    frame : (3, 3) float64
        Unit vectors at right angles, along which x, y and depth are measured.
    origin : (3, 1) float64
        From where they are measured.
    central : bool
        Whether the rays leave one point.
    slope : float
        The largest |u| and |v| of any ray, of central ones.
    pad : float
        How far from a ray something may be that it still meets.
    close : float
        Depth up to which things are too close to be projected.
    """

    frame: Floats
    origin: Floats
    central: bool
    slope: float
    pad: float
    close: float

    def points(self, X: Floats) -> tuple[Floats, Floats, Floats]:
        """u, v and depth (k,) of points X (3, k); u and v of nothing where they are not ahead."""
        x, y, depth = self.frame @ (X - self.origin)
        if not self.central:
            return x, y, depth
        with np.errstate(all="ignore"):
            return x / depth, y / depth, depth

    def beyond(self, depth: Floats) -> Bools:
        """Whether things from that depth (k,) on can be drawn."""
        return depth > self.close if self.central else np.ones(depth.shape, dtype=np.bool_)

    def seen_size(self, length: Floats, depth: Floats) -> Floats:
        """How far from a point's (u, v), (k,), a ray's may be that passes within a length of it.

        +inf where the point is not `beyond`.
        """
        # |u·ε_z − ε_x| ≤ √(1 + u²)·|ε|
        size: Floats = length * ((1.0 + self.slope**2) ** 0.5 * (1.0 + PAD))
        if self.central:
            beyond = self.beyond(depth)
            size = np.divide(size, depth, out=np.full_like(size, np.inf), where=beyond)
        return size

    def grazes(self, X: Floats, N: Floats, far: Floats, sine: float) -> Bools:
        """Whether rays may meet, by a depth, planes at an angle of less than that sine, (k,).

        Parameters
        ----------
        X, N : (3, k) float64
            A point of each plane and its unit normal, good to six digits.
        far : (k,) float64
        sine : float
        """
        if self.central:
            distance, farthest = dot(N, X - self.origin), (1.0 + 2.0 * self.slope) * far
        else:
            distance, farthest = self.frame[2] @ N, np.ones(N.shape[1])
        grazing: Bools = np.abs(distance) <= 1.01 * sine * farthest
        return grazing


def axes_of(rays: Rays) -> tuple[Floats, Floats] | None:
    """The frame (3, 3) and the origin (3, 1) of the projection of rays; None if they have none."""
    if rays.one_origin:
        return _frame(*_screen(rays.directions)), rays.P0
    if rays.one_direction:
        low, high = rays.P0.min(axis=1, keepdims=True), rays.P0.max(axis=1, keepdims=True)
        return _frame(high - low, unit(rays.d)), (low + high) / 2
    return None


def _frame(along: Floats, ahead: Floats) -> Floats:
    """Three unit vectors as rows, at right angles: about along, and ahead (3, 1) of length one.

    Where `along` says next to nothing but `ahead`, the axis that is most across does.
    """
    across = along - dot(along, ahead) * ahead
    if not norm(across)[0] > 2.0**-10 * norm(along)[0]:
        across = np.zeros((3, 1))
        across[np.abs(ahead).argmin()] = 1.0
    for _ in range(2):  # the second time for the digits that the first has cancelled
        across = unit(across - dot(across, ahead) * ahead)
    return np.concatenate((across, cross(ahead, across), ahead), axis=1).T


def _screen(d: Floats) -> tuple[Floats, Floats]:
    """Vectors (3, 1) along a row of the screen that d (3, n) end on, and straight toward it.

    If there is no such screen, one across their mean.
    """
    along = d[:, 1:2] - d[:, :1]
    ahead = unit(cross(along, d[:, -1:] - d[:, :1]))
    distance = dot(ahead, d)
    if not np.ptp(distance) <= PAD * np.abs(distance[0]):
        return along, unit(unit(d).sum(axis=1, keepdims=True))
    return along, np.copysign(1.0, distance[0]) * ahead
