"""Mitsuba's answers as a frame: back in scene units, in minirt's conventions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from converters.placement import Placement
from minirt.quantities import QUANTITIES
from minirt.scene import Scene, Sphere
from minirt.vectors import Bools, Floats, dot, unit
from reference.renderers import mitsuba_trace as columns
from reference.renderers.screen_rays import direction_lengths

Arrays = dict[str, NDArray[Any]]


def frame_arrays(scene: Scene, placement: Placement, answers: Floats) -> Arrays:
    """Every geometric quantity of a frame.

    Parameters
    ----------
    answers : (columns, n) float64
        Of `mitsuba_trace.primary`, a column a pixel, top row first.
    """
    hit = answers[columns.VALID] == 1
    direction = answers[columns.DIRECTION]
    position = answers[columns.POSITION]
    distance = _distance(scene, placement, answers)
    t = distance / direction_lengths(scene.screen)
    flat = [not isinstance(thing, Sphere) for thing in scene.objects]
    number = np.where(hit, answers[columns.OBJECT], -1)
    faceted = hit & np.array([*flat, False])[number.astype(np.int64)]
    image = _Image(scene)
    image.put("ray", direction, np.ones_like(hit))
    image.put("hit", hit, np.ones_like(hit))
    image.put("object", number, hit)
    image.put("triangle", np.where(faceted, answers[columns.TRIANGLE], 0), hit)
    image.put("t", t, hit)
    image.put("depth", t * abs(scene.screen.nu), hit)
    image.put("distance", distance, hit)
    image.put("position", placement.back(position.T).T, hit)
    image.put("barycentric", answers[columns.UV], faceted)
    image.put("normal", answers[columns.NORMAL], hit)
    image.put("shadow", answers[columns.SHADOW], hit)
    _put_secondary(image, "reflection", answers[columns.REFLECTED], position, hit, placement)
    indexed = [scene.materials[thing.material].ior is not None for thing in scene.objects]
    glassy = hit & np.array([*indexed, False])[number.astype(np.int64)]
    total = glassy & (answers[columns.TOTAL] == 1)
    image.put("tir", total, glassy)
    passing = glassy & ~total
    _put_secondary(image, "refraction", answers[columns.REFRACTED], position, passing, placement)
    return image.arrays


class _Image:
    """Arrays of a frame, filled where they apply and missing elsewhere."""

    def __init__(self, scene: Scene) -> None:
        self.arrays: Arrays = {}
        self._size = scene.screen.ny, scene.screen.nx

    def put(self, name: str, values: NDArray[Any], where: Bools) -> None:
        """Set a quantity from (n,) or (k, n) values at the pixels `where`, (n,)."""
        quantity = QUANTITIES[name]
        array = quantity.missing(*self._size)
        array.reshape(len(where), -1)[where] = values.reshape(-1, len(where)).T[where]
        self.arrays[name] = array


def _distance(scene: Scene, placement: Placement, answers: Floats) -> Floats:
    """Distance from the observer in scene units: Mitsuba's rays start at its near plane."""
    observer = placement.points(np.array(scene.screen.P0)).reshape(3, 1)
    direction = unit(answers[columns.DIRECTION])
    start = dot(answers[columns.ORIGIN] - observer, direction)
    distance: Floats = (start + answers[columns.T]) / placement.scale
    return distance


def _put_secondary(
    image: _Image, name: str, answers: Floats, position: Floats, where: Bools, placement: Placement
) -> None:
    """A spawned ray's direction and what it meets, measured from the point where it was spawned."""
    direction = answers[columns.DIRECTION_2]
    offset = dot(answers[columns.ORIGIN_2] - position, direction)
    met = where & (answers[columns.VALID_2] == 1)
    image.put(name, direction, where)
    image.put(f"{name}_object", answers[columns.OBJECT_2], met)
    image.put(f"{name}_t", (offset + answers[columns.T_2]) / placement.scale, met)
