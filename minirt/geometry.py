"""A scene's primitives as arrays, and the trees that cull them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from minirt.culling import rasteriser
from minirt.culling.tree import Tree, build
from minirt.memory import require_memory
from minirt.scene import Facets, Scene, Sphere
from minirt.vectors import Floats, Index, Ints, cross, dot, norm

#: Bytes that a triangle takes, most of them in its tree and while that is built; measured.
_EACH = 700
#: The length below which squares of its parts lose digits.
_SHORT = 2.0**-500

#: Triangles of a fan that are handed over with each ray anew.
_FEW = 8


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

    @cached_property
    def tree(self) -> Tree:
        """Boxes around the spheres."""
        return build(self.center - self.radius, self.center + self.radius)

    @cached_property
    def groups(self) -> rasteriser.SphereGroups:
        """Their groups of neighbours."""
        return rasteriser.SphereGroups.of(self.tree, self.center, self.radius)


@dataclass(frozen=True, eq=False)
class Triangles:
    """All triangles of triangle objects and meshes: a, b, c, N (3, m), object, face (m,)."""

    a: Floats
    b: Floats
    c: Floats
    N: Floats
    object: Ints
    face: Ints

    @cached_property
    def tree(self) -> Tree:
        """Boxes around the triangles."""
        lower = np.minimum(np.minimum(self.a, self.b), self.c)
        return build(lower, np.maximum(np.maximum(self.a, self.b), self.c))

    @cached_property
    def patches(self) -> Floats:
        """Their planes, within their edges, (m, 4, 4): see `PlaneBoundingTest`."""
        N = _unit_or_zero(self.N)
        patches = np.empty((N.shape[1], 4, 4))
        patches[:, 0, :3], patches[:, 0, 3] = N.T, dot(self.a, N)
        edges = ((self.a, self.b), (self.b, self.c), (self.c, self.a))
        for k, (start, end) in enumerate(edges, 1):
            side = _unit_or_zero(cross(N, end - start))
            patches[:, k, :3] = side.T
            patches[:, k, 3] = np.minimum(dot(side, start), dot(side, end))
        return patches

    @cached_property
    def groups(self) -> rasteriser.TriangleGroups:
        """Their groups of neighbours."""
        return rasteriser.TriangleGroups.of(
            self.tree, (self.a, self.b, self.c), _unit_or_zero(self.N)
        )


@dataclass(frozen=True, eq=False)
class Polygon:
    """One polygon: its number among the objects, and its facets."""

    object: int
    facets: Facets

    @property
    def box(self) -> tuple[Floats, Floats]:
        """Corners (3,) of a box that holds the polygon wherever its plane can be met.

        A polygon may be off its plane by 1e-9 of its size. At the angles at which culling trusts
        a crossing (sine above 2⁻⁸) that moves the crossing by 256 times as much at most.
        """
        low, high = self.facets.vertices.min(axis=0), self.facets.vertices.max(axis=0)
        slack = 1e-6 * (high - low).max()
        return low - slack, high + slack


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
        kind = np.where(counts <= _FEW, counts, _FEW + 1 + np.arange(len(counts)))
        alike = (np.flatnonzero(kind == k) for k in np.unique(kind))
        return tuple(Fans.of(self.polygons, chosen) for chosen in alike)

    @cached_property
    def polygon_tree(self) -> Tree:
        """Boxes around the polygons."""
        lower, upper = zip(*(polygon.box for polygon in self.polygons), strict=True)
        return build(np.stack(lower, axis=1), np.stack(upper, axis=1))

    @cached_property
    def polygon_patches(self) -> Floats:
        """The polygons' planes, within their boxes, (m, 5, 4): see `PlaneBoundingTest`."""
        lower, upper = zip(*(polygon.box for polygon in self.polygons), strict=True)
        facets = [polygon.facets for polygon in self.polygons]
        N = _unit_or_zero(np.concatenate([each.plane for each in facets], axis=1))
        first = np.concatenate([each.corners[0][:, :1] for each in facets], axis=1)
        axis = (np.argmax(np.abs(N), axis=0)[:, None] + [1, 2]) % 3
        side = np.eye(3)[axis]
        low, high = (np.take_along_axis(np.stack(ends), axis, axis=1) for ends in (lower, upper))
        normals = np.concatenate((N.T[:, None], side, -side), axis=1)
        least = np.concatenate((dot(first, N)[:, None], low, -high), axis=1)
        return np.concatenate((normals, least[:, :, None]), axis=2)

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


#: What was gathered, with its trees, for as long as its scene is there.
_KNOWN: WeakKeyDictionary[Scene, Geometry] = WeakKeyDictionary()


def _unit_or_zero(v: Floats) -> Floats:
    """The vectors (3, n) divided by their lengths; zero where squares are too small for that."""
    length = norm(v)
    return np.divide(v, length, where=length > _SHORT, out=np.zeros_like(v))


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
