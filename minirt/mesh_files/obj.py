"""Wavefront OBJ: the `v` and `f` lines; materials, textures and groups change no triangle."""

from __future__ import annotations

import io
from collections.abc import Iterator

from minirt.mesh_files.builder import MeshBuilder


def read_obj(data: bytes) -> MeshBuilder:
    """Vertices and faces in the order of the lines, whatever their material or group.

    A negative index counts back from the latest vertex before its line. Libraries named by
    ``mtllib`` are not read.

    Raises
    ------
    ValueError
        A statement that is malformed, with the number of its line.
    """
    mesh = MeshBuilder()
    for number, words in _statements(data):
        try:
            if words[0] == b"v":
                mesh.add_vertex(words[1:4])
            elif words[0] == b"f":
                mesh.add_polygon([_index(word, mesh.vertex_count) for word in words[1:]])
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from None
    return mesh


def _statements(data: bytes) -> Iterator[tuple[int, list[bytes]]]:
    """Words of each statement, with its last line's number; a backslash joins lines."""
    joined = b""
    for number, line in enumerate(io.BytesIO(data), start=1):
        stripped = line.rstrip()
        if stripped.endswith(b"\\"):
            joined += stripped[:-1] + b" "
            continue
        words = (joined + stripped).split()
        joined = b""
        if words:
            yield number, words


def _index(word: bytes, vertex_count: int) -> int:
    """The vertex of ``vertex/texture/normal``, counted from 0."""
    index = int(word.partition(b"/")[0])
    if index == 0 or index < -vertex_count:
        raise ValueError(f"no vertex {index}")
    return index - 1 if index > 0 else vertex_count + index
