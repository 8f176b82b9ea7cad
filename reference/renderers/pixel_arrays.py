"""Turn a renderer's answers, one for each pixel, into a frame's arrays in minirt's conventions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from minirt.quantities import QUANTITIES
from minirt.scene import Scene, Sphere
from minirt.screen import VirtualScreen, image_pixels, pixel_center
from minirt.vectors import Bools, Floats, Ints

Values = NDArray[Any]


class PixelArrays:
    """Arrays of a frame, set where they have a value and marked as missing elsewhere.

    Attributes
    ----------
    arrays : dict of str to array
        As a frame holds them.
    """

    def __init__(self, scene: Scene) -> None:
        self.arrays: dict[str, Values] = {}
        self._scene = scene

    def put(self, name: str, values: Values, where: Bools) -> None:
        """Set a quantity from values (n,) or (k, n), top row first, at the pixels `where` (n,)."""
        screen = self._scene.screen
        array = QUANTITIES[name].missing(screen.ny, screen.nx)
        array.reshape(len(where), -1)[where] = values.reshape(-1, len(where)).T[where]
        self.arrays[name] = array

    def put_hits(self, number: Ints, triangle: Ints, distance: Floats) -> None:
        """Set every quantity that follows from the object that is hit and its distance.

        Parameters
        ----------
        number : (n,) int32
            Object; −1 where nothing is hit.
        triangle : (n,) int32
            Face; ignored on spheres.
        distance : (n,) float64
            From the observer, in scene units.
        """
        hit, t = number >= 0, distance / direction_lengths(self._scene.screen)
        self.put("hit", hit, hit)
        self.put("object", number, hit)
        self.put("triangle", np.where(faceted(self._scene, number), triangle, 0), hit)
        self.put("t", t, hit)
        self.put("depth", t * abs(self._scene.screen.nu), hit)
        self.put("distance", distance, hit)


def faceted(scene: Scene, number: Ints) -> Bools:
    """Whether each object is made of triangles, for objects (n,), −1 for none."""
    flat = [not isinstance(thing, Sphere) for thing in scene.objects]
    return np.array([*flat, False])[number]


def indexed(scene: Scene, number: Ints) -> Bools:
    """Whether each object's material has an index of refraction, for objects (n,), −1 for none."""
    has = [scene.materials[thing.material].ior is not None for thing in scene.objects]
    return np.array([*has, False])[number]


def direction_lengths(screen: VirtualScreen) -> Floats:
    """‖d‖ of every pixel's ray, (ny·nx,) float64, top row first: t is distance over this."""
    u_s, v_s = pixel_center(screen, *image_pixels(screen, np.arange(screen.nx * screen.ny)))
    return np.sqrt(u_s * u_s + v_s * v_s + screen.nu * screen.nu)
