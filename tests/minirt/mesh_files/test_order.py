"""Every triangle of a mesh file, in the file's order."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.helpers.mesh_bytes import (
    CORNERS,
    FANS,
    QUAD_TRIANGLE_PENTAGON,
    obj,
    off,
    ply,
    read,
    stl,
    stl_text,
)


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
def test_a_ply_with_runs_of_equal_faces_keeps_its_order(form: str, tmp_path: Path) -> None:
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


def test_weight_and_colour_of_an_obj_vertex_are_ignored(tmp_path: Path) -> None:
    vertices, _ = read(tmp_path, "m.obj", "v 0 0 0 1\nv 1e-3 0 0 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert vertices == [[0, 0, 0], [1e-3, 0, 0], [0, 1, 0]]


def test_every_dialect_of_off_is_read(tmp_path: Path) -> None:
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


def test_stl_is_read_in_binary_and_in_ascii(tmp_path: Path) -> None:
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
