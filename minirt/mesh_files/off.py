"""Object File Format: counts, vertices, faces."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator

from minirt.mesh_files.builder import MeshBuilder

_KEYWORD = re.compile(rb"(ST)?C?N?OFF")


def read_off(data: bytes) -> MeshBuilder:
    """Vertices and faces in the file's order; colours, normals and comments are ignored.

    Raises
    ------
    ValueError
        Not OFF in three dimensions, or shorter than its counts say.
    """
    lines = _lines(data)
    first = next(lines, b"")
    keyword = _KEYWORD.match(first)
    if keyword is None:
        raise ValueError("does not begin with OFF")
    counts = first[keyword.end() :].split() or next(lines, b"").split()
    if len(counts) < 2:
        raise ValueError("the counts of vertices and faces are missing")
    vertex_count, face_count = int(counts[0]), int(counts[1])
    mesh = MeshBuilder()
    for number in range(vertex_count):
        mesh.add_vertex(_words(lines, f"vertex {number} of {vertex_count}")[:3])
    for number in range(face_count):
        words = _words(lines, f"face {number} of {face_count}")
        corners = int(words[0])
        if corners < 0 or len(words) < 1 + corners:
            raise ValueError(f"face {number} has {len(words) - 1} indices instead of {corners}")
        mesh.add_polygon([int(word) for word in words[1 : 1 + corners]])
    return mesh


def _lines(data: bytes) -> Iterator[bytes]:
    """Lines without their comments; empty ones are left out."""
    for line in io.BytesIO(data):
        text = line.partition(b"#")[0].strip()
        if text:
            yield text


def _words(lines: Iterator[bytes], what: str) -> list[bytes]:
    line = next(lines, None)
    if line is None:
        raise ValueError(f"the file ends before {what}")
    return line.split()
