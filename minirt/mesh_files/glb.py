"""glTF 2.0, binary: the triangles of the default scene, each node's under its own transform.

Source: Khronos glTF 2.0 Specification, sections 3.4 to 3.7 and 4.4.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from minirt.mesh_files.builder import MeshBuilder
from minirt.mesh_files.transform import IDENTITY, Matrix, after, determinant, transform_points, trs

Json: TypeAlias = Any

_TYPES = {5126: "<f4", 5121: "u1", 5123: "<u2", 5125: "<u4"}
_WIDTHS = {"SCALAR": 1, "VEC3": 3}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_MAX_JSON_BYTES = 2**26


def read_glb(data: bytes) -> MeshBuilder:
    """Triangles node by node, parents first, in the file's order; other primitives are left out.

    Under a node that mirrors, the triangles' winding is reversed: the outside stays outside.

    Raises
    ------
    ValueError
        Truncated, nodes that are not a tree, or what is not supported here: a required
        extension, data in another file, sparse or quantised vertices.
    """
    document, blob = _chunks(data)
    if document.get("extensionsRequired"):
        raise ValueError(f"requires an extension: {document['extensionsRequired']}")
    mesh = MeshBuilder()
    for node, matrix in _nodes(document):
        if "mesh" not in node:
            continue
        for primitive in document["meshes"][node["mesh"]]["primitives"]:
            if primitive.get("mode", _TRIANGLES) in (_TRIANGLES, _STRIP, _FAN):
                _add(primitive, matrix, document, blob, mesh)
    return mesh


def _chunks(data: bytes) -> tuple[Json, bytes]:
    """The JSON document and the binary chunk, empty where there is none."""
    magic, version, length = struct.unpack_from("<4sII", data.ljust(12, b"\0"))
    if magic != b"glTF" or version != 2 or length > len(data):
        raise ValueError("not a complete glTF 2 file")
    chunks: dict[bytes, bytes] = {}
    place = 12
    while place + 8 <= length:
        size, kind = struct.unpack_from("<I4s", data, place)
        if place + 8 + size > length:
            raise ValueError("a chunk is truncated")
        chunks.setdefault(kind, data[place + 8 : place + 8 + size])
        place += 8 + size
    text = chunks.get(b"JSON", b"{}")
    if len(text) > _MAX_JSON_BYTES:
        raise ValueError(f"{len(text):,} bytes of JSON")
    document = json.loads(text)
    if not isinstance(document, dict):
        raise ValueError("the JSON chunk is not an object")
    return document, chunks.get(b"BIN\0", b"")


def _nodes(document: Json) -> Iterator[tuple[Json, Matrix]]:
    """The nodes of the default scene, each with the map from its coordinates to the scene's."""
    scenes = document.get("scenes", [])
    roots = scenes[document.get("scene", 0)].get("nodes", []) if scenes else []
    waiting = [(index, IDENTITY) for index in reversed(roots)]
    seen = set()
    while waiting:
        index, scene_from_parent = waiting.pop()
        if index in seen or index < 0:
            raise ValueError(f"node {index} is reached twice: the nodes are not a tree")
        seen.add(index)
        node = document["nodes"][index]
        scene_from_node = after(scene_from_parent, _parent_from_node(node))
        yield node, scene_from_node
        waiting += [(child, scene_from_node) for child in reversed(node.get("children", []))]


def _parent_from_node(node: Json) -> Matrix:
    if "matrix" not in node:
        return trs(
            node.get("translation", (0, 0, 0)),
            node.get("rotation", (0, 0, 0, 1)),
            node.get("scale", (1, 1, 1)),
        )
    m = [float(x) for x in node["matrix"]]  # column by column
    if len(m) != 16 or m[3::4] != [0, 0, 0, 1]:
        raise ValueError("a node's matrix is not affine")
    return tuple((m[k], m[k + 4], m[k + 8], m[k + 12]) for k in range(3))


def _add(primitive: Json, matrix: Matrix, document: Json, blob: bytes, mesh: MeshBuilder) -> None:
    points = _accessor(document, blob, primitive["attributes"]["POSITION"], "VEC3")
    if points.dtype.kind != "f":
        raise ValueError("vertices that are not floats")
    if "indices" in primitive:
        indices = _accessor(document, blob, primitive["indices"], "SCALAR")[:, 0].astype(np.int64)
    else:
        indices = np.arange(len(points))
    if len(indices) and not 0 <= indices.min() <= indices.max() < len(points):
        raise ValueError("an index without a vertex")
    triangles = _triangles(indices, primitive.get("mode", _TRIANGLES))
    if determinant(matrix) < 0:
        triangles = triangles[:, [0, 2, 1]]
    first = mesh.vertex_count
    mesh.add_vertices(transform_points(matrix, points.astype(np.float64)))
    mesh.add_polygons(triangles + first)


def _triangles(indices: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    """Triangles (m, 3) of a list, a strip or a fan; in a strip, every odd one is reversed."""
    if mode == _TRIANGLES:
        if len(indices) % 3:
            raise ValueError(f"{len(indices)} indices, which is not a multiple of 3")
        return indices.reshape(-1, 3)
    k = np.arange(max(0, len(indices) - 2))
    corners = (k, k + 1 + k % 2, k + 2 - k % 2) if mode == _STRIP else (k * 0, k + 1, k + 2)
    return indices[np.stack(corners, axis=1)]


def _accessor(document: Json, blob: bytes, index: int, kind: str) -> NDArray[Any]:
    """The values (count, width) of an accessor, a view of the binary chunk."""
    accessor = document["accessors"][index]
    if "sparse" in accessor or accessor.get("normalized") or "bufferView" not in accessor:
        raise ValueError("sparse, quantised or missing data")
    view = document["bufferViews"][accessor["bufferView"]]
    if view.get("buffer", 0) != 0 or "uri" in document["buffers"][0]:
        raise ValueError("data in another file")
    if accessor["type"] != kind:
        raise ValueError(f"an accessor of type {accessor['type']} where {kind} is needed")
    dtype, width = np.dtype(_TYPES[accessor["componentType"]]), _WIDTHS[kind]
    start, size, count = view.get("byteOffset", 0), view["byteLength"], accessor["count"]
    item = width * dtype.itemsize
    offset, stride = accessor.get("byteOffset", 0), view.get("byteStride", item)
    end = offset + stride * (count - 1) + item
    if min(start, offset, count - 1, stride - item, size - end, len(blob) - start - size) < 0:
        raise ValueError("an accessor reaches beyond its data")
    strides = (stride, dtype.itemsize)
    return np.ndarray((count, width), dtype, blob, offset=start + offset, strides=strides)
