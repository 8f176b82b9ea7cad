"""The objects of a scene file, with what joins them to the rest checked: materials, mesh files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from minirt.errors import SceneError
from minirt.mesh_files.read import read_mesh
from minirt.mesh_files.transform import transform_points
from minirt.scene import Facets, Object, Sphere
from minirt.scene_file.schema import (
    LARGEST,
    MeshModel,
    ObjectModel,
    PolygonModel,
    SceneDocument,
    SphereModel,
)
from minirt.scene_file.validation import shortened
from minirt.shapes.polygon import fan, polygon_fault


def resolve_objects(document: SceneDocument, label: str, folder: Path) -> tuple[Object, ...]:
    """The objects of a scene, in its order; an object without a name is called TYPE-NUMBER.

    Parameters
    ----------
    document : SceneDocument
    label : str
        The scene's file, for errors.
    folder : Path
        Where mesh files are looked up.

    Raises
    ------
    SceneError
        An unknown material, a polygon that S11 cannot take, or a mesh that cannot be read.
    """
    return tuple(
        _object(entry, document, index, f"{label}: objects[{index}]", folder)
        for index, entry in enumerate(document.objects)
    )


def _object(
    entry: ObjectModel, document: SceneDocument, index: int, where: str, folder: Path
) -> Object:
    if entry.material not in document.materials:
        raise SceneError(
            "unknown material",
            where=f"{where}.material",
            got=shortened(entry.material),
            expected="one of " + shortened(sorted(document.materials)),
        )
    name = entry.name or f"{entry.type}-{index}"
    if isinstance(entry, SphereModel):
        return Sphere(name, entry.material, np.array(entry.center), entry.radius)
    if isinstance(entry, MeshModel):
        return _mesh(entry, name, where, folder)
    vertices = np.array(entry.vertices, dtype=np.float64)
    facets = Facets(entry.type, name, entry.material, vertices, fan(len(vertices)))
    if isinstance(entry, PolygonModel):
        reason = polygon_fault(vertices, facets.edge_normals)
        if reason:
            raise SceneError(
                reason, where=f"{where}.vertices", expected="a convex planar polygon, in order"
            )
    return facets


def _mesh(entry: MeshModel, name: str, where: str, folder: Path) -> Facets:
    matrix = entry.transform
    if matrix[3] != (0, 0, 0, 1):
        raise SceneError(
            "the transform is not affine",
            where=f"{where}.transform[3]",
            got=str(list(matrix[3])),
            expected="[0, 0, 0, 1]",
        )
    vertices, faces = read_mesh(folder, entry.file, f"{where}.file")
    vertices = transform_points(matrix, vertices)
    if not (np.abs(vertices) <= LARGEST).all():
        raise SceneError(
            "a vertex of the mesh is out of range",
            where=f"{where}.file",
            got=entry.file,
            expected=f"coordinates within ±{LARGEST:g}",
        )
    return Facets("mesh", name, entry.material, vertices, faces)
