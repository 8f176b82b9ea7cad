"""A scene as the tracer takes it: resolved to the slides' form; `minirt.load_scene` makes it."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from minirt.scene_file.schema import MaterialModel
from minirt.screen import VirtualScreen
from minirt.shapes.plane import edge_normal
from minirt.shapes.polygon import polygon_normal
from minirt.vectors import Floats, Ints

Material: TypeAlias = MaterialModel


@dataclass(frozen=True, eq=False)
class Sphere:
    """S8's object.

    Attributes
    ----------
    name, material : str
    center : (3,) float64
        In modelling coordinates.
    radius : float
        In scene units, > 0.
    """

    name: str
    material: str
    center: Floats
    radius: float
    type: str = "sphere"

    @property
    def bounds(self) -> Floats:
        """Lower and upper corner of the bounding box, (2, 3)."""
        return np.stack((self.center - self.radius, self.center + self.radius))


@dataclass(frozen=True, eq=False)
class Facets:
    """An object made of triangles: a triangle, a polygon with its fan, or a mesh.

    Attributes
    ----------
    type : str
        triangle, polygon or mesh.
    name, material : str
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

    @property
    def bounds(self) -> Floats:
        """Lower and upper corner of the bounding box, (2, 3)."""
        return np.stack((self.vertices.min(axis=0), self.vertices.max(axis=0)))

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
        A delicate scene's own least share of certain pixels, and why it needs one.
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
    document : dict
        The scene as JSON data, in the slides' form, with every default filled in.
    folder : Path
        Where its mesh files are looked up.
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
        return bounding_box(self.objects)

    def material_of(self, index: int) -> Material:
        """The material of object number `index`."""
        return self.materials[self.objects[index].material]


def bounding_box(objects: tuple[Object, ...]) -> Floats | None:
    """Lower and upper corner of the bounding box of objects, (2, 3) float64; None for no object."""
    if not objects:
        return None
    boxes = np.stack([thing.bounds for thing in objects])
    return np.stack((boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)))
