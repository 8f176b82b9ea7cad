"""Vertices and polygons as a file lists them, and the triangles they make."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from minirt.shapes.polygon import fan
from minirt.vectors import Floats

#: Most triangles of one mesh.
MAX_FACES = 10_000_000
#: Most vertices: as many as that many triangles have where none shares a vertex.
MAX_VERTICES = 3 * MAX_FACES


class MeshBuilder:
    """Collects vertices and polygons while a reader goes through a file.

    The methods that add raise ValueError for a malformed vertex or polygon, and as soon as the
    mesh is over `MAX_FACES` or `MAX_VERTICES`.
    """

    def __init__(self) -> None:
        self._points = array("d")
        self._indices = array("q")
        self._counts = array("q")

    @property
    def vertex_count(self) -> int:
        """How many vertices there are so far."""
        return len(self._points) // 3

    def add_vertex(self, numbers: Iterable[Any]) -> None:
        """Add one vertex: three numbers, as numbers or as text."""
        point = [float(x) for x in numbers]
        if len(point) != 3:
            raise ValueError(f"a vertex of {len(point)} numbers")
        self._points.extend(point)
        self._check()

    def add_vertices(self, points: NDArray[Any]) -> None:
        """Add vertices (k, 3) of any number type."""
        self._points.frombytes(np.ascontiguousarray(points, dtype=np.float64).tobytes())
        self._check()

    def add_polygon(self, indices: list[int]) -> None:
        """Add one polygon by its vertices' indices, 0 being the file's first vertex."""
        if len(indices) < 3:
            raise ValueError(f"a face of {len(indices)} vertices")
        self._indices.extend(indices)
        self._counts.append(len(indices))
        self._check()

    def add_polygons(self, indices: NDArray[Any]) -> None:
        """Add m polygons of k vertices each, as vertex indices (m, k)."""
        m, k = indices.shape
        if k < 3:
            raise ValueError(f"a face of {k} vertices")
        self._indices.frombytes(np.ascontiguousarray(indices, dtype=np.int64).tobytes())
        self._counts.frombytes(np.full(m, k, dtype=np.int64).tobytes())
        self._check()

    def vertices(self) -> Floats:
        """All vertices, (k, 3) float64."""
        return np.array(self._points, dtype=np.float64).reshape(-1, 3)

    def triangles(self) -> NDArray[np.int64]:
        """The fan of each polygon from its first vertex, (m, 3), polygon after polygon."""
        flat = np.array(self._indices, dtype=np.int64)
        counts = np.array(self._counts, dtype=np.int64)
        if (counts == 3).all():
            return flat.reshape(-1, 3)
        starts = np.cumsum(counts) - counts
        triangles, owners = [np.zeros((0, 3), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
        for k in np.unique(counts).tolist():
            which = np.flatnonzero(counts == k)
            polygons = flat[starts[which][:, None] + np.arange(k)]
            triangles.append(polygons[:, fan(k)].reshape(-1, 3))
            owners.append(np.repeat(which, k - 2))
        return np.concatenate(triangles)[np.argsort(np.concatenate(owners), kind="stable")]

    def _check(self) -> None:
        """Stop before memory runs out: m polygons of n indices in all make n − 2·m triangles."""
        triangles = len(self._indices) - 2 * len(self._counts)
        if triangles > MAX_FACES:
            raise ValueError(f"more than {MAX_FACES:,} triangles")
        if self.vertex_count > MAX_VERTICES:
            raise ValueError(f"more than {MAX_VERTICES:,} vertices")
