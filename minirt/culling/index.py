"""What culling keeps of a scene's primitives, kind by kind: trees, planes, groups of neighbours."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from minirt.culling.bounding_tests import BoundingTest, PlaneBoundingTest, SphereBoundingTest
from minirt.culling.cell_bounds import CellRays
from minirt.culling.groups import PrimitiveGroups, SphereGroups, TriangleGroups
from minirt.culling.tree import Tree, build
from minirt.geometry import Geometry, Kind, Polygon, Spheres, Triangles
from minirt.rays import Rays
from minirt.vectors import Bools, Floats, cross, dot, norm

#: The length below which squares of its parts lose digits.
_SHORT = 2.0**-500


class KindIndex(ABC):
    """All primitives of one kind; what is derived from them is made when it is first asked for.

    Attributes
    ----------
    kind : Kind
    count : int
    """

    kind: Kind
    count: int

    @property
    @abstractmethod
    def tree(self) -> Tree:
        """Boxes around the primitives."""

    @property
    @abstractmethod
    def groups(self) -> PrimitiveGroups | None:
        """Groups of neighbours, which can be rasterised; None of a kind that cannot."""

    @abstractmethod
    def bounding_test(self, rays: Rays, t_max: Floats, pad: float) -> BoundingTest:
        """Whether rays may meet primitives, grown by a pad, by t_max (n,)."""

    @abstractmethod
    def met_by(self, cell: CellRays, pad: float) -> Bools:
        """Whether rays of each of b cells may meet each primitive, (count, b)."""


class SphereIndex(KindIndex):
    """All spheres."""

    def __init__(self, spheres: Spheres) -> None:
        self.kind, self.count, self._spheres = Kind.SPHERE, len(spheres.radius), spheres

    @cached_property
    def tree(self) -> Tree:
        """Boxes around the spheres."""
        center, radius = self._spheres.center, self._spheres.radius
        return build(center - radius, center + radius)

    @cached_property
    def groups(self) -> SphereGroups:
        """Their groups of neighbours."""
        return SphereGroups.of(self.tree, self._spheres.center, self._spheres.radius)

    def bounding_test(self, rays: Rays, t_max: Floats, pad: float) -> BoundingTest:
        """By their centres and radii: no pad is needed."""
        return SphereBoundingTest(rays, t_max, self._spheres.center, self._spheres.radius)

    def met_by(self, cell: CellRays, pad: float) -> Bools:
        """By their centres and radii."""
        return cell.meet_spheres(self._spheres.center, self._spheres.radius)


class TriangleIndex(KindIndex):
    """All triangles of triangle objects and meshes."""

    def __init__(self, triangles: Triangles) -> None:
        self.kind, self.count = Kind.TRIANGLES, len(triangles.object)
        self._corners, self._N = (triangles.a, triangles.b, triangles.c), triangles.N

    @cached_property
    def tree(self) -> Tree:
        """Boxes around the triangles."""
        a, b, c = self._corners
        return build(np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c))

    @cached_property
    def planes(self) -> Floats:
        """Their planes, within their edges, (m, 4, 4): see `PlaneBoundingTest`."""
        a, b, c = self._corners
        N = _unit_or_zero(self._N)
        planes = np.empty((N.shape[1], 4, 4))
        planes[:, 0, :3], planes[:, 0, 3] = N.T, dot(a, N)
        for k, (start, end) in enumerate(((a, b), (b, c), (c, a)), 1):
            side = _unit_or_zero(cross(N, end - start))
            planes[:, k, :3] = side.T
            planes[:, k, 3] = np.minimum(dot(side, start), dot(side, end))
        return planes

    @cached_property
    def groups(self) -> TriangleGroups:
        """Their groups of neighbours."""
        return TriangleGroups.of(self.tree, self._corners, _unit_or_zero(self._N))

    def bounding_test(self, rays: Rays, t_max: Floats, pad: float) -> BoundingTest:
        """By their planes and edges."""
        return PlaneBoundingTest(rays, t_max, self.planes, pad)

    def met_by(self, cell: CellRays, pad: float) -> Bools:
        """By their planes."""
        return cell.meet_planes(self.planes, pad)


class PolygonIndex(KindIndex):
    """All polygons, each in a box that holds it wherever its plane can be met."""

    def __init__(self, polygons: tuple[Polygon, ...]) -> None:
        self.kind, self.count, self._polygons = Kind.POLYGON, len(polygons), polygons

    @property
    def groups(self) -> None:
        """None: their vertices differ in number."""

    @cached_property
    def _boxes(self) -> tuple[Floats, Floats]:
        """Lower and upper corners (3, m).

        A polygon may be off its plane by 1e-9 of its size. At the angles at which culling trusts
        a crossing (sine above 2⁻⁸) that moves the crossing by 256 times as much at most.
        """
        vertices = [polygon.facets.vertices for polygon in self._polygons]
        low, high = (np.stack([f(v, axis=0) for v in vertices], axis=1) for f in (np.min, np.max))
        slack = 1e-6 * (high - low).max(axis=0)
        return low - slack, high + slack

    @cached_property
    def tree(self) -> Tree:
        """The tree of their boxes."""
        return build(*self._boxes)

    @cached_property
    def planes(self) -> Floats:
        """Their planes, within their boxes, (m, 5, 4): see `PlaneBoundingTest`."""
        facets = [polygon.facets for polygon in self._polygons]
        N = _unit_or_zero(np.concatenate([each.plane for each in facets], axis=1))
        first = np.concatenate([each.corners[0][:, :1] for each in facets], axis=1)
        axis = (np.argmax(np.abs(N), axis=0)[:, None] + [1, 2]) % 3
        side = np.eye(3)[axis]
        low, high = (np.take_along_axis(ends.T, axis, axis=1) for ends in self._boxes)
        normals = np.concatenate((N.T[:, None], side, -side), axis=1)
        least = np.concatenate((dot(first, N)[:, None], low, -high), axis=1)
        return np.concatenate((normals, least[:, :, None]), axis=2)

    def bounding_test(self, rays: Rays, t_max: Floats, pad: float) -> BoundingTest:
        """By their planes and boxes."""
        return PlaneBoundingTest(rays, t_max, self.planes, pad)

    def met_by(self, cell: CellRays, pad: float) -> Bools:
        """By their planes."""
        return cell.meet_planes(self.planes, pad)


class SceneIndex:
    """What culling keeps of a scene's primitives.

    Attributes
    ----------
    kinds : tuple of KindIndex
        Of each kind of which there is any.
    """

    def __init__(self, geometry: Geometry) -> None:
        spheres, triangles = SphereIndex(geometry.spheres), TriangleIndex(geometry.triangles)
        every: tuple[KindIndex, ...] = (PolygonIndex(geometry.polygons), spheres, triangles)
        self.kinds = tuple(kind for kind in every if kind.count)

    @classmethod
    def of(cls, geometry: Geometry) -> SceneIndex:
        """The index of a scene's primitives; made once for each."""
        known = _KNOWN.get(geometry)
        if known is None:
            known = _KNOWN[geometry] = cls(geometry)
        return known


#: What was made, for as long as its primitives are there.
_KNOWN: WeakKeyDictionary[Geometry, SceneIndex] = WeakKeyDictionary()


def _unit_or_zero(v: Floats) -> Floats:
    """The vectors (3, n) divided by their lengths; zero where squares are too small for that."""
    length = norm(v)
    return np.divide(v, length, where=length > _SHORT, out=np.zeros_like(v))
