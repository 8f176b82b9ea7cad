"""Wrong versions of S9–S11: triangles, planes, polygons and their normals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from minirt.render import render
from minirt.rules import SLIDES
from minirt.scene import Facets, Scene
from minirt.shapes.plane import edge_normal
from minirt.shapes.polygon import PolygonHits, polygon_hit
from minirt.shapes.triangle import TriangleCase, TriangleHits, triangle_hit
from minirt.vectors import Bools, Floats, dot
from reference.mutants.mutant import Mutant

Corners = tuple[Floats, Floats, Floats]

#: Columns and rows at which the flipped triangle is looked for.
_GLANCE = (32, 24)
#: A bias that lets rays through the seams between triangles.
_BIAS = 0.01


def _judged_anew(met: TriangleHits, inside: Bools) -> TriangleHits:
    case = np.where(
        inside & (met.case != TriangleCase.NONE), TriangleCase.INSIDE, TriangleCase.OUTSIDE
    )
    return met._replace(
        case=np.where(met.case == TriangleCase.NONE, met.case, case).astype(np.int32)
    )


def _sum_forgotten(P0: Floats, d: Floats, *triangle: Floats) -> TriangleHits:
    met = triangle_hit(P0, d, *triangle)
    inside = (met.beta >= 0) & (met.beta <= 1) & (met.gamma >= 0) & (met.gamma <= 1)
    return _judged_anew(met, inside)


def _biased(P0: Floats, d: Floats, *triangle: Floats) -> TriangleHits:
    met = triangle_hit(P0, d, *triangle)
    least = np.minimum(np.minimum(met.beta, met.gamma), 1 - met.beta - met.gamma)
    return _judged_anew(met, least >= _BIAS)


def _culled(P0: Floats, d: Floats, *triangle: Floats) -> TriangleHits:
    met = triangle_hit(P0, d, *triangle)
    return _judged_anew(met, (met.case == TriangleCase.INSIDE) & (dot(d, triangle[3]) < 0))


def _weights_exchanged(P0: Floats, d: Floats, *triangle: Floats) -> TriangleHits:
    met = triangle_hit(P0, d, *triangle)
    return met._replace(beta=met.gamma, gamma=met.beta)


def _other_winding(p: Floats) -> Floats:
    return -SLIDES.face_normal(p)


def _not_unit(p: Floats) -> Floats:
    return p


def _through_origin(P0: Floats, d: Floats, P1: Floats, p: Floats) -> Floats:
    t = SLIDES.plane(P0, d, P1, p)
    slope = np.where(np.isinf(t), 1.0, dot(d, p))
    result: Floats = np.where(np.isinf(t), np.inf, dot(P1, p) / slope)
    return result


def _absolute_t(P0: Floats, d: Floats, P1: Floats, p: Floats) -> Floats:
    return np.abs(SLIDES.plane(P0, d, P1, p))


def _last_missing(
    P0: Floats, d: Floats, corners: Corners, fan_normals: Floats, *rest: Any
) -> PolygonHits:
    a, b, c = (corner[:, :-1] for corner in corners)
    if not a.shape[1]:
        return polygon_hit(P0, d, corners, fan_normals, *rest)
    return polygon_hit(P0, d, (a, b, c), fan_normals[:, :-1], *rest)


def _strip(P0: Floats, d: Floats, corners: Corners, fan_normals: Floats, *rest: Any) -> PolygonHits:
    first, b, c = corners
    a = np.concatenate([first[:, :1], b[:, :-1]], axis=1)
    return polygon_hit(P0, d, (a, b, c), edge_normal(a, b, c), *rest)


def _fan_from_last(
    P0: Floats, d: Floats, corners: Corners, fan_normals: Floats, *rest: Any
) -> PolygonHits:
    met = polygon_hit(P0, d, corners, fan_normals, *rest)
    last = corners[0].shape[1] - 1
    return met._replace(
        triangle=np.where(met.triangle < 0, met.triangle, last - met.triangle).astype(np.int32)
    )


def _one_flipped(scene: Scene) -> Scene:
    """The scene, with the normal of one triangle that is seen of its first mesh turned round."""
    number = next((k for k, thing in enumerate(scene.objects) if thing.type == "mesh"), None)
    if number is None:
        return scene
    mesh = scene.objects[number]
    nx, ny = _GLANCE
    glance = replace(scene, screen=replace(scene.screen, nx=nx, ny=ny))
    seen = render(glance, quantities="object,triangle")
    faces = np.unique(seen["triangle"][seen["object"] == number])
    if not isinstance(mesh, Facets) or not len(faces):
        return scene
    flipped = replace(mesh)
    normals = mesh.edge_normals.copy()
    normals[:, faces[len(faces) // 2]] *= -1
    vars(flipped)["edge_normals"] = normals
    return replace(scene, objects=(*scene.objects[:number], flipped, *scene.objects[number + 1 :]))


MUTANTS = (
    Mutant("weight-sum-forgotten", "S9", "without the test β + γ ≤ 1",
           "Each of β and γ was tested: that is a parallelogram.",
           "hit", SLIDES.replace(triangle=_sum_forgotten)),
    Mutant("weights-biased", "S9", "with β, γ and 1−β−γ from 0.01 on",
           "A tolerance with the wrong sign: gaps open along the edges.",
           "hit", SLIDES.replace(triangle=_biased)),
    Mutant("back-faces-culled", "S9", "with triangles seen from behind culled",
           "Rasterisers do so by default, and closed meshes look right.",
           "hit", SLIDES.replace(triangle=_culled)),
    Mutant("weights-exchanged", "S9", "with β and γ exchanged",
           "The edges were taken in the order c − a, b − a.",
           "t", SLIDES.replace(triangle=_weights_exchanged)),
    Mutant("face-normal-other-winding", "S9", "with the normal of the left-hand rule",
           "(c − a) × (b − a) in the place of (b − a) × (c − a).",
           "normal", SLIDES.replace(face_normal=_other_winding)),
    Mutant("face-normal-not-unit", "S9", "with the normal not made a unit vector",
           "The cross product's length is twice the triangle's area.",
           "normal", SLIDES.replace(face_normal=_not_unit)),
    Mutant("one-triangle-flipped", "S9", "with the normal of one triangle of a mesh flipped",
           "One face of the file is wound the other way: one of 5,000.",
           "normal", scene=_one_flipped),
    Mutant("plane-through-origin", "S10", "with t = P1·p / (d·p)",
           "P0 was left out: right for the observer in the origin.",
           "hit", SLIDES.replace(plane=_through_origin)),
    Mutant("plane-t-absolute", "S10", "with |t| in the place of t",
           "Signs of p and d were 'repaired', and what lies behind comes to the front.",
           "hit", SLIDES.replace(plane=_absolute_t)),
    Mutant("last-fan-triangle-missing", "S11", "without the last triangle of the fan",
           "A loop over m − 3 triangles in the place of m − 2.",
           "hit", SLIDES.replace(polygon=_last_missing)),
    Mutant("strip-for-fan", "S11", "with a strip of triangles in the place of the fan",
           "(Pk, Pk+1, Pk+2) looks like (P1, Pk+1, Pk+2), and leaves the middle open.",
           "hit", SLIDES.replace(polygon=_strip)),
    Mutant("fan-from-last", "S11", "with the fan's triangles counted from the last",
           "The loop runs down from Pm; the same points, other numbers.",
           "object", SLIDES.replace(polygon=_fan_from_last)),
)  # fmt: skip
