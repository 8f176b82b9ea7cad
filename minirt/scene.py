"""A scene: loaded, checked, resolved to the slides' form, ready to be traced."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from pydantic import ValidationError

from minirt.errors import SceneError
from minirt.mesh_files.read import read_mesh
from minirt.mesh_files.transform import transform_points
from minirt.scene_file.look_at import resolve_look_at
from minirt.scene_file.schema import (
    LARGEST,
    MAX_PIXELS,
    SMALLEST,
    LookAtScreenModel,
    MaterialModel,
    MeshModel,
    ObjectModel,
    PolygonModel,
    SceneModel,
    ScreenModel,
    SphereModel,
)
from minirt.scene_file.text import atlas_names as atlas_names
from minirt.scene_file.text import decode, read_text
from minirt.scene_file.validation import first_fault, shortened
from minirt.screen import VirtualScreen
from minirt.shapes.plane import edge_normal
from minirt.shapes.polygon import fan, polygon_fault, polygon_normal
from minirt.vectors import Floats, Ints, dot, norm

Material: TypeAlias = MaterialModel


@dataclass(frozen=True, eq=False)
class Sphere:
    """S8's object: center (3,) float64 and radius, in scene units."""

    name: str
    material: str
    center: Floats
    radius: float
    type: str = "sphere"


@dataclass(frozen=True, eq=False)
class Facets:
    """An object made of triangles: a triangle, a polygon with its fan, or a mesh.

    Attributes
    ----------
    type : str
        triangle, polygon or mesh.
    vertices : (k, 3) float64
        In modelling coordinates.
    faces : (m, 3) int32
        Vertex indices of each triangle, in the order that `triangle` counts them.
    """

    type: str
    name: str
    material: str
    vertices: Floats
    faces: Ints

    @cached_property
    def corners(self) -> tuple[Floats, Floats, Floats]:
        """Vertices a, b, c of every triangle, each (3, m)."""
        a, b, c = (np.ascontiguousarray(self.vertices[self.faces[:, k]].T) for k in range(3))
        return a, b, c

    @cached_property
    def edge_normals(self) -> Floats:
        """(b − a) × (c − a) of every triangle, (3, m); zero where degenerate."""
        return edge_normal(*self.corners)

    @cached_property
    def plane(self) -> Floats:
        """A polygon's normal p, (3, 1), of any length."""
        return polygon_normal(self.edge_normals)


Object: TypeAlias = Sphere | Facets


@dataclass(frozen=True, eq=False, repr=False)
class Scene:
    """One scene, resolved. Made by `load_scene`.

    Attributes
    ----------
    name, about, proves, failure_means : str
        What it is called, what it proves, and what a failure usually means.
    rules : tuple of str
        The rules it says it exercises.
    floor : tuple (share, reason) or None
        A delicate scene's own floor for the share of certain pixels.
    screen : VirtualScreen
    light_direction : tuple of 3 float
        Direction of travel, of any length but 0.
    light_color, background : tuple of 3 float
        Linear RGB.
    shadow_color : tuple of 3 float or None
        None: the ambient term alone.
    epsilon : float
        Where secondary rays start, in scene units; resolved.
    max_depth : int
    materials : dict of str to Material
    objects : tuple of Sphere or Facets
    extent : float
        Largest distance among P0 and the corners of the objects' bounding box.
    """

    name: str
    about: str
    proves: str
    failure_means: str
    rules: tuple[str, ...]
    floor: tuple[float, str] | None
    screen: VirtualScreen
    light_direction: tuple[float, float, float]
    light_color: tuple[float, float, float]
    background: tuple[float, float, float]
    shadow_color: tuple[float, float, float] | None
    epsilon: float
    max_depth: int
    materials: dict[str, Material]
    objects: tuple[Object, ...]
    extent: float
    document: dict[str, Any]
    folder: Path

    def __repr__(self) -> str:
        size = f"{self.screen.nx} × {self.screen.ny}"
        return f"<Scene {self.name[:80]!r}: {size}, objects: {len(self.objects)}>"

    def to_dict(self) -> dict[str, Any]:
        """The scene as a JSON document in the slides' form; `load_scene` takes it back.

        A mesh stays a path relative to `folder`.
        """
        copy: dict[str, Any] = json.loads(self.canonical_json)
        return copy

    @cached_property
    def canonical_json(self) -> str:
        """The document with sorted keys and no white space; numbers as shortest round trip."""
        return json.dumps(
            self.document,
            sort_keys=True,
            separators=(",", ":"),
            ensure_ascii=False,
            allow_nan=False,
        )

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the canonical JSON, in hexadecimal."""
        return hashlib.sha256(self.canonical_json.encode()).hexdigest()

    @cached_property
    def bounds(self) -> Floats | None:
        """Lower and upper corner of the objects' bounding box, (2, 3); None without objects."""
        return object_bounds(self.objects)

    def material_of(self, index: int) -> Material:
        """The material of object number `index`."""
        return self.materials[self.objects[index].material]


def load_scene(source: str | Path | dict[str, Any], folder: str | Path | None = None) -> Scene:
    """Load, check and resolve a scene.

    Parameters
    ----------
    source : path, ``-`` for standard input, ``atlas:NAME``, or a dict of the JSON
    folder : path, optional
        Where meshes are looked up; the scene file's own folder, or the working folder.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        One error that names the file, the JSON path, what is wrong and what would be right.

    Examples
    --------
    >>> load_scene("atlas:one-sphere").objects[0].radius
    1.0
    """
    if isinstance(source, dict):
        label, base = "scene", Path()
        try:
            text = json.dumps(source)
        except (TypeError, ValueError, RecursionError) as error:
            raise SceneError("the scene is not JSON data", where=label, got=str(error)) from None
    else:
        label, base, text = read_text(str(source))
    return _resolve(_validate(decode(text, label), label), label, Path(folder or base))


def object_bounds(objects: tuple[Object, ...]) -> Floats | None:
    """Lower and upper corner of a bounding box of objects, (2, 3) float64; None for no object."""
    if not objects:
        return None
    boxes = []
    for thing in objects:
        if isinstance(thing, Sphere):
            boxes.append((thing.center - thing.radius, thing.center + thing.radius))
        else:
            boxes.append((thing.vertices.min(axis=0), thing.vertices.max(axis=0)))
    return np.stack((np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)))


def _validate(document: Any, label: str) -> SceneModel:
    try:
        return SceneModel.model_validate(document)
    except ValidationError as error:
        raise first_fault(error, label) from None


def _resolve(model: SceneModel, label: str, folder: Path) -> Scene:
    screen = _screen(model.screen, label)
    _require_length(model.light.direction, f"{label}: light.direction", "the light's direction")
    objects = tuple(
        _object(entry, model, index, f"{label}: objects[{index}]", folder)
        for index, entry in enumerate(model.objects)
    )
    extent = _extent(screen, objects)
    document = model.model_dump(mode="json", exclude={"screen"})
    document["screen"] = ScreenModel(**vars(screen)).model_dump(mode="json")
    for entry, thing in zip(document["objects"], objects, strict=True):
        entry["name"] = thing.name
    return Scene(
        name=model.name,
        about=model.about,
        proves=model.proves,
        failure_means=model.failure_means,
        rules=tuple(model.rules),
        floor=(model.floor.certain, model.floor.why) if model.floor else None,
        screen=screen,
        light_direction=model.light.direction,
        light_color=model.light.color,
        background=model.background,
        shadow_color=model.shadow_color,
        epsilon=1e-6 * extent if model.epsilon is None else model.epsilon,
        max_depth=model.max_depth,
        materials=dict(model.materials),
        objects=objects,
        extent=extent,
        document=document,
        folder=folder,
    )


def _screen(model: ScreenModel | LookAtScreenModel, label: str) -> VirtualScreen:
    where = f"{label}: screen"
    if model.nx * model.ny > MAX_PIXELS:
        raise SceneError(
            "the image is over the size limit",
            where=f"{where}.nx",
            got=f"{model.nx} × {model.ny}",
            expected=f"at most {MAX_PIXELS:,} pixels",
        )
    if isinstance(model, LookAtScreenModel):
        return resolve_look_at(model, where)
    axes = {name: np.array(getattr(model, name)) for name in "uvn"}
    for name, axis in axes.items():
        if abs(float(dot(axis, axis)) - 1) > 2e-9:
            raise SceneError(
                "the frame is not orthonormal: not a unit vector",
                where=f"{where}.{name}",
                got=f"length {float(norm(axis))!r}",
                expected="1 to within 1e-9" + _normalised(axis),
            )
    for first, second in ("uv", "un", "vn"):
        if abs(float(dot(axes[first], axes[second]))) > 1e-9:
            raise SceneError(
                "the frame is not orthonormal: two axes are not perpendicular",
                where=f"{where}.{second}",
                got=f"{first}·{second} = {float(dot(axes[first], axes[second]))!r}",
                expected="0 to within 1e-9",
            )
    if abs(model.nu) < SMALLEST:
        raise SceneError(
            "the screen would contain the observer",
            where=f"{where}.nu",
            got=repr(model.nu),
            expected="a number other than 0, of either sign",
        )
    for low, high in ("lr", "bt"):
        if not getattr(model, high) - getattr(model, low) >= SMALLEST:
            raise SceneError(
                "the screen has no area",
                where=f"{where}.{high}",
                got=f"{low} = {getattr(model, low)!r}, {high} = {getattr(model, high)!r}",
                expected=f"{low} < {high}",
            )
    return VirtualScreen(**model.model_dump())


def _normalised(axis: Floats) -> str:
    length = float(norm(axis))
    return f", as {(axis / length).tolist()}" if length >= SMALLEST else ""


def _require_length(vector: tuple[float, float, float], where: str, what: str) -> None:
    if max(map(abs, vector)) < SMALLEST:
        raise SceneError(
            f"{what} is the zero vector", where=where, got=str(list(vector)), expected="any other"
        )


def _object(entry: ObjectModel, model: SceneModel, index: int, where: str, folder: Path) -> Object:
    if entry.material not in model.materials:
        raise SceneError(
            "unknown material",
            where=f"{where}.material",
            got=shortened(entry.material),
            expected="one of " + shortened(sorted(model.materials)),
        )
    name = entry.name or f"{entry.type}-{index}"
    if isinstance(entry, SphereModel):
        return Sphere(name, entry.material, np.array(entry.center), entry.radius)
    if isinstance(entry, MeshModel):
        return _mesh(entry, name, where, folder)
    vertices = np.array(entry.vertices, dtype=np.float64)
    facets = Facets(entry.type, name, entry.material, vertices, fan(len(vertices)))
    if isinstance(entry, PolygonModel):
        fault = polygon_fault(vertices, facets.edge_normals)
        if fault:
            raise SceneError(
                fault, where=f"{where}.vertices", expected="a convex planar polygon, in order"
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


def _extent(screen: VirtualScreen, objects: tuple[Object, ...]) -> float:
    box = object_bounds(objects)
    if box is None:
        return abs(screen.nu)
    corners = np.stack(np.meshgrid(*box.T, indexing="ij")).reshape(3, -1)
    diagonal = float(norm(box[1] - box[0]))
    reach = float(norm(corners - np.array(screen.P0).reshape(3, 1)).max())
    return max(diagonal, reach)
