"""Limits on what is read: triangles, vertices, bytes, and paths inside the scene's folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from minirt.errors import SceneError
from minirt.mesh_files.read import read_mesh
from tests.helpers.mesh_bytes import (
    BLOB,
    CORNERS,
    QUAD_TRIANGLE_PENTAGON,
    WHERE,
    glb,
    gltf,
    obj,
    off,
    ply,
    read,
    refusal,
    stl,
)


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
def test_more_triangles_than_the_limit_are_refused(
    name: str, data: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("minirt.mesh_files.builder.MAX_FACES", 6)
    assert len(read(tmp_path, name, data)[1]) == 6
    monkeypatch.setattr("minirt.mesh_files.builder.MAX_FACES", 5)
    assert "more than 5 triangles" in refusal(tmp_path, name, data).got


def test_more_vertices_than_the_limit_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("minirt.mesh_files.builder.MAX_VERTICES", 4)
    for name, data in (("m.obj", obj([])), ("m.ply", ply([], "binary_big_endian"))):
        assert "more than 4 vertices" in refusal(tmp_path, name, data).got


def test_a_file_over_the_limit_is_not_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = obj([[0, 1, 2]])
    monkeypatch.setattr("minirt.mesh_files.read.MAX_BYTES", len(data))
    assert read(tmp_path, "m.obj", data)[1] == [[0, 1, 2]]
    monkeypatch.setattr("minirt.mesh_files.read.MAX_BYTES", len(data) - 1)
    error = refusal(tmp_path, "m.obj", data)
    assert error.what == "the mesh file is too large"
    assert error.expected


def test_files_outside_the_folder_are_refused(tmp_path: Path) -> None:
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


def test_a_path_that_is_not_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.obj").mkdir()
    (tmp_path / "loop.obj").symlink_to("loop.obj")
    for name in ("none.obj", "folder.obj", "loop.obj", "a\0b.obj", "x" * 300 + ".obj", "m", "."):
        with pytest.raises(SceneError) as caught:
            read_mesh(tmp_path, name, WHERE)
        assert caught.value.where == WHERE


@pytest.mark.parametrize("name", ["m.zip", "m.gltf", "m.3mf", "m.dae", "m.xyz", "m.obj.gz", "obj"])
def test_other_formats_are_refused(name: str, tmp_path: Path) -> None:
    assert refusal(tmp_path, name, obj([[0, 1, 2]])).what == "unknown mesh format"
