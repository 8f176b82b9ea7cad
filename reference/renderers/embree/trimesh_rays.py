"""Intersect rays with a list of triangles, by trimesh's own engine, in NumPy and float64."""

from __future__ import annotations

import importlib
from importlib import metadata

import numpy as np
from numpy.typing import NDArray

from minirt.vectors import Bools, Floats, cross, dot, norm, unit
from reference.renderers.embree.rays import RayHits

#: Relative rounding error of the cross product of two edges: vertices of up to 1 are known to
#: 2⁻⁵³, edges of 2⁻¹⁰ to 2⁻⁴³ of their length, and three more roundings make it some 2⁻⁴⁰.
_NOISE = 2.0**-40
#: Rays in one pass: the engine lists every candidate of each.
_CHUNK = 4096


class TrimeshEngine:
    """trimesh's `ray_triangle` lists every hit of each ray; the nearest one is kept.

    Parameters
    ----------
    corners : (m, 3, 3) float64
        Triangle, corner, coordinate. Triangles whose normal is not larger than its rounding error
        are left out: trimesh would report hits anywhere in their plane.
    """

    def __init__(self, corners: Floats) -> None:
        self._engine = importlib.import_module("trimesh.ray.ray_triangle")
        self.program = f"trimesh {metadata.version('trimesh')}, its own engine for want of embreex"
        a, b, c = np.moveaxis(corners, (1, 2), (0, 1))
        normal = cross(b - a, c - a)
        noise = _NOISE * norm(b - a) * norm(c - a)
        self._number = np.flatnonzero(norm(normal) > noise)
        self._corners, self._normal = corners[self._number], unit(normal[:, self._number])

    def nearest(self, origins: Floats, directions: Floats) -> RayHits:
        """First hits of rays (3, n) with unit directions."""
        n = origins.shape[1]
        distance, first = np.full(n, np.inf), np.full(n, -1)
        for start in range(0, n if len(self._number) else 0, _CHUNK):
            part = slice(start, start + _CHUNK)
            triangle, ray, ahead = self._all_hits(origins[:, part], directions[:, part])
            farthest_first = np.argsort(-ahead)
            ray, ahead = ray[farthest_first] + start, ahead[farthest_first]
            distance[ray], first[ray] = ahead, triangle[farthest_first]
        hit = np.flatnonzero(first >= 0)
        uv, normal, number = np.zeros((2, n)), np.full((3, n), np.nan), np.full(n, -1)
        M = origins[:, hit] + distance[hit] * directions[:, hit]
        uv[:, hit] = self._weights(M, first[hit])
        normal[:, hit], number[hit] = self._normal[:, first[hit]], self._number[first[hit]]
        return RayHits(number, distance, uv, normal)

    def occluded(self, origins: Floats, directions: Floats) -> Bools:
        """Whether rays (3, n) meet anything, (n,)."""
        return np.isfinite(self.nearest(origins, directions).distance)

    def _all_hits(
        self, origins: Floats, directions: Floats
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
        """Triangle, ray and distance > 0 of every hit."""
        triangle, ray, place = self._engine.ray_triangle_id(
            triangles=self._corners,
            ray_origins=origins.T,
            ray_directions=directions.T,
            triangles_normal=self._normal.T,
            tree=_Boxes(self._corners),
        )
        ahead = dot(place.reshape(-1, 3).T - origins[:, ray], directions[:, ray])
        return triangle[ahead > 0], ray[ahead > 0], ahead[ahead > 0]

    def _weights(self, M: Floats, number: NDArray[np.int64]) -> Floats:
        """Weights (2, n) of the second and third corners of triangles at their points M."""
        a, b, c = np.moveaxis(self._corners[number], (1, 2), (0, 1))
        normal = cross(b - a, c - a)
        whole = dot(normal, normal)
        beta, gamma = dot(cross(c - M, a - M), normal), dot(cross(a - M, b - M), normal)
        return np.stack((beta / whole, gamma / whole))


class _Boxes:
    """The part of an R-tree that trimesh uses, as a comparison with every box."""

    def __init__(self, corners: Floats) -> None:
        self._lower, self._upper = corners.min(axis=1).T, corners.max(axis=1).T
        self.bounds = np.concatenate((self._lower.min(axis=1), self._upper.max(axis=1)))

    def intersection(self, bounds: Floats) -> NDArray[np.intp]:
        """Numbers of the triangles whose boxes meet a box (x, y, z, x', y', z')."""
        low, high = bounds[:3, None], bounds[3:, None]
        return np.flatnonzero(((self._lower <= high) & (self._upper >= low)).all(axis=0))
