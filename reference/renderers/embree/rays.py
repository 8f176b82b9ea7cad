"""Intersect rays with a list of triangles, by Embree."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from importlib import metadata
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from minirt.vectors import Bools, Floats, unit


@dataclass(frozen=True, eq=False)
class RayHits:
    """The first hits of n rays.

    Attributes
    ----------
    triangle : (n,) int64
        Index in the list of triangles; −1 for none.
    distance : (n,) float64
        Along the unit direction; +inf for none.
    uv : (2, n) float64
        Weights of the second and third corner.
    normal : (3, n) float64
        Unit, by the right-hand rule of the corners; undefined where nothing is hit.
    """

    triangle: NDArray[np.int64]
    distance: Floats
    uv: Floats
    normal: Floats


class Engine(Protocol):
    """A program that intersects rays with triangles."""

    program: str

    def __init__(self, corners: Floats) -> None:
        """Triangles (m, 3, 3): triangle, corner, coordinate."""

    def nearest(self, origins: Floats, directions: Floats) -> RayHits:
        """First hits of rays (3, n) with unit directions."""

    def occluded(self, origins: Floats, directions: Floats) -> Bools:
        """Whether rays (3, n) meet anything, (n,)."""


class Embree:
    """Embree's robust (watertight) mode, in float32, through embreex.

    trimesh's wrapper of the same library scales the mesh and returns neither weights nor normals,
    so the library is called directly.

    Parameters
    ----------
    corners : (m, 3, 3) float64
        Triangle, corner, coordinate.
    """

    def __init__(self, corners: Floats) -> None:
        scenes = importlib.import_module("embreex.rtcore_scene")
        meshes = importlib.import_module("embreex.mesh_construction")
        self.program = f"Embree, embreex {metadata.version('embreex')}"
        self._scene = scenes.EmbreeScene(robust=True)
        if len(corners):
            meshes.TriangleMesh(self._scene, corners.astype(np.float32))

    def nearest(self, origins: Floats, directions: Floats) -> RayHits:
        """First hits of rays (3, n) with unit directions."""
        found = self._scene.run(_rows(origins), _rows(directions), output=True)
        number = found["primID"].astype(np.int64)
        distance = np.where(number >= 0, found["tfar"].astype(np.float64), np.inf)
        uv = np.stack((found["u"], found["v"])).astype(np.float64)
        return RayHits(number, distance, uv, unit(found["Ng"].astype(np.float64).T))

    def occluded(self, origins: Floats, directions: Floats) -> Bools:
        """Whether rays (3, n) meet anything, (n,)."""
        found = self._scene.run(_rows(origins), _rows(directions), query="OCCLUDED")
        dark: Bools = found >= 0
        return dark


def _rows(vectors: Floats) -> NDArray[np.float32]:
    return np.ascontiguousarray(vectors.T.astype(np.float32))
