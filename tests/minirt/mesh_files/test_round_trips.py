"""Meshes written and read again; trimesh judges writer and reader as an outside source."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from trimesh.exchange.gltf import export_glb
from trimesh.exchange.stl import export_stl

from minirt.mesh_files.read import read_mesh
from minirt.vectors import Floats, Ints

_PLY_HEADER = """ply
format binary_little_endian 1.0
element vertex {vertices}
property double x
property double y
property double z
element face {faces}
property list uchar int vertex_indices
end_header
"""
_PLY_FACE = np.dtype([("count", "u1"), ("indices", "<i4", 3)])


def obj_bytes(vertices: Floats, faces: Ints) -> bytes:
    lines = [f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}\n" for a, b, c in (faces + 1).tolist()]
    return "".join(lines).encode()


def off_bytes(vertices: Floats, faces: Ints) -> bytes:
    lines = [f"OFF\n{len(vertices)} {len(faces)} 0\n"]
    lines += [f"{x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist()]
    lines += [f"3 {a} {b} {c}\n" for a, b, c in faces.tolist()]
    return "".join(lines).encode()


def ply_bytes(vertices: Floats, faces: Ints) -> bytes:
    table = np.zeros(len(faces), dtype=_PLY_FACE)
    table["count"], table["indices"] = 3, faces
    header = _PLY_HEADER.format(vertices=len(vertices), faces=len(faces)).encode()
    return header + vertices.astype("<f8").tobytes() + table.tobytes()


def stl_bytes(vertices: Floats, faces: Ints) -> bytes:
    return export_stl(trimesh.Trimesh(vertices, faces, process=False))


def glb_bytes(vertices: Floats, faces: Ints) -> bytes:
    scene = trimesh.Scene(trimesh.Trimesh(vertices, faces, process=False))
    data: bytes = export_glb(scene)  # type: ignore[no-untyped-call]
    return data


EXACT: dict[str, Callable[[Floats, Ints], bytes]] = {
    ".obj": obj_bytes,
    ".ply": ply_bytes,
    ".off": off_bytes,
}
#: Formats of float32.
ROUNDED: dict[str, Callable[[Floats, Ints], bytes]] = {".stl": stl_bytes, ".glb": glb_bytes}
WRITERS = EXACT | ROUNDED


@st.composite
def meshes(draw: st.DrawFn) -> tuple[Floats, Ints]:
    """Any finite float32 vertices, any faces, degenerate and repeated ones among them."""
    vertex_count, face_count = draw(st.integers(1, 8)), draw(st.integers(1, 8))
    numbers = st.floats(-(2.0**99), 2.0**99, width=32)
    vertices = draw(hnp.arrays(np.float64, (vertex_count, 3), elements=numbers))
    index = st.integers(0, vertex_count - 1)
    return vertices, draw(hnp.arrays(np.int32, (face_count, 3), elements=index))


def ball() -> tuple[Floats, Ints]:
    """Vertices that float32 does not hold, faces in no particular order."""
    mesh = trimesh.creation.icosphere(subdivisions=2)
    order = np.random.default_rng(3).permutation(len(mesh.faces))
    vertices = np.array(mesh.vertices) / 3 + [0.1, 1e4, -7]
    return vertices, np.array(mesh.faces, dtype=np.int32)[order]


@pytest.mark.parametrize("suffix", WRITERS)
def test_any_mesh_is_read_as_it_was_written(suffix: str, tmp_path: Path) -> None:
    @settings(max_examples=40, deadline=None, derandomize=True, database=None)
    @given(meshes())
    def check(mesh: tuple[Floats, Ints]) -> None:
        (tmp_path / f"m{suffix}").write_bytes(WRITERS[suffix](*mesh))
        vertices, faces = read_mesh(tmp_path, f"m{suffix}", "file")
        np.testing.assert_array_equal(vertices[faces], mesh[0][mesh[1]])
        seen.append(len(faces))

    seen: list[int] = []
    check()
    assert len(seen) >= 40


@pytest.mark.parametrize("suffix", WRITERS)
def test_numbers_beyond_float32_are_kept_where_the_format_can(suffix: str, tmp_path: Path) -> None:
    vertices, faces = ball()
    (tmp_path / f"m{suffix}").write_bytes(WRITERS[suffix](vertices, faces))
    read_vertices, read_faces = read_mesh(tmp_path, f"m{suffix}", "file")
    expected = vertices if suffix in EXACT else vertices.astype(np.float32).astype(np.float64)
    assert len(read_faces) == 320
    np.testing.assert_array_equal(read_vertices[read_faces], expected[faces])
    if suffix != ".stl":
        np.testing.assert_array_equal(read_faces, faces)


@pytest.mark.parametrize("suffix", WRITERS)
def test_trimesh_reads_the_same_triangles(suffix: str, tmp_path: Path) -> None:
    (tmp_path / f"m{suffix}").write_bytes(WRITERS[suffix](*ball()))
    _assert_read_as_trimesh_reads(tmp_path, f"m{suffix}", 320)


@pytest.mark.parametrize("suffix", WRITERS)
def test_files_of_trimesh_are_read_as_trimesh_reads_them(suffix: str, tmp_path: Path) -> None:
    mesh = trimesh.creation.annulus(1, 2, 0.5)
    mesh.export(tmp_path / f"m{suffix}")
    assert len(mesh.faces) > 100
    _assert_read_as_trimesh_reads(tmp_path, f"m{suffix}", len(mesh.faces))


def _assert_read_as_trimesh_reads(folder: Path, name: str, face_count: int) -> None:
    theirs: Any = trimesh.load_mesh(folder / name, process=False, maintain_order=True)
    vertices, faces = read_mesh(folder, name, "file")
    assert len(faces) == face_count
    np.testing.assert_array_equal(vertices[faces], theirs.vertices[theirs.faces])
