"""What the intersection with each candidate object gives: the kernels' own numbers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from minirt.explain.steps import Step, Value, number
from minirt.hits import RayHits
from minirt.scene import Facets, Scene, Sphere
from minirt.shapes.sphere import sphere_quadratic
from minirt.shapes.triangle import TriangleCase
from minirt.vectors import Bools, Floats, column
from minirt.whitted import Whitted

#: Most objects that are explained one by one; few rays meet more bounding boxes.
MAX_LISTED = 12
#: Takes the place of a direction's component that is zero: any length over it is finite.
_TINY = 1e-250


def candidate_steps(whitted: Whitted, P0: Floats, d: Floats, hits: RayHits) -> Iterator[Step]:
    """A step for each object whose box the ray meets, nearest hit first, at most `MAX_LISTED`.

    Parameters
    ----------
    whitted : Whitted
    P0, d : (3, 1) float64
        The only ray.
    hits : RayHits
        What the tracer finds for it: that object is among the candidates whatever its box says.

    Source: S4, S8, S9, S11.
    """
    count = len(whitted.scene.objects)
    boxed = _boxes_met(whitted.scene, P0, d) | (np.arange(count) == hits.object[0])
    found = [_intersection(whitted, index, P0, d) for index in map(int, np.flatnonzero(boxed))]
    more = max(0, len(found) - MAX_LISTED)
    yield Step(
        "S4",
        "the objects asked",
        f"The ray meets the boxes of {len(found)} of {count} objects."
        + (f" The nearest {MAX_LISTED} follow." if more else ""),
        {"asked": len(found), "culled": count - len(found), "not shown": more},
    )
    for _, step in sorted(found, key=lambda pair: pair[0])[:MAX_LISTED]:
        yield step


def _boxes_met(scene: Scene, P0: Floats, d: Floats) -> Bools:
    """Whether the ray meets each object's bounding box, up to rounding; (number of objects,)."""
    boxes = [thing.bounds for thing in scene.objects]
    corners = np.array(boxes, dtype=np.float64).reshape(-1, 2, 3).transpose(1, 2, 0)
    nonzero = np.where(np.abs(d) < _TINY, np.copysign(_TINY, d), d)
    t = np.sort((corners - P0) / nonzero, axis=0)
    entry, leave = t[0].max(axis=0), t[1].min(axis=0)
    met: Bools = (entry <= leave) & (leave >= 0)
    return met


def _intersection(whitted: Whitted, index: int, P0: Floats, d: Floats) -> tuple[float, Step]:
    """t of the object's first hit, +inf for none, and the step."""
    thing = whitted.scene.objects[index]
    if isinstance(thing, Sphere):
        return _sphere(whitted, index, thing, P0, d)
    if thing.type == "polygon":
        return _polygon(whitted, index, thing, P0, d)
    return _faces(whitted, index, thing, P0, d)


def _title(index: int, thing: Sphere | Facets) -> str:
    return f"object {index} '{thing.name}' ({thing.type})"


def _sphere(
    whitted: Whitted, index: int, thing: Sphere, P0: Floats, d: Floats
) -> tuple[float, Step]:
    C, R, rules = column(thing.center), np.array([thing.radius]), whitted.rules
    quadratic = sphere_quadratic(P0, d, C, R)
    near, far = rules.sphere(P0, d, C, R)
    counts = [rules.in_interval(root, 0.0, np.inf) for root in (near, far)]
    t = number(rules.smallest_root(near, far, *counts))
    if not np.isfinite(near[0]):
        sentence = f"Δ/4 = {number(quadratic.quarter_delta):.6g} < 0: the line misses it."
    elif not np.isfinite(t):
        sentence = f"Both roots, {number(near):.6g} and {number(far):.6g}, lie behind the origin."
    else:
        sentence = f"Δ ≥ 0; the smallest positive root is t = {t:.6g}."
    names = ("d·d", "d·(C − P0)", "(P0 − C)² − R²", "Δ/4")
    values = dict(zip(names, map(number, quadratic), strict=True))
    values |= {"near": number(near), "far": number(far), "t": t}
    return t, Step("S8", _title(index, thing), sentence, {"object": index, **values})


def _polygon(
    whitted: Whitted, index: int, thing: Facets, P0: Floats, d: Floats
) -> tuple[float, Step]:
    rules = whitted.rules
    plane_t = number(rules.plane(P0, d, thing.corners[0][:, :1], thing.plane))
    met = rules.polygon(
        P0, d, thing.corners, thing.edge_normals, thing.plane, rules.plane, rules.triangle
    )
    held = int(met.triangle[0])
    t = number(met.t) if held >= 0 and rules.in_interval(met.t, 0.0, np.inf)[0] else np.inf
    if held < 0:
        sentence = f"Its plane is met at t = {plane_t:.6g}, outside the polygon."
        if np.isinf(plane_t):
            sentence = "The ray is parallel to its plane."
    elif np.isinf(t):
        sentence = f"It is met at t = {number(met.t):.6g}, behind the origin."
    else:
        sentence = f"Its plane is met at t = {t:.6g}, in triangle {held} of the fan."
    values = {"t of the plane": plane_t, "triangle": held, "beta": number(met.beta)}
    values |= {"gamma": number(met.gamma), "t": t}
    return t, Step("S11", _title(index, thing), sentence, {"object": index, **values})


def _faces(
    whitted: Whitted, index: int, thing: Facets, P0: Floats, d: Floats
) -> tuple[float, Step]:
    """A triangle, or the face of a mesh that is hit first; where none is, face 0."""
    rules = whitted.rules
    every = np.broadcast_to(P0, (3, len(thing.faces))), np.broadcast_to(d, (3, len(thing.faces)))
    met = rules.triangle(*every, *thing.corners, thing.edge_normals)
    inside = met.case == TriangleCase.INSIDE
    counts = inside & rules.in_interval(met.t, 0.0, np.inf)
    face = int(np.where(counts, met.t, np.inf).argmin())
    t = float(met.t[face]) if counts[face] else np.inf
    case = TriangleCase(int(met.case[face]))
    if counts[face]:
        sentence = f"β, γ, 1−β−γ ∈ [0, 1] in face {face}, at t = {t:.6g}."
    elif inside[face]:
        sentence = f"It is met at t = {met.t[face]:.6g}, behind the origin."
    elif thing.type == "mesh":
        sentence = f"None of its {len(thing.faces)} faces is hit."
    elif case == TriangleCase.OUTSIDE:
        sentence = f"Its plane is met at t = {met.t[face]:.6g}, outside the triangle."
    else:
        sentence = "No β, γ: the ray is parallel to its plane, or it is degenerate."
    values: dict[str, Value] = {
        "triangle": face if counts[face] else -1,
        "case": case.name,
        "beta": float(met.beta[face]),
        "gamma": float(met.gamma[face]),
        "t": t,
        "faces hit": int(inside.sum()),
    }
    return t, Step("S9", _title(index, thing), sentence, {"object": index, **values})
