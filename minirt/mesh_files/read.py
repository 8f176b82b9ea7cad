"""A triangle mesh from a file of any known format, or one clear error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from minirt.errors import SceneError
from minirt.mesh_files import READERS
from minirt.vectors import Floats, Ints

#: Largest mesh file that is read.
MAX_BYTES = 2**30


def read_mesh(folder: Path, file: str, where: str) -> tuple[Floats, Ints]:
    """Vertices and triangles of a mesh file, in the file's order, its scene graph applied.

    A polygon becomes the fan of triangles from its first vertex, as in S11.

    Parameters
    ----------
    folder : Path
        The scene's folder; the file may not lie outside it.
    file : str
        Path relative to it; OBJ, PLY, STL, GLB or OFF. Other files that it names are not read.
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

    Source: S9, S11.
    """
    path = _inside(folder, file, where)
    vertices, faces = _parse(_content(path, file, where), path, file, where)
    if not len(faces):
        raise SceneError("the mesh has no triangles", where=where, got=file)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise SceneError("a face names a vertex that does not exist", where=where, got=file)
    if not np.isfinite(vertices).all():
        raise SceneError("a vertex of the mesh is not finite", where=where, got=file)
    return vertices, faces.astype(np.int32)


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
    if path.suffix.lower() not in READERS:
        raise SceneError(
            "unknown mesh format", where=where, got=file, expected="OBJ, PLY, STL, GLB or OFF"
        )
    return path


def _content(path: Path, file: str, where: str) -> bytes:
    try:
        size = path.stat().st_size
        if not path.is_file():
            raise SceneError("the mesh is not a file", where=where, got=file)
        if size > MAX_BYTES:
            raise SceneError(
                "the mesh file is too large",
                where=where,
                got=f"{file} of {size:,} bytes",
                expected=f"at most {MAX_BYTES:,}",
            )
        return path.read_bytes()
    except OSError as error:
        raise SceneError(
            "the mesh file cannot be opened", where=where, got=f"{file} ({error.strerror})"
        ) from None


def _parse(data: bytes, path: Path, file: str, where: str) -> tuple[Floats, NDArray[np.int64]]:
    try:
        mesh = READERS[path.suffix.lower()](data)
        return mesh.vertices(), mesh.triangles()
    except MemoryError:
        raise SceneError("the mesh does not fit in memory", where=where, got=file) from None
    except (
        ValueError,
        LookupError,
        TypeError,
        AttributeError,
        RecursionError,
        OverflowError,
    ) as error:
        detail = " ".join(str(error).split())[:200]
        raise SceneError(
            "the mesh file cannot be read", where=where, got=f"{file} ({detail})"
        ) from None
