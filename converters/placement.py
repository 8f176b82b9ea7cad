"""From scene coordinates to those of a float32 renderer: p' = scale · (p − center)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from minirt.scene import Scene
from minirt.vectors import Floats

#: Extents between these bounds are left as they are.
COMFORTABLE = (1.0, 64.0)


@dataclass(frozen=True)
class Placement:
    """A uniform scale and a translation; directions and t keep their values, lengths scale.

    A scale that is a power of two adds no rounding. A center near the scene saves the digits that
    float32 would spend on a large distance from the origin.

    Attributes
    ----------
    scale : float
        A power of two.
    center : tuple of 3 float
        The point that becomes the origin, in scene units.
    """

    scale: float = 1.0
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def points(self, points: Floats) -> Floats:
        """Points (..., 3) in the renderer's coordinates, still float64."""
        placed: Floats = self.scale * (np.asarray(points, dtype=np.float64) - self.center)
        return placed

    def back(self, points: Floats) -> Floats:
        """Points (..., 3) of the renderer in scene units."""
        restored: Floats = points / self.scale + self.center
        return restored

    def length(self, length: float) -> float:
        """A length in the renderer's coordinates."""
        return self.scale * length


#: Scene coordinates, unchanged.
IDENTITY = Placement()


def fitted_placement(scene: Scene) -> Placement:
    """The placement with the least rounding in float32; `IDENTITY` where that is good enough.

    That is where the extent lies within `COMFORTABLE` and no coordinate is larger than twice the
    extent: float32 then loses at most one bit more than in a perfect placement. Otherwise the
    middle of objects and observer becomes the origin and the extent falls within [32, 64).
    """
    low, high = _bounds(scene)
    largest = float(np.maximum(np.abs(low), np.abs(high)).max())
    if COMFORTABLE[0] <= scene.extent <= COMFORTABLE[1] and largest <= 2 * scene.extent:
        return IDENTITY
    return centered_placement(scene, 6)


def centered_placement(scene: Scene, size: int = 0) -> Placement:
    """The placement with the middle of objects and observer at the origin, and a given extent.

    Parameters
    ----------
    scene : Scene
    size : int
        The extent falls within [2**(size − 1), 2**size).
    """
    low, high = _bounds(scene)
    exponent = math.frexp(scene.extent)[1]  # extent = m · 2**exponent, ½ ≤ m < 1
    x, y, z = (0.5 * low + 0.5 * high).tolist()
    return Placement(2.0 ** (size - exponent), (x, y, z))


def reach(scene: Scene, placement: Placement) -> float:
    """Largest coordinate of the placed scene, observer included, in the renderer's units."""
    return float(np.abs(placement.points(np.stack(_bounds(scene)))).max())


def _bounds(scene: Scene) -> tuple[Floats, Floats]:
    observer = np.array(scene.screen.P0)
    if scene.bounds is None:
        return observer, observer
    return np.minimum(scene.bounds[0], observer), np.maximum(scene.bounds[1], observer)
