"""STL, binary and ASCII: triangles that share no vertex."""

from __future__ import annotations

import re

import numpy as np

from minirt.mesh_files.builder import MeshBuilder

_HEADER_BYTES = 84
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_WORD = rb"[^\s]+"
_FACE = re.compile(
    rb"\s*facet\s+normal(?:\s+%b){3}\s+outer\s+loop" % _WORD
    + rb"\s+vertex\s+(%b)\s+(%b)\s+(%b)" % (_WORD, _WORD, _WORD) * 3
    + rb"\s+endloop\s+endfacet\b",
    re.IGNORECASE,
)
_SOLID = re.compile(rb"\s*solid\b[^\n]*", re.IGNORECASE)
_END = re.compile(rb"\s*endsolid\b[^\n]*", re.IGNORECASE)


def read_stl(data: bytes) -> MeshBuilder:
    """Triangles in the file's order; its normals are ignored: the vertices' order gives them.

    A file of exactly the length that its count of triangles implies is binary, any other is
    ASCII: the word ``solid`` at the beginning decides nothing, since binary files have it too.

    Raises
    ------
    ValueError
        Neither a complete binary file nor a complete ASCII one.
    """
    mesh = MeshBuilder()
    if len(data) >= _HEADER_BYTES:
        count = int.from_bytes(data[_HEADER_BYTES - 4 : _HEADER_BYTES], "little")
        if len(data) == _HEADER_BYTES + count * _FACET.itemsize:
            facets = np.frombuffer(data, dtype=_FACET, offset=_HEADER_BYTES)
            mesh.add_vertices(facets["corners"].reshape(-1, 3))
            mesh.add_polygons(np.arange(3 * count).reshape(-1, 3))
            return mesh
    _read_text(data, mesh)
    return mesh


def _read_text(data: bytes, mesh: MeshBuilder) -> None:
    data, place = data.rstrip(), 0
    while place < len(data):
        solid = _SOLID.match(data, place)
        if solid is None:
            raise ValueError(
                "neither binary, of the length that its count implies, nor ASCII: "
                f"no 'solid' at byte {place}"
            )
        place = _read_facets(data, solid.end(), mesh)


def _read_facets(data: bytes, place: int, mesh: MeshBuilder) -> int:
    """Add the facets up to the solid's end; returns where that is."""
    while (face := _FACE.match(data, place)) is not None:
        first = mesh.vertex_count
        numbers = face.groups()
        for k in (0, 3, 6):
            mesh.add_vertex(numbers[k : k + 3])
        mesh.add_polygon([first, first + 1, first + 2])
        place = face.end()
    end = _END.match(data, place)
    if end is None:
        raise ValueError(f"neither a facet nor 'endsolid' at byte {place}")
    return end.end()
