"""Triangles to and from trimesh, and into mesh files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh
from trimesh.exchange.gltf import export_glb
from trimesh.exchange.stl import export_stl

from converters.atomic import atomic_file
from minirt.errors import InputError
from minirt.scene import Facets, Scene, Sphere
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


def facets_to_trimesh(facets: Facets) -> trimesh.Trimesh:
    """A triangle, polygon or mesh object for trimesh; vertices, faces and winding as they are."""
    return trimesh.Trimesh(facets.vertices, facets.faces, process=False, validate=False)


def trimesh_to_facets(mesh: trimesh.Trimesh, name: str, material: str) -> Facets:
    """A mesh of trimesh as a scene's object; vertices, faces and winding as they are."""
    vertices = np.array(mesh.vertices, dtype=np.float64)
    return Facets("mesh", name, material, vertices, np.array(mesh.faces, dtype=np.int32))


def scene_to_trimesh(scene: Scene) -> trimesh.Scene:
    """The objects made of triangles; spheres, which trimesh would tessellate, are left out.

    Returns
    -------
    trimesh.Scene
        Geometry ``objects[i]`` for the scene's object number i, its name in the metadata.
    """
    result = trimesh.Scene()
    for index, thing in enumerate(scene.objects):
        if not isinstance(thing, Sphere):
            mesh = facets_to_trimesh(thing)
            mesh.metadata["name"] = thing.name
            result.add_geometry(mesh, node_name=f"objects[{index}]", geom_name=f"objects[{index}]")
    return result


def write_mesh(vertices: Floats, faces: Ints, path: str | Path) -> None:
    """Write triangles to a file that `minirt.mesh_files.read.read_mesh` takes back; atomic.

    Parameters
    ----------
    vertices : (k, 3) float64
        In scene units. OBJ, PLY and OFF keep every bit; STL and GLB are float32 by their format.
    faces : (m, 3) int32
        Order and winding are kept, degenerate triangles too. STL does not keep which vertices
        are shared.
    path : path
        `.obj`, `.ply`, `.stl`, `.glb` or `.off`.

    Raises
    ------
    InputError
        Another suffix, or the path cannot be written.
    """
    writer = _WRITERS.get(Path(path).suffix.lower())
    if writer is None:
        raise InputError("unknown mesh format", where=str(path), expected=", ".join(_WRITERS))
    with atomic_file(path) as temporary:
        temporary.write_bytes(writer(vertices, faces))


def _obj(vertices: Floats, faces: Ints) -> bytes:
    lines = [f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}\n" for a, b, c in (faces + 1).tolist()]
    return "".join(lines).encode()


def _off(vertices: Floats, faces: Ints) -> bytes:
    lines = [f"OFF\n{len(vertices)} {len(faces)} 0\n"]
    lines += [f"{x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist()]
    lines += [f"3 {a} {b} {c}\n" for a, b, c in faces.tolist()]
    return "".join(lines).encode()


def _ply(vertices: Floats, faces: Ints) -> bytes:
    table = np.zeros(len(faces), dtype=_PLY_FACE)
    table["count"], table["indices"] = 3, faces
    header = _PLY_HEADER.format(vertices=len(vertices), faces=len(faces)).encode()
    return header + vertices.astype("<f8").tobytes() + table.tobytes()


def _stl(vertices: Floats, faces: Ints) -> bytes:
    return export_stl(trimesh.Trimesh(vertices, faces, process=False))


def _glb(vertices: Floats, faces: Ints) -> bytes:
    scene = trimesh.Scene(trimesh.Trimesh(vertices, faces, process=False))
    data: bytes = export_glb(scene)  # type: ignore[no-untyped-call]
    return data


_WRITERS: dict[str, Callable[[Floats, Ints], bytes]] = {
    ".obj": _obj,
    ".ply": _ply,
    ".stl": _stl,
    ".glb": _glb,
    ".off": _off,
}
