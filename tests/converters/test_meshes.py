"""Triangles to trimesh and to files and back; trimesh judges the readers as an outside source."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

import minirt
from converters.meshes import (
    facets_to_trimesh,
    scene_to_trimesh,
    trimesh_to_facets,
    write_mesh,
)
from minirt.errors import InputError
from minirt.mesh_files.read import read_mesh
from minirt.scene import Facets

EXACT = (".obj", ".ply", ".off")
ROUNDED = (".stl", ".glb")


@st.composite
def meshes(draw: st.DrawFn) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Any finite float32 vertices, any faces, degenerate and repeated ones among them."""
    vertex_count, face_count = draw(st.integers(1, 8)), draw(st.integers(1, 8))
    numbers = st.floats(-(2.0**99), 2.0**99, width=32)
    vertices = draw(hnp.arrays(np.float64, (vertex_count, 3), elements=numbers))
    index = st.integers(0, vertex_count - 1)
    return vertices, draw(hnp.arrays(np.int32, (face_count, 3), elements=index))


def ball() -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Vertices that float32 does not hold, faces in no particular order."""
    mesh = trimesh.creation.icosphere(subdivisions=2)
    order = np.random.default_rng(3).permutation(len(mesh.faces))
    vertices = np.array(mesh.vertices) / 3 + [0.1, 1e4, -7]
    return vertices, np.array(mesh.faces, dtype=np.int32)[order]


@pytest.mark.parametrize("suffix", EXACT + ROUNDED)
def test_round_trip(suffix: str, tmp_path: Path) -> None:
    @settings(max_examples=40, deadline=None, derandomize=True, database=None)
    @given(meshes())
    def check(mesh: tuple[NDArray[Any], NDArray[Any]]) -> None:
        write_mesh(*mesh, tmp_path / f"m{suffix}")
        vertices, faces = read_mesh(tmp_path, f"m{suffix}", "file")
        np.testing.assert_array_equal(vertices[faces], mesh[0][mesh[1]])
        seen.append(len(faces))

    seen: list[int] = []
    check()
    assert len(seen) >= 40


@pytest.mark.parametrize("suffix", EXACT + ROUNDED)
def test_round_trip_of_numbers_that_float32_does_not_hold(suffix: str, tmp_path: Path) -> None:
    vertices, faces = ball()
    write_mesh(vertices, faces, tmp_path / f"m{suffix}")
    read_vertices, read_faces = read_mesh(tmp_path, f"m{suffix}", "file")
    expected = vertices if suffix in EXACT else vertices.astype(np.float32).astype(np.float64)
    assert len(read_faces) == 320
    np.testing.assert_array_equal(read_vertices[read_faces], expected[faces])
    if suffix != ".stl":
        np.testing.assert_array_equal(read_faces, faces)


@pytest.mark.parametrize("suffix", EXACT + ROUNDED)
def test_trimesh_reads_what_is_written(suffix: str, tmp_path: Path) -> None:
    vertices, faces = ball()
    write_mesh(vertices, faces, tmp_path / f"m{suffix}")
    mesh = trimesh.load_mesh(tmp_path / f"m{suffix}", process=False, maintain_order=True)
    rounded = vertices.astype(np.float32) if suffix in ROUNDED else vertices
    np.testing.assert_array_equal(mesh.vertices[mesh.faces], rounded[faces])


@pytest.mark.parametrize("suffix", EXACT + ROUNDED)
def test_what_trimesh_writes_is_read_as_trimesh_reads_it(suffix: str, tmp_path: Path) -> None:
    mesh = trimesh.creation.annulus(1, 2, 0.5)
    mesh.export(tmp_path / f"m{suffix}")
    theirs = trimesh.load_mesh(tmp_path / f"m{suffix}", process=False, maintain_order=True)
    vertices, faces = read_mesh(tmp_path, f"m{suffix}", "file")
    assert len(faces) == len(mesh.faces) > 100
    np.testing.assert_array_equal(vertices[faces], theirs.vertices[theirs.faces])


def test_facets_to_trimesh_and_back() -> None:
    vertices, faces = ball()
    faces = np.concatenate((faces, faces[:1], [[0, 0, 1]])).astype(np.int32)
    facets = Facets("mesh", "part", "red", vertices, faces)
    mesh = facets_to_trimesh(facets)
    np.testing.assert_array_equal(mesh.faces, faces)
    back = trimesh_to_facets(mesh, "part", "red")
    assert (back.type, back.name, back.material) == ("mesh", "part", "red")
    assert back.faces.dtype == np.int32
    np.testing.assert_array_equal(back.vertices, vertices)
    np.testing.assert_array_equal(back.faces, faces)
    back.vertices[0] = 0
    assert mesh.vertices[0].any(), "no shared memory"


def test_normals_of_trimesh_are_those_of_the_winding() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    for order, z in (([0, 1, 2], 1), ([0, 2, 1], -1)):
        facets = Facets("triangle", "t", "m", vertices, np.array([order], dtype=np.int32))
        np.testing.assert_array_equal(facets_to_trimesh(facets).face_normals, [[0, 0, z]])


def test_scene_to_trimesh() -> None:
    scene = minirt.load_scene(
        {
            "minirt": 1,
            "name": "two",
            "screen": {
                "look_at": {"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y": 40},
                "nx": 4,
                "ny": 4,
            },
            "light": {"direction": [0, 0, -1]},
            "materials": {"m": {}},
            "objects": [
                {"type": "sphere", "material": "m", "center": [0, 0, 0], "radius": 1},
                {
                    "type": "polygon",
                    "material": "m",
                    "name": "floor",
                    "vertices": [[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]],
                },
            ],
        }
    )
    result = scene_to_trimesh(scene)
    assert set(result.geometry) == {"objects[1]"}
    floor = result.geometry["objects[1]"]
    assert floor.metadata["name"] == "floor"
    np.testing.assert_array_equal(floor.faces, [[0, 1, 2], [0, 2, 3]])
    np.testing.assert_array_equal(result.bounds, [[0, 0, 0], [2, 3, 0]])


def test_suffixes_that_are_no_mesh(tmp_path: Path) -> None:
    for name in ("m.xyz", "m", "no/m.ply"):
        with pytest.raises(InputError):
            write_mesh(*ball(), tmp_path / name)
    assert not list(tmp_path.iterdir())
