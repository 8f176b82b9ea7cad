"""The shapes of surfaces, on which the effect of a renderer's error depends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from minirt.geometry import Geometry, Kind
from minirt.hits import RayHits
from minirt.scene import Facets
from minirt.vectors import Floats, Index, cross, norm, unit


@dataclass(frozen=True, eq=False)
class PerSurface:
    """A number for each sphere, each triangle, and each triangle of each polygon's fan.

    Attributes
    ----------
    numbers : (m,) float64
    first : (objects,) intp
        The index of each object's first number.
    """

    numbers: Floats
    first: Index

    def at(self, hits: RayHits) -> Floats:
        """The number (n,) at each hit; +inf where nothing is hit."""
        number = np.full(hits.object.shape, np.inf)
        on = np.flatnonzero(hits.object >= 0)
        number[on] = self.numbers[self.first[hits.object[on]] + hits.triangle[on]]
        return number


@dataclass(frozen=True, eq=False)
class Surfaces:
    """The shapes of a scene's surfaces.

    Attributes
    ----------
    levers : PerSurface
        The length by which an error turns a surface: radius of spheres, least height of facets.
    edges : PerSurface
        Longest edge of facets; 0 for spheres.
    extent : float
        Of the scene.
    """

    levers: PerSurface
    edges: PerSurface
    extent: float

    @classmethod
    def of(cls, geometry: Geometry, extent: float) -> Surfaces:
        """The surfaces of a scene."""
        radius = geometry.spheres.radius
        return cls(
            _per_surface(geometry, radius, _least_height),
            _per_surface(geometry, np.zeros_like(radius), _longest_edge),
            extent,
        )

    def shape(self, hits: RayHits) -> tuple[Floats, Floats]:
        """Longest edge over height of the facet at each hit, and that edge over the extent.

        Both (n,); 0 on spheres and where nothing is hit.
        """
        edge = self.edges.at(hits)
        edge = np.where(np.isfinite(edge), edge, 0.0)
        return edge / self.levers.at(hits), edge / self.extent


def warp(geometry: Geometry) -> float:
    """The largest distance of polygons' vertices from the planes that a renderer may choose.

    The coordinates of a polygon's vertices have few digits, so that they need not lie in one plane
    exactly. One renderer then takes the sum of the fan's normals, another the first or the longest.
    """
    return max((_off_plane(polygon.facets) for polygon in geometry.polygons), default=0.0)


def _off_plane(facets: Facets) -> float:
    normals = facets.edge_normals[:, norm(facets.edge_normals) > 0]
    first, longest = normals[:, :1], normals[:, [norm(normals).argmax()]]
    planes = unit(np.hstack((facets.plane, first, longest)))
    off: Floats = np.abs((facets.vertices - facets.vertices[0]) @ planes)
    return float(off.max())


def _per_surface(
    geometry: Geometry, spheres: Floats, of_facets: Callable[[Floats, Floats, Floats], Floats]
) -> PerSurface:
    tri = geometry.triangles
    polygons = [of_facets(*polygon.facets.corners) for polygon in geometry.polygons]
    numbers = [spheres, of_facets(tri.a, tri.b, tri.c), *polygons]
    # Blocks of numbers: all spheres, all triangles, then polygon by polygon.
    begin = np.cumsum([0, *(len(each) for each in numbers)])
    of_polygon = geometry.kind == Kind.POLYGON
    block = np.where(of_polygon, 2 + geometry.first, geometry.kind == Kind.TRIANGLES)
    first = begin[block] + np.where(of_polygon, 0, geometry.first)
    return PerSurface(np.concatenate(numbers), first)


def _least_height(a: Floats, b: Floats, c: Floats) -> Floats:
    """Twice the area over the longest edge, (m,); 0 where degenerate."""
    longest = _longest_edge(a, b, c)
    height: Floats = norm(cross(b - a, c - a)) / np.where(longest > 0, longest, 1.0)
    return height


def _longest_edge(a: Floats, b: Floats, c: Floats) -> Floats:
    longest: Floats = np.maximum(np.maximum(norm(b - a), norm(c - b)), norm(a - c))
    return longest
