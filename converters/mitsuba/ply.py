"""Triangles as a binary PLY file: the vertices in float32, the faces in their order."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from minirt.vectors import Floats, Ints

_HEADER = """ply
format binary_little_endian 1.0
element vertex {vertices}
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
property float object_x
end_header
"""
_FACE = np.dtype([("count", "u1"), ("indices", "<i4", 3), ("object", "<f4")])


def write_ply(path: Path, vertices: Floats, faces: Ints, number: int) -> None:
    """Write one object.

    Each face carries the object's number as the attribute ``object_x``. Mitsuba's scene loader
    merges meshes of equal material into one, which would lose the objects; a mesh with an
    attribute it leaves alone. Other readers ignore it.

    Parameters
    ----------
    path : Path
    vertices : (k, 3) float64
        Rounded to float32, to nearest.
    faces : (m, 3) int32
        Vertex indices, degenerate faces included.
    number : int
        The object's index in the scene.
    """
    table = np.zeros(len(faces), dtype=_FACE)
    table["count"], table["indices"], table["object"] = 3, faces, number
    header = _HEADER.format(vertices=len(vertices), faces=len(faces)).encode()
    path.write_bytes(header + vertices.astype("<f4").tobytes() + table.tobytes())
