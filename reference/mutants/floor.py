"""The sensitivity floor: the smallest planted errors that the checks catch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from minirt.frame import Array, Frame
from minirt.vectors import Floats, unit
from reference.mutants.scenes import SCENES, MeasuredScene, measured_atlas_scene

#: How often planted errors are halved: down to half an ulp of 1, which no float64 represents.
_HALVINGS = 53


@dataclass(frozen=True)
class Floor:
    """The smallest errors that are caught, on the first scene of the matrix.

    Attributes
    ----------
    pixels : int
        Wrong pixels of a shadow mask.
    depth, angle, colour : float
        Powers of two: relative error of all depths, turn of all normals in radians, relative error
        of all colours; +inf where nothing is caught.
    """

    pixels: int
    depth: float
    angle: float
    colour: float


def sensitivity_floor() -> Floor:
    """Plant smaller and smaller errors into minirt's own frame until they pass."""
    measured = measured_atlas_scene(SCENES[0])
    return Floor(
        _fewest_pixels(measured),
        _smallest(measured, "depth", lambda values, e: values * (1 + e)),
        _smallest(measured, "normal", _turned),
        _smallest(measured, "color", lambda values, e: values * (1 + e)),
    )


def _fewest_pixels(measured: MeasuredScene) -> int:
    """The smallest number of wrong pixels of the shadow mask that is caught; 0 if none is."""
    shadow = measured.exact.frame["shadow"]
    certain = np.flatnonzero(measured.stability.certain["shadow"] & (shadow >= 0))
    for count in range(1, len(certain) + 1):
        wrong = shadow.copy().reshape(-1)
        wrong[certain[:count]] ^= 1
        if _caught(measured, "shadow", wrong.reshape(shadow.shape)):
            return count
    return 0


def _smallest(measured: MeasuredScene, name: str, change: Callable[[Array, float], Array]) -> float:
    """The smallest error, a power of two, of a quantity that is caught."""
    caught = float("inf")
    for k in range(1, _HALVINGS + 1):
        with np.errstate(invalid="ignore"):
            changed = change(measured.exact.frame[name], 2.0**-k)
        if not _caught(measured, name, changed):
            break
        caught = 2.0**-k
    return caught


def _turned(normals: Floats, angle: float) -> Floats:
    """Each turned by a small angle, towards an axis that it is not parallel to."""
    s = np.moveaxis(normals, 2, 0)
    axis = np.zeros_like(s)
    np.put_along_axis(axis, np.abs(np.nan_to_num(s)).argmin(axis=0)[None], 1.0, axis=0)
    along: Floats = (axis * s).sum(axis=0)
    turned: Floats = np.moveaxis(unit(s + np.tan(angle) * unit(axis - along * s)), 0, 2)
    return turned


def _caught(measured: MeasuredScene, name: str, values: Array) -> bool:
    """Whether a frame that holds only this quantity fails."""
    return not measured.compare(Frame({name: values})).passed
