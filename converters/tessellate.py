"""Spheres as triangles, with a bound on how far the triangles are from the sphere.

A sphere becomes an icosphere: an icosahedron whose faces are cut into f² triangles each, with every
vertex pushed out to one distance from the centre. Let the vertices lie on the unit sphere and h be
the least distance of a facet's plane from the centre: the polyhedron then contains the sphere of
radius h and lies within the unit sphere. With its vertices at 2·R/(1 + h) it lies between the
spheres of radius R − e and R + e,

    e = R·(1 − h)/(1 + h),

so that the error is balanced around the true sphere: half the sagitta R·(1 − h) of an inscribed
polyhedron, on either side. h is computed from the triangles themselves, so that the bound holds for
them.

How many triangles it takes: the widest facet is the one at the middle of an icosahedron's face.
Its circumradius there is 1/f of the face's, a/√3 with a = 1.0515 the icosahedron's edge, seen
from 0.7947, the face's distance: an angle ρ of tan ρ = 0.764/f. With h = cos ρ, e = R·tan²(ρ/2),
hence f = 0.382·√(R/e) and 20·f² = 2.92·R/e triangles; a sphere of meridians and parallels takes
twice as many.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from minirt.vectors import Floats, Ints, cross, dot, norm

#: Cuts of an icosahedron's edge for an error of R: half the angle of its widest facet, over R.
_CUTS = 0.382
#: Triangles for an error of R.
TRIANGLES = 20 * _CUTS**2


@dataclass(frozen=True, eq=False)
class Icosphere:
    """A subdivided icosahedron with its vertices on the unit sphere.

    Attributes
    ----------
    vertices : (k, 3) float64
    faces : (m, 3) int32
        Counter-clockwise seen from outside; neighbours share their vertices.
    inner : float
        h: least distance of a face's plane from the centre.
    """

    vertices: Floats
    faces: Ints
    inner: float

    @property
    def error(self) -> float:
        """e for radius 1: the largest distance of the balanced polyhedron from the sphere."""
        return (1.0 - self.inner) / (1.0 + self.inner)

    def around(self, center: Floats, radius: float) -> Floats:
        """Vertices (k, 3) of the balanced polyhedron of a sphere, in its units."""
        placed: Floats = center + radius * (1.0 + self.error) * self.vertices
        return placed


def icosphere_within(bound: float, most: int = 2_000_000) -> Icosphere:
    """The coarsest icosphere with an error of at most `bound`, or the finest of `most` triangles.

    Parameters
    ----------
    bound : float
        Largest error as a share of the radius, ≥ 0.
    most : int
        Triangles, at least 20. Where they do not suffice, its `error` is larger than `bound`.

    Examples
    --------
    >>> icosphere = icosphere_within(1e-3)
    >>> icosphere.error <= 1e-3, len(icosphere.faces)
    (True, 3380)
    """
    finest = max(1, math.isqrt(most // 20))
    cuts = finest if bound * finest**2 <= _CUTS**2 else math.ceil(_CUTS / math.sqrt(bound))
    while (icosphere := unit_icosphere(cuts)).error > bound and cuts < finest:
        cuts += 1
    return icosphere


@lru_cache(maxsize=64)
def unit_icosphere(cuts: int) -> Icosphere:
    """An icosahedron with every edge cut into `cuts` parts, its vertices on the unit sphere."""
    corners, triangles = _icosahedron()
    weights, small = _cut_triangle(cuts)
    points = sum(weights[:, k, None] * corners[triangles[:, k], None] for k in range(3))
    # neighbouring faces add the same numbers in the same order, so shared points are equal
    vertices, number = np.unique(np.reshape(points, (-1, 3)) + 0.0, axis=0, return_inverse=True)
    vertices /= norm(vertices.T)[:, None]
    first = len(weights) * np.arange(len(triangles))
    faces = number.reshape(-1)[first[:, None, None] + small].reshape(-1, 3)
    a, b, c = (vertices[faces[:, k]].T for k in range(3))
    N = cross(b - a, c - a)
    side = dot(a, N)
    faces[side < 0] = faces[side < 0][:, ::-1]
    return Icosphere(vertices, faces.astype(np.int32), float(np.min(np.abs(side) / norm(N))))


def _icosahedron() -> tuple[Floats, Ints]:
    """Twelve vertices of one length, and twenty faces of neighbours in ascending order."""
    golden = (1 + math.sqrt(5)) / 2
    flat = np.array([(0, y, z) for y in (-1, 1) for z in (-golden, golden)])
    vertices = np.concatenate([np.roll(flat, k, axis=1) for k in range(3)])
    near = norm((vertices[:, None] - vertices).T) < 2.1  # edges are 2 long, diagonals 3.2
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    return vertices, np.array(faces, dtype=np.int32)


def _cut_triangle(cuts: int) -> tuple[Floats, Ints]:
    """Barycentric weights (p, 3) of a cut triangle's points, and its small triangles (m, 3)."""
    points = [(i, j, cuts - i - j) for i in range(cuts + 1) for j in range(cuts + 1 - i)]
    number = {point: k for k, point in enumerate(points)}
    small = []
    for i, j, k in points:
        if k > 0:
            small.append([number[i, j, k], number[i + 1, j, k - 1], number[i, j + 1, k - 1]])
        if k > 1:
            ends = (i + 1, j, k - 1), (i + 1, j + 1, k - 2), (i, j + 1, k - 1)
            small.append([number[end] for end in ends])
    return np.array(points, dtype=np.float64) / cuts, np.array(small, dtype=np.int32)
