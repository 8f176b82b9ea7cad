"""A triangle mesh from a file: one object made of many of S9's triangles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from minirt.errors import SceneError
from minirt.vectors import Floats, Ints

MAX_BYTES = 2**30
MAX_FACES = 10_000_000


def read_mesh(folder: Path, file: str, where: str) -> tuple[Floats, Ints]:
    """Vertices and faces of a mesh file, in the file's order, with its scene graph applied.

    Parameters
    ----------
    folder : Path
        The scene's folder; the file may not lie outside it.
    file : str
        Path relative to it; any format that trimesh reads from one file (OBJ, PLY, STL, GLB, OFF).
    where : str
        The JSON path, for errors.

    Returns
    -------
    vertices : (k, 3) float64
    faces : (m, 3) int32

    Raises
    ------
    SceneError
        Outside the folder, missing, too large, unreadable, without faces or not finite.
    """
    path = _inside(folder, file, where)
    try:
        size = path.stat().st_size
    except OSError as error:
        raise SceneError(
            "the mesh file cannot be opened", where=where, got=f"{file} ({error.strerror})"
        ) from None
    if not path.is_file():
        raise SceneError("the mesh is not a file", where=where, got=file)
    if size > MAX_BYTES:
        raise SceneError(
            "the mesh file is too large",
            where=where,
            got=f"{file} of {size:,} bytes",
            expected=f"at most {MAX_BYTES:,}",
        )
    vertices, faces = _parse(path, file, where)
    if not len(faces):
        raise SceneError("the mesh has no triangles", where=where, got=file)
    if len(faces) > MAX_FACES:
        raise SceneError(
            "the mesh has too many triangles",
            where=where,
            got=f"{len(faces):,} in {file}",
            expected=f"at most {MAX_FACES:,}",
        )
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise SceneError("a face names a vertex that is not there", where=where, got=file)
    if not np.isfinite(vertices).all():
        raise SceneError("a vertex of the mesh is not finite", where=where, got=file)
    return vertices, faces.astype(np.int32)


def transform_points(matrix: Any, points: Floats) -> Floats:
    """Points (k, 3) under an affine 4 × 4 matrix, elementwise: the same bits on every CPU."""
    x, y, z = points.T
    return np.stack(
        [row[0] * x + row[1] * y + row[2] * z + row[3] for row in list(matrix)[:3]], axis=1
    )


def _inside(folder: Path, file: str, where: str) -> Path:
    try:
        root = folder.resolve()
        path = (root / file).resolve()
    except (OSError, ValueError, RuntimeError):
        raise SceneError("not a usable path", where=where, got=repr(file)[:200]) from None
    if Path(file).is_absolute() or not path.is_relative_to(root):
        raise SceneError(
            "the mesh file lies outside the scene's folder",
            where=where,
            got=file,
            expected="a path relative to the scene file, inside its folder",
        )
    return path


def _parse(path: Path, file: str, where: str) -> tuple[Floats, Ints]:
    try:
        import trimesh
    except ImportError:
        raise SceneError(
            "reading a mesh needs trimesh, which is not installed",
            where=where,
            expected="pip install 'minirt[mesh]'",
        ) from None
    kind = path.suffix.lower().lstrip(".")
    if kind not in trimesh.available_formats():
        raise SceneError(
            "unknown mesh format", where=where, got=file, expected="OBJ, PLY, STL, GLB or OFF"
        )
    try:
        with path.open("rb") as stream:  # no resolver: nothing but this file is read
            loaded = trimesh.load_scene(
                stream, file_type=kind, process=False, maintain_order=True, skip_materials=True
            )
        return _flatten(loaded)
    except MemoryError:
        raise SceneError("the mesh does not fit in memory", where=where, got=file) from None
    except Exception as error:  # trimesh's loaders raise whatever their parsers meet
        detail = " ".join(str(error).split())[:200] or type(error).__name__
        raise SceneError(
            "the mesh file cannot be read", where=where, got=f"{file} ({detail})"
        ) from None


def _flatten(loaded: Any) -> tuple[Floats, Ints]:
    """Every triangle of a trimesh scene, node by node in the graph's order."""
    vertices: list[Floats] = [np.zeros((0, 3))]
    faces: list[Ints] = [np.zeros((0, 3), dtype=np.int32)]
    count = 0
    for node in loaded.graph.nodes_geometry:
        matrix, name = loaded.graph[node]
        part = loaded.geometry[name]
        if not hasattr(part, "faces"):
            continue
        points = transform_points(matrix.tolist(), np.asarray(part.vertices, dtype=np.float64))
        vertices.append(points)
        faces.append(np.asarray(part.faces, dtype=np.int64).reshape(-1, 3) + count)
        count += len(points)
    return np.concatenate(vertices), np.concatenate(faces)
