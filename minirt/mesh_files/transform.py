"""Affine maps of points, elementwise and in a fixed order: the same bits on every CPU."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from minirt.vectors import Floats

#: Three rows of four; the fourth row of the 4 × 4 matrix is 0 0 0 1.
Matrix: TypeAlias = tuple[tuple[float, ...], ...]

IDENTITY: Matrix = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))


def transform_points(matrix: Sequence[Sequence[float]], points: Floats) -> Floats:
    """Points (k, 3) under an affine map; only the matrix's first three rows are read."""
    x, y, z = points.T
    return np.stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in matrix[:3]], axis=1)


def after(outer: Matrix, inner: Matrix) -> Matrix:
    """The map that applies `inner`, then `outer`."""
    columns = list(zip(*inner, strict=True))
    rows = []
    for a, b, c, d in outer:
        moved = [a * x + b * y + c * z for x, y, z in columns]
        rows.append((*moved[:3], moved[3] + d))
    return tuple(rows)


def determinant(matrix: Matrix) -> float:
    """The determinant of the linear part; negative where the map mirrors."""
    (a, b, c, _), (d, e, f, _), (g, h, i, _) = matrix
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def trs(translation: Sequence[float], rotation: Sequence[float], scale: Sequence[float]) -> Matrix:
    """The map that scales, then rotates by the unit quaternion (x, y, z, w), then translates.

    Parameters
    ----------
    translation, scale : 3 float
    rotation : 4 float

    Source: glTF 2.0 specification, section 3.5.3.
    """
    x, y, z, w = map(float, rotation)
    rotated = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    sizes = [float(s) for s in scale]
    return tuple(
        (*(r * s for r, s in zip(row, sizes, strict=True)), float(shift))
        for row, shift in zip(rotated, translation, strict=True)
    )
