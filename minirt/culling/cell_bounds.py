"""The rays of a cell of pixels, bounded together, so that all are known to miss a primitive."""

from __future__ import annotations

import numpy as np

from minirt.culling.bounding_tests import GRAZING, PAD
from minirt.vectors import Bools, Floats, dot


class CellRays:
    """The rays of b cells, each as a middle one, and how far the others stray.

    Parameters
    ----------
    P0 : (3, 1) float64
        The origin of all.
    low, high : (3, b) float64
        The least and the largest that each number of a cell's directions may be.

    Attributes
    ----------
    P0 : (3, 1) float64
    d : (3, b) float64
        The middle directions.
    turn : (b,) float64
        The largest ‖difference‖ of any ray's d from that.
    slowest, fastest : (b,) float64
        Bounds of ‖d‖ of all rays.
    """

    def __init__(self, P0: Floats, low: Floats, high: Floats) -> None:
        self.P0, self.d, half = P0, (low + high) / 2, (high - low) / 2
        stray = np.sqrt((half * half).sum(axis=0)) + PAD * np.abs(self.d).max(axis=0)
        self.turn = stray * (1 + PAD)
        self.squared = (self.d * self.d).sum(axis=0)
        length = np.sqrt(self.squared)
        self.slowest = np.maximum(length * (1 - PAD) - self.turn, 0.0)
        self.fastest = length * (1 + PAD) + self.turn

    def meet_spheres(self, center: Floats, radius: Floats) -> Bools:
        """Whether any ray of each cell may meet spheres (k,), (k, b).

        That is where the middle ray passes within R of the centre, grown by how far others stray:
        at t they are within t·turn of it, and they touch the sphere by t = distance/‖d‖ of its
        farthest point.
        """
        L, R = (center - self.P0)[:, :, None], radius[:, None]
        LL, b = dot(L, L), dot(L, self.d[:, None])
        with np.errstate(all="ignore"):  # not together
            R = R + self.turn / self.slowest * (np.sqrt(LL) * (1 + PAD) + R)
            apart = LL * (1 - PAD) - R * R * (1 + PAD)
            missed: Bools = (apart > 0) & ((b < 0) | (b * b < self.squared * apart))
        return ~missed

    def meet_planes(self, planes: Floats, pad: float) -> Bools:
        """Whether any ray of each cell may meet flat primitives (k,), (k, b).

        Intervals hold what `PlaneBoundingTest` computes of each ray, unless some graze the plane.
        Crossings behind the origin, up to the pad, are taken to be there: the pad counts twice.
        """
        along = planes[:, :, :3] @ self.d
        ahead = planes[:, :, 3:] - planes[:, :, :3] @ self.P0
        turn, slack = self.turn, 2.0 * pad
        with np.errstate(all="ignore"):  # not together, or grazing
            slope, gap = np.abs(along[:, 0]), np.copysign(1.0, along[:, 0]) * ahead[:, 0]
            least, most = slope - turn, slope + turn
            first, last = gap - slack, gap + slack
            first = np.maximum(np.minimum(first / least, first / most), 0.0)
            last = np.maximum(last / least, last / most)
            missed: Bools = last < 0
            for k in range(1, planes.shape[1]):
                side, needed = along[:, k] + turn, ahead[:, k] - slack
                missed |= np.maximum(first * side, last * side) < needed
        missed &= least > GRAZING * self.fastest
        return ~missed
