"""Mitsuba's answers as a frame: back in scene units, in minirt's conventions."""

from __future__ import annotations

import numpy as np

from converters.placement import Placement
from minirt.scene import Scene
from minirt.vectors import Bools, Floats, dot, unit
from reference.renderers.mitsuba import trace as columns
from reference.renderers.pixel_arrays import PixelArrays, Values, faceted, indexed


def frame_arrays(scene: Scene, placement: Placement, answers: Floats) -> dict[str, Values]:
    """Every geometric quantity of a frame.

    Parameters
    ----------
    answers : (columns, n) float64
        Of `mitsuba_trace.primary`, a column a pixel, top row first.
    """
    hit = answers[columns.VALID] == 1
    number = np.where(hit, answers[columns.OBJECT], -1).astype(np.int32)
    triangle = np.where(hit, answers[columns.TRIANGLE], -1).astype(np.int32)
    position = answers[columns.POSITION]
    pixels = PixelArrays(scene)
    pixels.put("ray", answers[columns.DIRECTION], np.ones_like(hit))
    pixels.put_hits(number, triangle, _distance(scene, placement, answers))
    pixels.put("position", placement.back(position.T).T, hit)
    pixels.put("barycentric", answers[columns.UV], faceted(scene, number))
    pixels.put("normal", answers[columns.NORMAL], hit)
    pixels.put("shadow", answers[columns.SHADOW], hit)
    _put_secondary(pixels, "reflection", answers[columns.REFLECTED], position, hit, placement)
    glassy = indexed(scene, number)
    total = glassy & (answers[columns.TOTAL] == 1)
    pixels.put("tir", total, glassy)
    passing = glassy & ~total
    _put_secondary(pixels, "refraction", answers[columns.REFRACTED], position, passing, placement)
    return pixels.arrays


def _distance(scene: Scene, placement: Placement, answers: Floats) -> Floats:
    """Distance from the observer in scene units: Mitsuba's rays start at its near plane."""
    observer = placement.points(np.array(scene.screen.P0)).reshape(3, 1)
    direction = unit(answers[columns.DIRECTION])
    start = dot(answers[columns.ORIGIN] - observer, direction)
    distance: Floats = (start + answers[columns.T]) / placement.scale
    return distance


def _put_secondary(
    pixels: PixelArrays,
    name: str,
    answers: Floats,
    position: Floats,
    where: Bools,
    placement: Placement,
) -> None:
    """A spawned ray's direction and what it hits, measured from the point where it was spawned."""
    direction = answers[columns.DIRECTION_2]
    offset = dot(answers[columns.ORIGIN_2] - position, direction)
    met = where & (answers[columns.VALID_2] == 1)
    pixels.put(name, direction, where)
    pixels.put(f"{name}_object", answers[columns.OBJECT_2], met)
    pixels.put(f"{name}_t", (offset + answers[columns.T_2]) / placement.scale, met)
