"""Binary glTF: its scene graph, its primitives, and what is refused."""

from __future__ import annotations

import struct
import time
from pathlib import Path
from typing import Any

import pytest

from tests.helpers.mesh_bytes import BLOB, glb, gltf, read, refusal

MOVED = {"translation": [1, 0, 0]}


@pytest.mark.parametrize(
    ("nodes", "expected"),
    [
        ([{"mesh": 0}], [[0, 0, 0], [1, 0, 0], [1, 1, 0]]),
        (
            [{"children": [1], "translation": [1, 2, 3]}, {"mesh": 0, "scale": [2, 3, 4]}],
            [[1, 2, 3], [3, 2, 3], [3, 5, 3]],
        ),
        (
            [{"mesh": 0, "rotation": [0, 0, 1, 0], "translation": [5, 0, 0]}],
            [[5, 0, 0], [4, 0, 0], [4, -1, 0]],
        ),
        (
            [{"mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1]}],
            [[7, 8, 9], [7, 9, 9], [6, 9, 9]],
        ),
        (
            [{"children": [1], "scale": [2, 2, 2]}, {"children": [2]}, {"mesh": 0, **MOVED}],
            [[2, 0, 0], [4, 0, 0], [4, 2, 0]],
        ),
        ([{"mesh": 0, "scale": [-1, 1, 1]}], [[0, 0, 0], [-1, 1, 0], [-1, 0, 0]]),
    ],
    ids=["plain", "nested", "half turn", "matrix, column by column", "three deep", "mirrored"],
)
def test_transforms_of_nodes_are_applied(
    nodes: list[dict[str, Any]], expected: list[list[int]], tmp_path: Path
) -> None:
    """Corners in winding order; the expected ones follow from the transforms by hand.

    A mirrored node turns its triangles round (glTF 2.0, section 3.7.4).
    """
    vertices, faces = read(tmp_path, "m.glb", glb(gltf(nodes), BLOB))
    assert [vertices[k] for k in faces[0]] == expected
    assert len(faces) == 1


def test_nodes_are_read_in_the_files_order(tmp_path: Path) -> None:
    nodes = [{"mesh": 0, "translation": [0, 0, k]} for k in (2, 1, 0)]
    nodes[0]["children"] = [3]
    nodes.append({"mesh": 0, "translation": [0, 0, 7]})
    vertices, faces = read(tmp_path, "m.glb", glb(gltf(nodes, [1, 0, 2]), BLOB))
    assert [vertices[face[0]][2] for face in faces] == [1, 2, 9, 0]


def test_only_the_default_scene_counts(tmp_path: Path) -> None:
    document = gltf([{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0]}])
    document["scenes"].append({"nodes": [1]})
    document["scene"] = 1
    vertices, faces = read(tmp_path, "m.glb", glb(document, BLOB))
    assert [vertices[k][0] for k in faces[0]] == [5, 6, 6]


@pytest.mark.parametrize(
    ("mode", "expected"),
    [(5, [[0, 1, 2], [1, 3, 2]]), (6, [[0, 1, 2], [0, 2, 3]]), (1, []), (0, [])],
)
def test_strips_and_fans_become_triangles(
    mode: int, expected: list[list[int]], tmp_path: Path
) -> None:
    """Without indices, all four vertices; lines and points are not triangles."""
    document = gltf([{"mesh": 0}])
    primitive = document["meshes"][0]["primitives"][0]
    del primitive["indices"]
    primitive["mode"] = mode
    data = glb(document, BLOB)
    if expected:
        assert read(tmp_path, "m.glb", data)[1] == expected
    else:
        assert refusal(tmp_path, "m.glb", data).what == "the mesh has no triangles"


def test_a_long_chain_of_nodes_takes_linear_time(tmp_path: Path) -> None:
    chain = [{"children": [k + 1], "translation": [1, 0, 0]} for k in range(20_000)]
    start = time.process_time()
    vertices, _ = read(tmp_path, "m.glb", glb(gltf([*chain, {"mesh": 0}]), BLOB))
    # Linear work of some 5 µs a node; what is quadratic takes minutes.
    assert time.process_time() - start < 5
    assert vertices[0] == [20_000, 0, 0]


def change(document: dict[str, Any], path: list[Any], value: Any) -> dict[str, Any]:
    target: Any = document
    for key in path[:-1]:
        target = target[key]
    if value is None:
        del target[path[-1]]
    else:
        target[path[-1]] = value
    return document


@pytest.mark.parametrize(
    ("path", "value", "what"),
    [
        (["extensionsRequired"], ["KHR_draco_mesh_compression"], "requires an extension"),
        (["buffers", 0, "uri"], "../secret.bin", "data in another file"),
        (["bufferViews", 0, "buffer"], 1, "data in another file"),
        (["accessors", 0, "sparse"], {"count": 1}, "sparse"),
        (["accessors", 0, "normalized"], True, "quantised"),
        (["accessors", 0, "bufferView"], None, "missing data"),
        (["accessors", 0, "componentType"], 5123, "not floats"),
        (["accessors", 0, "count"], 10**12, "beyond its data"),
        (["accessors", 0, "count"], 5, "beyond its data"),
        (["accessors", 0, "count"], 0, "beyond its data"),
        (["accessors", 0, "byteOffset"], -4, "beyond its data"),
        (["accessors", 0, "type"], "VEC2", "VEC2 where VEC3 is needed"),
        (["accessors", 1, "count"], 2, "multiple of 3"),
        (["accessors", 1, "componentType"], 9, ""),
        (["bufferViews", 0, "byteStride"], 0, "beyond its data"),
        (["bufferViews", 0, "byteLength"], 10**9, "beyond its data"),
        (["accessors", 0, "count"], 2, "index without a vertex"),
        (["nodes", 0, "children"], [0], "not a tree"),
        (["nodes", 0, "children"], [1], ""),
        (["nodes", 0, "matrix"], [1] * 16, "not affine"),
        (["nodes", 0, "matrix"], [1], "not affine"),
        (["nodes", 0, "scale"], [1, 1], ""),
        (["nodes", 0, "translation"], ["x", 0, 0], ""),
        (["nodes"], 3, ""),
        (["meshes"], {}, ""),
        (["scenes"], None, "no triangles"),
        (["scenes", 0, "nodes"], [-1], "not a tree"),
        (["scenes", 0, "nodes"], [], "no triangles"),
        (["meshes", 0, "primitives", 0, "attributes"], {}, ""),
    ],
)
def test_a_glb_with_a_wrong_value_is_refused(
    path: list[Any], value: Any, what: str, tmp_path: Path
) -> None:
    document = change(gltf([{"mesh": 0}]), path, value)
    assert what in str(refusal(tmp_path, "m.glb", glb(document, BLOB)))


def test_a_damaged_glb_container_is_refused(tmp_path: Path) -> None:
    data = glb(gltf([{"mesh": 0}]), BLOB)
    deep = b"[" * 100_000
    for broken in (
        data[:-1],
        data[:40],
        data.replace(b"glTF", b"glTX"),
        data[:4] + struct.pack("<I", 1) + data[8:],
        data[:12] + struct.pack("<I", 2**32 - 1) + data[16:],
        glb([], BLOB),  # type: ignore[arg-type]
        struct.pack("<4sIII4s", b"glTF", 2, 20 + len(deep), len(deep), b"JSON") + deep,
    ):
        assert refusal(tmp_path, "m.glb", broken).what == "the mesh file cannot be read"


def test_a_glb_with_too_much_json_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("minirt.mesh_files.glb._MAX_JSON_BYTES", 10)
    assert "bytes of JSON" in refusal(tmp_path, "m.glb", glb(gltf([{"mesh": 0}]), BLOB)).got
