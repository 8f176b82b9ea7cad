"""STL, binary and ASCII: triangles that share no vertex."""

from __future__ import annotations

import re

import numpy as np

from minirt.mesh_files.soup import Soup

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


def read_stl(data: bytes) -> Soup:
    """Triangles in the file's order; its normals are left out: the vertices' order gives them.

    A file whose length is the one that its count of triangles asks for is binary, else it is
    ASCII: binary files that begin with ``solid`` exist.

    Raises
    ------
    ValueError
        Neither a whole binary file nor a whole ASCII one.
    """
    soup = Soup()
    if len(data) >= _HEADER_BYTES:
        count = int.from_bytes(data[_HEADER_BYTES - 4 : _HEADER_BYTES], "little")
        if len(data) == _HEADER_BYTES + count * _FACET.itemsize:
            facets = np.frombuffer(data, dtype=_FACET, offset=_HEADER_BYTES)
            soup.add_vertices(facets["corners"].reshape(-1, 3))
            soup.add_polygons(np.arange(3 * count).reshape(-1, 3))
            return soup
    _read_text(data, soup)
    return soup


def _read_text(data: bytes, soup: Soup) -> None:
    data, place = data.rstrip(), 0
    while place < len(data):
        solid = _SOLID.match(data, place)
        if solid is None:
            raise ValueError(
                "neither binary, with the length that its count asks for, nor ASCII: "
                f"no 'solid' at byte {place}"
            )
        place = _read_facets(data, solid.end(), soup)


def _read_facets(data: bytes, place: int, soup: Soup) -> int:
    """Facets up to the solid's end, and where that is."""
    while (face := _FACE.match(data, place)) is not None:
        first = soup.vertex_count
        numbers = face.groups()
        for k in (0, 3, 6):
            soup.add_vertex(numbers[k : k + 3])
        soup.add_polygon([first, first + 1, first + 2])
        place = face.end()
    end = _END.match(data, place)
    if end is None:
        raise ValueError(f"neither a facet nor 'endsolid' at byte {place}")
    return end.end()
