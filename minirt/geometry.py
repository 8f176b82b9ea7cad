"""A scene's primitives as arrays, kind by kind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from minirt.memory import require_memory
from minirt.scene import Facets, Scene, Sphere
from minirt.vectors import Floats, Index, Ints

#: Bytes that a triangle takes, most of them in its tree and while that is built; measured.
_EACH = 700
#: Triangles of the largest fan that is handed over with each ray anew.
_LARGEST_FAN = 8


class Kind(IntEnum):
    """Which of the three tests an object's primitives go through."""

    SPHERE = 0
    POLYGON = 1
    TRIANGLES = 2


@dataclass(frozen=True, eq=False)
class Spheres:
    """All spheres: center (3, m), radius (m,), object (m,)."""

    center: Floats
    radius: Floats
    object: Ints


@dataclass(frozen=True, eq=False)
class Triangles:
    """All triangles of triangle objects and meshes: a, b, c, N (3, m), object, face (m,)."""

    a: Floats
    b: Floats
    c: Floats
    N: Floats
    object: Ints
    face: Ints


@dataclass(frozen=True, eq=False)
class Polygon:
    """One polygon: its number among the objects, and its facets."""

    object: int
    facets: Facets


@dataclass(frozen=True, eq=False)
class Fans:
    """k polygons of as many vertices, side by side.

    Attributes
    ----------
    place : (polygons,) intp
        Where each of the scene's polygons stands here; −1 for those of other numbers of vertices.
    object : (k,) int32
    corners : three (3, m − 2, k) float64
        The triangles of their fans.
    normals : (3, m − 2, k) float64
    plane : (3, k) float64
        Their normals p.
    """

    place: Index
    object: Ints
    corners: tuple[Floats, Floats, Floats]
    normals: Floats
    plane: Floats

    @classmethod
    def of(cls, polygons: Sequence[Polygon], chosen: Index) -> Fans:
        """Some of the polygons."""
        place = np.full(len(polygons), -1, dtype=np.intp)
        place[chosen] = np.arange(len(chosen))
        facets = [polygons[k].facets for k in chosen]
        a, b, c = (np.stack([each.corners[k] for each in facets], axis=2) for k in range(3))
        return cls(
            place, np.array([polygons[k].object for k in chosen], dtype=np.int32), (a, b, c),
            np.stack([each.edge_normals for each in facets], axis=2),
            np.concatenate([each.plane for each in facets], axis=1),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Geometry:
    """What the rays of one scene can meet.

    `first` gives each object's place among the primitives of its kind: its sphere, its first
    triangle, its polygon.
    """

    spheres: Spheres
    triangles: Triangles
    polygons: tuple[Polygon, ...]
    kind: Ints
    first: Ints

    @cached_property
    def fans(self) -> tuple[Fans, ...]:
        """The polygons: those of as many vertices together, if they are few, the others alone."""
        counts = np.array([len(polygon.facets.faces) for polygon in self.polygons])
        kind = np.where(counts <= _LARGEST_FAN, counts, _LARGEST_FAN + 1 + np.arange(len(counts)))
        alike = (np.flatnonzero(kind == k) for k in np.unique(kind))
        return tuple(Fans.of(self.polygons, chosen) for chosen in alike)

    @classmethod
    def of(cls, scene: Scene) -> Geometry:
        """A scene's primitives, in the order of its objects; gathered once for each scene."""
        known = _KNOWN.get(scene)
        if known is None:
            known = _KNOWN[scene] = cls._gathered(scene)
        return known

    @classmethod
    def _gathered(cls, scene: Scene) -> Geometry:
        spheres: list[tuple[int, Sphere]] = []
        flat: list[tuple[int, Facets]] = []
        polygons: list[Polygon] = []
        place = []
        faces = 0
        for index, thing in enumerate(scene.objects):
            if isinstance(thing, Sphere):
                place.append((Kind.SPHERE, len(spheres)))
                spheres.append((index, thing))
            elif thing.type == "polygon":
                place.append((Kind.POLYGON, len(polygons)))
                polygons.append(Polygon(index, thing))
            else:
                place.append((Kind.TRIANGLES, faces))
                flat.append((index, thing))
                faces += len(thing.faces)
        require_memory(_EACH * faces, f"{scene.name}: {faces:,} triangles")
        kind, first = np.array(place, dtype=np.int32).reshape(-1, 2).T
        return cls(_spheres(spheres), _triangles(flat), tuple(polygons), kind, first)


#: What was gathered, for as long as its scene is there.
_KNOWN: WeakKeyDictionary[Scene, Geometry] = WeakKeyDictionary()


def _spheres(found: list[tuple[int, Sphere]]) -> Spheres:
    return Spheres(
        np.array([s.center for _, s in found], dtype=np.float64).reshape(-1, 3).T.copy(),
        np.array([s.radius for _, s in found], dtype=np.float64),
        np.array([index for index, _ in found], dtype=np.int32),
    )


def _triangles(found: list[tuple[int, Facets]]) -> Triangles:
    empty = np.zeros((3, 0))
    a, b, c = (np.concatenate([empty, *(f.corners[k] for _, f in found)], axis=1) for k in range(3))
    normals = np.concatenate([empty, *(f.edge_normals for _, f in found)], axis=1)
    counts = [len(f.faces) for _, f in found]
    objects = np.repeat(np.array([i for i, _ in found], dtype=np.int32), counts)
    faces = [np.arange(k, dtype=np.int32) for k in counts]
    face = np.concatenate([np.zeros(0, dtype=np.int32), *faces])
    return Triangles(a, b, c, normals, objects, face)
