"""Primitives in groups of neighbours, and how they project onto a grid of rays."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from minirt.culling.bounding_tests import GRAZING
from minirt.culling.projection import Projection
from minirt.culling.tree import Tree
from minirt.vectors import Floats, Index, norm


@dataclass(frozen=True, eq=False)
class Projected:
    """Triangles as they project onto a grid, inflated by as much as rays may pass by them.

    Spheres are degenerate triangles, inflated by their radius.

    Attributes
    ----------
    which : (k,) intp
        Their numbers.
    u, v : (3, k) float64
        Of their vertices.
    near, far : (k,) float64
        Least and largest depth.
    grown : (k,) float64
        By how much they are larger in u and v.
    """

    which: Index
    u: Floats
    v: Floats
    near: Floats
    far: Floats
    grown: Floats

    def take(self, index: Index) -> Projected:
        """Some of them."""
        return Projected(*(value.take(index, axis=-1) for value in vars(self).values()))


@dataclass(frozen=True, eq=False)
class PrimitiveGroups(ABC):
    """Primitives in k groups of s neighbours.

    Attributes
    ----------
    members : (k, s) intp
        Their numbers; some stand in two places.
    middle : (3, k) float64
    radius : (k,) float64
        Of a ball around each group.
    """

    members: Index
    middle: Floats
    radius: Floats

    @abstractmethod
    def projected(self, projection: Projection, groups: Index) -> Projected:
        """The members of some groups; of those that are not `beyond` only the depths count."""


@dataclass(frozen=True, eq=False)
class TriangleGroups(PrimitiveGroups):
    """Triangles by their corners (3, 3, k, s), by coordinate and vertex, and unit normals."""

    corners: Floats
    N: NDArray[np.float32]

    @classmethod
    def of(cls, tree: Tree, corners: tuple[Floats, Floats, Floats], N: Floats) -> TriangleGroups:
        """Triangles with those vertices (3, m), as they stand together in their tree."""
        members = _neighbours(tree)
        gathered = np.empty((3, 3, *members.shape))
        for k, vertex in enumerate(corners):
            np.take(vertex, members, axis=1, out=gathered[:, k])
        low, high = gathered.min(axis=(1, 3)), gathered.max(axis=(1, 3))
        normals = N.astype(np.float32).take(members, axis=1)
        return cls(members, (low + high) / 2, norm(high - low) / 2, gathered, normals)

    def projected(self, projection: Projection, groups: Index) -> Projected:
        """The triangles of some groups.

        Where rays meet a plane at a small angle, a kernel's point of it may be anywhere near the
        triangle: it grows by its own length.
        """
        which = self.members.take(groups, axis=0).ravel()
        X = self.corners.take(groups, axis=2).reshape(3, 3, -1)
        N = self.N.take(groups, axis=1).reshape(3, -1).astype(np.float64)
        u, v, depth = (c.reshape(3, -1) for c in projection.points(X.reshape(3, -1)))
        near, far = reduce(np.minimum, depth), reduce(np.maximum, depth)
        grown = np.full(len(which), projection.pad)
        flat = np.flatnonzero(projection.grazes(X[:, 0], N, far, GRAZING))
        corners = X[:, :, flat]
        edges = corners - corners[:, [1, 2, 0]]
        grown[flat] += np.sqrt((edges * edges).sum(axis=0).max(axis=0))
        near, far = near - grown, far + grown
        return Projected(which, u, v, near, far, projection.seen_size(grown, near))


@dataclass(frozen=True, eq=False)
class SphereGroups(PrimitiveGroups):
    """Spheres by their centers (3, k, s) and radii (k, s)."""

    centers: Floats
    radii: Floats

    @classmethod
    def of(cls, tree: Tree, center: Floats, radius: Floats) -> SphereGroups:
        """Spheres of those centers (3, m) and radii (m,), as they stand together in their tree."""
        members = _neighbours(tree)
        centers, radii = center.take(members, axis=1), radius.take(members)
        low, high = (centers - radii).min(axis=2), (centers + radii).max(axis=2)
        return cls(members, (low + high) / 2, norm(high - low) / 2, centers, radii)

    def projected(self, projection: Projection, groups: Index) -> Projected:
        """The spheres of some groups."""
        which = self.members.take(groups, axis=0).ravel()
        grown = self.radii.take(groups, axis=0).ravel() + projection.pad
        u, v, depth = projection.points(self.centers.take(groups, axis=1).reshape(3, -1))
        near, far = depth - grown, depth + grown
        u, v = (np.broadcast_to(x, (3, len(x))) for x in (u, v))
        return Projected(which, u, v, near, far, projection.seen_size(grown, near))


def _neighbours(tree: Tree) -> Index:
    """The primitives (k, s) of a tree that stand together on its last two levels."""
    return tree.primitives.reshape(-1, int(np.prod([boxes.shape[2] for boxes in tree.boxes[-2:]])))
