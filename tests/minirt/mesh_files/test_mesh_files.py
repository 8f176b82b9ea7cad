"""Mesh files: every triangle in the file's order, or one clear error."""

from __future__ import annotations

import json
import struct
import time
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
    (folder / name).write_bytes(data if isinstance(data, bytes) else data.encode())
    vertices, faces = read_mesh(folder, name, WHERE)
    assert vertices.dtype == np.float64
    assert faces.dtype == np.int32
    return vertices.tolist(), faces.tolist()


def fault(folder: Path, name: str, data: bytes | str) -> SceneError:
    with pytest.raises(SceneError) as caught:
        read(folder, name, data)
    assert caught.value.where == WHERE
    assert name in caught.value.got
    return caught.value


# Triangles in the file's order


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("m.obj", obj(QUAD_TRIANGLE_PENTAGON)),
        ("m.OBJ", obj(QUAD_TRIANGLE_PENTAGON).replace(b"\n", b"\r\n")),
        ("m.off", off(QUAD_TRIANGLE_PENTAGON)),
        ("m.ply", ply(QUAD_TRIANGLE_PENTAGON)),
        ("m.ply", ply(QUAD_TRIANGLE_PENTAGON, "binary_little_endian")),
        ("m.ply", ply(QUAD_TRIANGLE_PENTAGON, "binary_big_endian")),
    ],
)
def test_polygons_become_their_fans_in_order(name: str, data: bytes, tmp_path: Path) -> None:
    assert read(tmp_path, name, data) == (CORNERS, FANS)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_with_runs_of_equal_faces(form: str, tmp_path: Path) -> None:
    """Runs of every length up to 40, so that each step of the reader's window ends within one."""
    faces = [[0, 1, 2, 3, 4][: 3 + k % 3] for k in range(40) for _ in range(k)]
    _, triangles = read(tmp_path, "m.ply", ply(faces, form))
    expected = [[0, j, j + 1] for face in faces for j in range(1, len(face) - 1)]
    assert len(triangles) == len(expected) > 1000
    assert triangles == expected


def test_obj_faces_keep_their_order_across_materials_and_groups(tmp_path: Path) -> None:
    """And the library that it names, outside the folder, is not read: it is a pipe."""
    text = (
        "mtllib ../secret.mtl\n" + obj([]).decode() + "\nvt 0 0\nvn 0 0 1\n"
        "usemtl a\nf 1/1/1 2/1/1 3/1/1\ng x\nusemtl b\nf 1//1 3//1 4//1\no y\nusemtl a\n"
        "f 1/1 2/1 5/1\ns 1\nl 1 2\n# f 5 4 3\nf 1 2 \\\n 4\n"
    )
    vertices, faces = read(tmp_path, "m.obj", text)
    assert vertices == CORNERS
    assert faces == [[0, 1, 2], [0, 2, 3], [0, 1, 4], [0, 1, 3]]


def test_obj_negative_indices_count_from_the_latest_vertex(tmp_path: Path) -> None:
    block = "v 0 0 {0}\nv 1 0 {0}\nv 0 1 {0}\nf -3 -2 -1\n"
    _, faces = read(tmp_path, "m.obj", block.format(0) + block.format(1))
    assert faces == [[0, 1, 2], [3, 4, 5]]


def test_obj_vertex_with_a_weight_and_a_colour(tmp_path: Path) -> None:
    vertices, _ = read(tmp_path, "m.obj", "v 0 0 0 1\nv 1e-3 0 0 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert vertices == [[0, 0, 0], [1e-3, 0, 0], [0, 1, 0]]


def test_off_dialects(tmp_path: Path) -> None:
    plain = off([[0, 1, 2]])
    for data in (
        b"# made by hand\n\n" + plain,
        plain.replace(b"OFF\n", b"OFF"),
        plain.replace(b"OFF\n", b"OFF "),
        plain + b" 255 0 0 # red\n",
        plain.replace(b"0 0 1\n", b"0 0 1 9 9 9 # a normal\n").replace(b"OFF", b"NOFF"),
        plain.replace(b"OFF", b"COFF"),
    ):
        assert read(tmp_path, "m.off", data) == (CORNERS, [[0, 1, 2]])


def test_stl_binary_and_text(tmp_path: Path) -> None:
    """Normals in the file, wrong ones here, say nothing: the order of the corners does."""
    one = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]
    two = [[0.0, 0, 2], [1, 0, 2], [1, 0, 2]]
    expected = (one + two, [[0, 1, 2], [3, 4, 5]])
    binary = stl([one, two])
    for data in (
        binary,
        b"solid" + binary[5:],
        stl_text([one, two]).encode(),
        stl_text([one, two]).upper().encode(),
        (stl_text([one]) + "\n" + stl_text([two], "second part")).encode(),
        (stl_text([one, two]) + stl_text([])).replace("\n", "\r\n").encode(),
    ):
        assert read(tmp_path, "m.stl", data) == expected


# The scene graph of a GLB

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
def test_transforms_of_nodes(
    nodes: list[dict[str, Any]], expected: list[list[int]], tmp_path: Path
) -> None:
    """Corners in winding order; the expected ones follow from the transforms by hand.

    A mirrored node turns its triangles round (glTF 2.0, section 3.7.4).
    """
    vertices, faces = read(tmp_path, "m.glb", glb(gltf(nodes), BLOB))
    assert [vertices[k] for k in faces[0]] == expected
    assert len(faces) == 1


def test_nodes_in_the_order_of_the_file(tmp_path: Path) -> None:
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
def test_strips_and_fans(mode: int, expected: list[list[int]], tmp_path: Path) -> None:
    """Without indices, all four vertices; lines and points are not triangles."""
    document = gltf([{"mesh": 0}])
    primitive = document["meshes"][0]["primitives"][0]
    del primitive["indices"]
    primitive["mode"] = mode
    data = glb(document, BLOB)
    if expected:
        assert read(tmp_path, "m.glb", data)[1] == expected
    else:
        assert fault(tmp_path, "m.glb", data).what == "the mesh has no triangles"


def test_a_long_chain_of_nodes_is_read_at_once(tmp_path: Path) -> None:
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
def test_glb_that_is_refused(path: list[Any], value: Any, what: str, tmp_path: Path) -> None:
    document = change(gltf([{"mesh": 0}]), path, value)
    assert what in str(fault(tmp_path, "m.glb", glb(document, BLOB)))


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
        assert fault(tmp_path, "m.glb", broken).what == "the mesh file cannot be read"


# What is refused, format by format


@pytest.mark.parametrize(
    ("name", "data", "what"),
    [
        ("m.obj", obj([[0, 1, 9]]), "names a vertex that does not exist"),
        ("m.obj", obj("f 0 1 2"), "line 6: no vertex 0"),
        ("m.obj", obj("f -9 1 2"), "line 6: no vertex -9"),
        ("m.obj", obj("f 1 2"), "line 6: a face of 2 vertices"),
        ("m.obj", obj("f 1 x 3"), "line 6: "),
        ("m.obj", obj(f"f 1 2 {10**25}"), "m.obj"),
        ("m.obj", "v 0 0\n", "line 1: a vertex of 2 numbers"),
        ("m.obj", "v 0 0 oops\n", "line 1: "),
        ("m.obj", obj([[0, 1, 2]], [[0, 0, 0], [1, "nan", 0], [0, 1, 0]]), "not finite"),
        ("m.obj", obj([[0, 1, 2]], [[0, 0, 0], [1, "1e999", 0], [0, 1, 0]]), "not finite"),
        ("m.obj", obj([]), "no triangles"),
        ("m.off", off([[0, 1, 2]], "5 2 0"), "ends before face 1 of 2"),
        ("m.off", off([], "6 0 0"), "ends before vertex 5 of 6"),
        ("m.off", off([], f"{10**15} {10**15} 0"), "ends before vertex"),
        ("m.off", off([[0, 1, 2]], "5"), "counts"),
        ("m.off", off([[0, 1, 2]], "five one"), "m.off"),
        ("m.off", off([[0, 1, 2]]).replace(b"3 0 1 2", b"3 0 1"), "has 2 indices instead of 3"),
        ("m.off", off([[0, 1, 2]]).replace(b"3 0 1 2", b"-3 0 1"), "has 2 indices instead of -3"),
        ("m.off", off([[0, 1, 9]]), "does not exist"),
        ("m.off", off([[0, 1, -1]]), "does not exist"),
        ("m.off", off([[0, 1]]), "a face of 2 vertices"),
        ("m.off", off([[0, 1, 2]], keyword="4OFF"), "does not begin with OFF"),
        ("m.off", off([]), "no triangles"),
        ("m.ply", ply([[0, 1, 2]], counts=(5, 2)), "face 1 of 2 is incomplete"),
        ("m.ply", ply([[0, 1, 2]], counts=(10**14, 1)), "is incomplete"),
        ("m.ply", ply([[0, 1, 2]], "binary_little_endian", (5, 2)), "ends in a list of face"),
        ("m.ply", ply([[0, 1, 2]], "binary_little_endian", (10**14, 2)), "ends in vertex"),
        ("m.ply", ply([[0, 1, 2]], "binary_little_endian")[:-1], "ends in face 0"),
        ("m.ply", ply([[0, 1, 9]]), "does not exist"),
        ("m.ply", ply([[0, 1, -1]], "binary_big_endian"), "does not exist"),
        ("m.ply", ply([[0, 1]]), "a face of 2 vertices"),
        ("m.ply", ply([[0, 1]], "binary_big_endian"), "a face of 2 vertices"),
        ("m.ply", ply([]), "no triangles"),
        ("m.ply", ply([[0, 1, 2]]).replace(b"1 255 0 0", b"1 255 nan 0"), "not finite"),
        ("m.ply", ply([[0, 1, 2]]).replace(b"double x", b"double X"), "has no property x"),
        ("m.ply", ply([[0, 1, 2]]).replace(b"uchar red", b"list red"), "not a property"),
        ("m.ply", ply([[0, 1, 2]]).replace(b"uchar red", b"byte red"), "not a property"),
        ("m.ply", ply([[0, 1, 2]]).replace(b"uchar int", b"float int"), "not a property"),
        ("m.ply", ply([[0, 1, 2]]).replace(b"uchar int", b"uchar float"), "not a list of integers"),
        ("m.ply", ply([[0, 1, 2]]).replace(b"format", b"formal"), "not a line of a PLY header"),
        ("m.ply", ply([[0, 1, 2]]).replace(b"element vertex 5", b"element vertex -5"), "header"),
        ("m.ply", ply([[0, 1, 2]]).replace(b"format ascii 1.0\n", b""), "does not name a format"),
        ("m.ply", ply([[0, 1, 2]]).replace(b"end_header\n", b""), "m.ply"),
        ("m.ply", b"ply\nformat ascii 1.0\nelement vertex 1\n", "header does not end"),
        ("m.stl", stl([CORNERS[:3]])[:-1], "neither binary"),
        ("m.stl", bytes(80) + b"\xff" * 4, "neither binary"),
        ("m.stl", stl([]), "no triangles"),
        ("m.stl", stl_text([]), "no triangles"),
        ("m.stl", stl([[[np.nan, 0, 0]] * 3]), "not finite"),
    ],
)
def test_files_that_are_refused(name: str, data: bytes | str, what: str, tmp_path: Path) -> None:
    assert what in str(fault(tmp_path, name, data))


def test_a_damaged_ascii_stl_is_refused(tmp_path: Path) -> None:
    text = stl_text([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]] * 2)
    assert len(read(tmp_path, "m.stl", text)[1]) == 2
    for broken in (
        text[: text.index("endsolid")],
        text[: text.rindex("vertex")],
        text.replace("vertex 1 0 0", "vertex 1 0", 1),
        text.replace("vertex 1 0 0", "vertex 1 0 x", 1),
        text.replace("endfacet", "", 1),
        text + "solid again\n",
        text + "rubbish",
    ):
        assert fault(tmp_path, "m.stl", broken).what == "the mesh file cannot be read"


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    "garbage", [b"", b"\0" * 200, bytes(range(256)) * 20, b"garbage\n" * 50, b"\xff\xfe" * 100]
)
def test_garbage(suffix: str, garbage: bytes, tmp_path: Path) -> None:
    assert fault(tmp_path, f"m.{suffix}", garbage).got.startswith(f"m.{suffix}")


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("m.obj", obj(QUAD_TRIANGLE_PENTAGON)),
        ("m.off", off(QUAD_TRIANGLE_PENTAGON)),
        ("m.ply", ply(QUAD_TRIANGLE_PENTAGON)),
        ("m.ply", ply(QUAD_TRIANGLE_PENTAGON, "binary_little_endian")),
        ("m.stl", stl([CORNERS[:3]])),
        ("m.glb", glb(gltf([{"mesh": 0}]), BLOB)),
    ],
    ids=["obj", "off", "ply ascii", "ply binary", "stl", "glb"],
)
def test_damaged_files_never_give_a_traceback(name: str, data: bytes, tmp_path: Path) -> None:
    generator = np.random.default_rng(11)
    outcomes: list[str] = []
    for _ in range(150):
        damaged = bytearray(data)
        for _ in range(int(generator.integers(1, 4))):
            damaged[int(generator.integers(len(data)))] = int(generator.integers(256))
        cut = int(generator.integers(len(data) // 2, len(data) + 1))
        try:
            read(tmp_path, name, bytes(damaged[:cut]))
            outcomes.append(WHERE)
        except SceneError as error:
            outcomes.append(error.where)
    assert outcomes == [WHERE] * 150


# Limits


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("m.obj", obj(QUAD_TRIANGLE_PENTAGON)),
        ("m.off", off(QUAD_TRIANGLE_PENTAGON)),
        ("m.ply", ply(QUAD_TRIANGLE_PENTAGON, "binary_little_endian")),
        ("m.stl", stl([CORNERS[:3]] * 6)),
        ("m.glb", glb(gltf([{"mesh": 0}] * 6, list(range(6))), BLOB)),
    ],
)
def test_more_triangles_than_the_limit(
    name: str, data: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("minirt.mesh_files.builder.MAX_FACES", 6)
    assert len(read(tmp_path, name, data)[1]) == 6
    monkeypatch.setattr("minirt.mesh_files.builder.MAX_FACES", 5)
    assert "more than 5 triangles" in fault(tmp_path, name, data).got


def test_more_vertices_than_the_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("minirt.mesh_files.builder.MAX_VERTICES", 4)
    for name, data in (("m.obj", obj([])), ("m.ply", ply([], "binary_big_endian"))):
        assert "more than 4 vertices" in fault(tmp_path, name, data).got


def test_a_file_over_the_limit_is_not_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = obj([[0, 1, 2]])
    monkeypatch.setattr("minirt.mesh_files.read.MAX_BYTES", len(data))
    assert read(tmp_path, "m.obj", data)[1] == [[0, 1, 2]]
    monkeypatch.setattr("minirt.mesh_files.read.MAX_BYTES", len(data) - 1)
    error = fault(tmp_path, "m.obj", data)
    assert error.what == "the mesh file is too large"
    assert error.expected


def test_glb_with_too_much_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("minirt.mesh_files.glb._MAX_JSON_BYTES", 10)
    assert "bytes of JSON" in fault(tmp_path, "m.glb", glb(gltf([{"mesh": 0}]), BLOB)).got


# Paths


def test_files_outside_the_folder(tmp_path: Path) -> None:
    scene = tmp_path / "scene"
    (scene / "sub").mkdir(parents=True)
    (tmp_path / "scene2").mkdir()
    for folder in (tmp_path, scene, scene / "sub", tmp_path / "scene2"):
        (folder / "m.obj").write_bytes(obj([[0, 1, 2]]))
    (scene / "out.obj").symlink_to(tmp_path / "m.obj")
    (scene / "in.obj").symlink_to("sub/m.obj")
    (scene / "up").symlink_to(tmp_path)
    for inside in ("m.obj", "sub/m.obj", "sub/../m.obj", "in.obj", "./m.obj"):
        assert len(read_mesh(scene, inside, WHERE)[1]) == 1
    for outside in (
        "../m.obj",
        "sub/../../m.obj",
        "../scene2/m.obj",
        "out.obj",
        "up/m.obj",
        str(tmp_path / "m.obj"),
        str(scene / "m.obj"),
        "/etc/passwd",
    ):
        with pytest.raises(SceneError, match="outside the scene's folder") as caught:
            read_mesh(scene, outside, WHERE)
        assert caught.value.got == outside


def test_what_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "folder.obj").mkdir()
    (tmp_path / "loop.obj").symlink_to("loop.obj")
    for name in ("none.obj", "folder.obj", "loop.obj", "a\0b.obj", "x" * 300 + ".obj", "m", "."):
        with pytest.raises(SceneError) as caught:
            read_mesh(tmp_path, name, WHERE)
        assert caught.value.where == WHERE


@pytest.mark.parametrize("name", ["m.zip", "m.gltf", "m.3mf", "m.dae", "m.xyz", "m.obj.gz", "obj"])
def test_other_formats(name: str, tmp_path: Path) -> None:
    assert fault(tmp_path, name, obj([[0, 1, 2]])).what == "unknown mesh format"
