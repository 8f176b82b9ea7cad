"""S4's other request: ALL objects that a ray meets, in order."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from minirt.geometry import Polygon
from minirt.hits import RayHits
from minirt.rays import Rays
from minirt.rules import Rules
from minirt.shapes.triangle import TriangleCase
from minirt.trace import World
from minirt.vectors import Bools, Floats, Ints

_PAIRS = 262_144


def every_hit(world: World, rays: Rays) -> RayHits:
    """All hits of n rays with t in [t0, t1]: both roots of spheres, every face.

    Returns
    -------
    RayHits
        Arrays (k, n), sorted by t, then object, then face; ∅ after a ray's last hit. k is the
        largest number of hits of any ray.
    """
    geometry = world.geometry
    primitives = (
        2 * len(geometry.spheres.radius) + len(geometry.triangles.object) + len(geometry.polygons)
    )
    step = max(1, _PAIRS // max(1, primitives))
    parts = [
        _sorted(_every_answer(world, rays, slice(i, i + step)))
        for i in range(0, max(1, rays.count), step)
    ]
    k = max(part.t.shape[0] for part in parts)
    padded = [_padded(part, k) for part in parts]
    return RayHits(*(np.concatenate(v, axis=1) for v in zip(*map(_values, padded), strict=True)))


def _every_answer(world: World, rays: Rays, some: slice) -> RayHits:
    """Every primitive's answer for some rays, (primitives, n)."""
    geometry, rules = world.geometry, world.rules
    P0, d = rays.origins[:, some], rays.directions[:, some]
    n = P0.shape[1]
    rows = [RayHits.none((0, n))]
    P0_, d_ = P0[:, None, :], d[:, None, :]
    spheres, tri = geometry.spheres, geometry.triangles
    if len(spheres.radius):
        near, far = rules.sphere(P0_, d_, spheres.center[:, :, None], spheres.radius[:, None])
        for root in (near, np.where(far > near, far, np.inf)):
            rows.append(_row(root, spheres.object, np.zeros_like(spheres.object), n))
    if len(tri.object):
        met = rules.triangle(P0_, d_, *(v[:, :, None] for v in (tri.a, tri.b, tri.c, tri.N)))
        t = np.where(met.case == TriangleCase.INSIDE, met.t, np.inf)
        rows.append(_row(t, tri.object, tri.face, n, met.beta, met.gamma))
    for polygon in geometry.polygons:
        rows.append(_polygon_row(polygon, rules, P0, d))
    every = RayHits(*(np.concatenate(v) for v in zip(*map(_values, rows), strict=True)))
    t0, t1 = (t if len(t) == 1 else t[some] for t in (rays.t0, rays.t1))
    return _only(every, rules.in_interval(every.t, t0, t1))


def _polygon_row(polygon: Polygon, rules: Rules, P0: Floats, d: Floats) -> RayHits:
    f = polygon.facets
    hit = rules.polygon(P0, d, f.corners, f.edge_normals, f.plane, rules.plane, rules.triangle)
    number = np.full(hit.t.shape, polygon.object, dtype=np.int32)
    return RayHits(hit.t[None], number[None], hit.triangle[None], hit.beta[None], hit.gamma[None])


def _row(
    t: Floats, object_: Ints, face: Ints, n: int,
    beta: Floats | None = None, gamma: Floats | None = None,
) -> RayHits:  # fmt: skip
    shape = (len(object_), n)
    nan = np.full(shape, np.nan)
    return RayHits(
        t,
        np.broadcast_to(object_[:, None], shape),
        np.broadcast_to(face[:, None], shape),
        nan if beta is None else beta,
        nan if gamma is None else gamma,
    )


def _only(hits: RayHits, counts: Bools) -> RayHits:
    none = RayHits.none(counts.shape)
    return RayHits(
        *(np.where(counts, a, b) for a, b in zip(_values(hits), _values(none), strict=True))
    )


def _sorted(hits: RayHits) -> RayHits:
    k = int(np.isfinite(hits.t).sum(axis=0).max(initial=0))
    order = np.lexsort((hits.triangle, hits.object, hits.t), axis=0)[:k]
    return RayHits(*(np.take_along_axis(v, order, axis=0) for v in _values(hits)))


def _padded(hits: RayHits, k: int) -> RayHits:
    missing = RayHits.none((k - hits.t.shape[0], hits.t.shape[1]))
    return RayHits(*(np.concatenate(v) for v in zip(_values(hits), _values(missing), strict=True)))


def _values(hits: RayHits) -> list[NDArray[Any]]:
    return list(vars(hits).values())
