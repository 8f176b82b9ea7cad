"""A mesh file that is broken is one clear error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from minirt.errors import SceneError
from tests.helpers.mesh_bytes import (
    BLOB,
    CORNERS,
    QUAD_TRIANGLE_PENTAGON,
    SUFFIXES,
    WHERE,
    glb,
    gltf,
    obj,
    off,
    ply,
    read,
    refusal,
    stl,
    stl_text,
)


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
def test_a_broken_file_is_refused_with_the_reason(
    name: str, data: bytes | str, what: str, tmp_path: Path
) -> None:
    assert what in str(refusal(tmp_path, name, data))


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
        assert refusal(tmp_path, "m.stl", broken).what == "the mesh file cannot be read"


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    "garbage", [b"", b"\0" * 200, bytes(range(256)) * 20, b"garbage\n" * 50, b"\xff\xfe" * 100]
)
def test_garbage_is_refused(suffix: str, garbage: bytes, tmp_path: Path) -> None:
    assert refusal(tmp_path, f"m.{suffix}", garbage).got.startswith(f"m.{suffix}")


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
