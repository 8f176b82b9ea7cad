"""The sensitivity floor: the smallest errors that the checks catch, found by planting them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from minirt.frame import Array, Frame
from minirt.vectors import Floats, unit
from reference.mutants.matrix import SCENES, Bench, atlas_bench

#: Planted errors are halved down to this one, half an ulp of 1, which no float64 can hold.
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
    bench = atlas_bench(SCENES[0])
    return Floor(
        _fewest_pixels(bench),
        _smallest(bench, "depth", lambda values, e: values * (1 + e)),
        _smallest(bench, "normal", _turned),
        _smallest(bench, "color", lambda values, e: values * (1 + e)),
    )


def _fewest_pixels(bench: Bench) -> int:
    """The fewest wrong pixels of the shadow mask that are caught, wherever they lie; 0: none."""
    shadow = bench.exact.frame["shadow"]
    certain = np.flatnonzero(bench.stability.certain["shadow"] & (shadow >= 0))
    for count in range(1, len(certain) + 1):
        wrong = shadow.copy().reshape(-1)
        wrong[certain[:count]] ^= 1
        if _caught(bench, "shadow", wrong.reshape(shadow.shape)):
            return count
    return 0


def _smallest(bench: Bench, name: str, spoil: Callable[[Array, float], Array]) -> float:
    """The smallest power of two by which a quantity may not be spoilt."""
    caught = float("inf")
    for k in range(1, _HALVINGS + 1):
        with np.errstate(invalid="ignore"):
            spoilt = spoil(bench.exact.frame[name], 2.0**-k)
        if not _caught(bench, name, spoilt):
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


def _caught(bench: Bench, name: str, values: Array) -> bool:
    """Whether a frame that holds only this quantity fails."""
    return not bench.judge(Frame({name: values})).passed
