"""Mesh files of every format as bytes, and what reading them gives."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from minirt.errors import SceneError
from minirt.mesh_files.read import read_mesh

WHERE = "scene.json: objects[0].file"
CORNERS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]]
QUAD_TRIANGLE_PENTAGON = [[0, 1, 2, 3], [0, 1, 4], [0, 1, 2, 3, 4]]
#: Their fans, polygon after polygon.
FANS = [[0, 1, 2], [0, 2, 3], [0, 1, 4], [0, 1, 2], [0, 2, 3], [0, 3, 4]]
SUFFIXES = ("obj", "ply", "stl", "glb", "off")


def obj(faces: list[list[int]] | str, vertices: list[list[Any]] = CORNERS) -> bytes:
    lines = ["v " + " ".join(map(str, v)) for v in vertices]
    if isinstance(faces, str):
        lines.append(faces)
    else:
        lines += ["f " + " ".join(str(k + 1) for k in face) for face in faces]
    return "\n".join(lines).encode()


def off(faces: list[list[int]], counts: str = "", keyword: str = "OFF") -> bytes:
    lines = [keyword, counts or f"{len(CORNERS)} {len(faces)} 0"]
    lines += [" ".join(map(str, v)) for v in CORNERS]
    lines += [" ".join(map(str, [len(face), *face])) for face in faces]
    return "\n".join(lines).encode()


def ply(
    faces: list[list[int]], form: str = "ascii", counts: tuple[int, int] | None = None
) -> bytes:
    """With a normal, a colour and an element of its own, as real files have."""
    vertex_count, face_count = counts or (len(CORNERS), len(faces))
    header = (
        f"ply\nformat {form} 1.0\ncomment made by hand\nobj_info x\n"
        f"element vertex {vertex_count}\nproperty double x\nproperty uchar red\n"
        "property float y\nproperty float z\n"
        "element extra 2\nproperty list ushort short numbers\n"
        f"element face {face_count}\nproperty uchar flag\n"
        "property list uchar int vertex_indices\nproperty float quality\nend_header\n"
    ).encode()
    if form == "ascii":
        rows = [f"{x} 255 {y} {z}" for x, y, z in CORNERS] + ["2 7 8", "0"]
        rows += [f"1 {len(f)} {' '.join(map(str, f))} 0.5" for f in faces]
        return header + "\n".join(rows).encode() + b"\n"
    order = "<" if "little" in form else ">"
    body = b"".join(struct.pack(f"{order}dBff", x, 255, y, z) for x, y, z in CORNERS)
    body += struct.pack(f"{order}HhhH", 2, 7, 8, 0)
    for f in faces:
        body += struct.pack(f"{order}BB{len(f)}if", 1, len(f), *f, 0.5)
    return header + body


def stl(triangles: list[Any]) -> bytes:
    data = bytes(80) + struct.pack("<I", len(triangles))
    for triangle in triangles:
        data += struct.pack("<12fH", 0, 0, -1, *[x for corner in triangle for x in corner], 7)
    return data


def stl_text(triangles: list[Any], name: str = "part") -> str:
    facets = ""
    for triangle in triangles:
        corners = "".join(f"      vertex {x} {y} {z}\n" for x, y, z in triangle)
        facets += f"  facet normal 0 0 -1\n    outer loop\n{corners}    endloop\n  endfacet\n"
    return f"solid {name}\n{facets}endsolid {name}\n"


def glb(document: dict[str, Any], blob: bytes = b"") -> bytes:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data = struct.pack("<I4s", len(text), b"JSON") + text
    data += struct.pack("<I4s", len(blob), b"BIN\0") + blob
    return struct.pack("<4sII", b"glTF", 2, 12 + len(data)) + data


BLOB = np.array(CORNERS[:4], "<f4").tobytes() + np.array([0, 1, 2], "<u2").tobytes() + b"\0\0"


def gltf(nodes: list[dict[str, Any]], roots: list[int] | None = None) -> dict[str, Any]:
    """One mesh of one triangle: the first three of four vertices."""
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0] if roots is None else roots}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 6},
        ],
        "buffers": [{"byteLength": len(BLOB)}],
    }


def read(folder: Path, name: str, data: bytes | str) -> tuple[list[Any], list[Any]]:
    """Vertices and triangles of a file with this content."""
    (folder / name).write_bytes(data if isinstance(data, bytes) else data.encode())
    vertices, faces = read_mesh(folder, name, WHERE)
    assert vertices.dtype == np.float64
    assert faces.dtype == np.int32
    return vertices.tolist(), faces.tolist()


def refusal(folder: Path, name: str, data: bytes | str) -> SceneError:
    """The one error that a file with this content gives."""
    with pytest.raises(SceneError) as caught:
        read(folder, name, data)
    assert caught.value.where == WHERE
    assert name in caught.value.got
    return caught.value
