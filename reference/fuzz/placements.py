"""Objects at which renderers often fail: touching, tangent, coplanar, nested, nearly parallel."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from hypothesis import strategies as st

from minirt.vectors import Floats

Document: TypeAlias = dict[str, Any]
#: Draws objects, without names and materials, before a screen in the scene file's form.
Placement: TypeAlias = Callable[[st.DrawFn, Document], list[Document]]

#: Meshes of the atlas: an octahedron, a gem, and one with degenerate faces.
MESHES = ("octahedron.obj", "gem.obj", "folded.obj")
#: Coordinates in a box of side 4: any, or multiples of a quarter, so that some coincide.
COORDINATE = st.one_of(st.floats(-2, 2), st.integers(-8, 8).map(lambda k: k / 4))
KINDS = ("sphere", "triangle", "polygon", "mesh")


def point(draw: st.DrawFn) -> Floats:
    """A point (3,) of the box."""
    return np.array([draw(COORDINATE) for _ in range(3)])


def direction(draw: st.DrawFn) -> Floats:
    """A unit vector (3,); one in four along an axis."""
    if draw(st.integers(0, 3)) == 0:
        axis = np.zeros(3)
        axis[draw(st.integers(0, 2))] = draw(st.sampled_from([-1.0, 1.0]))
        return axis
    z, angle = draw(st.floats(-1, 1)), draw(st.floats(0, 2 * math.pi))
    ring = math.sqrt(1 - z * z)
    return unit(np.array([ring * math.cos(angle), ring * math.sin(angle), z]))


def size(draw: st.DrawFn, low: float = -2.0, high: float = 0.2) -> float:
    """A length, log-uniform from 10^low to 10^high."""
    return math.pow(10, draw(st.floats(low, high)))


def frame(draw: st.DrawFn) -> tuple[Floats, Floats, Floats]:
    """Three unit vectors, right-handed, each (3,)."""
    u = direction(draw)
    w = unit(np.cross(u, _least_axis(u)))
    angle = draw(st.floats(0, 2 * math.pi))
    v = unit(math.cos(angle) * w + math.sin(angle) * np.cross(u, w))
    return u, v, np.cross(u, v)


def unit(vector: Floats) -> Floats:
    """Normalise a vector (3,), twice, so that its length is 1 to the last bits."""
    once = vector / math.sqrt(float(vector @ vector))
    result: Floats = once / math.sqrt(float(once @ once))
    return result


def pixel_ray(screen: Document, i: int, j: int) -> Floats:
    """The direction (3,) of pixel (i, j)'s ray, j from the bottom. Source: S2, S3, S5."""
    u, v, n = (np.array(screen[name]) for name in "uvn")
    across = screen["l"] + (screen["r"] - screen["l"]) / screen["nx"] * (i + 0.5)
    up = screen["b"] + (screen["t"] - screen["b"]) / screen["ny"] * (j + 0.5)
    ray: Floats = u * across + v * up + n * screen["nu"]
    return ray


def free(draw: st.DrawFn, _: Document) -> list[Document]:
    """One object of any kind, anywhere."""
    center, reach = point(draw), size(draw)
    kind = draw(st.sampled_from(KINDS))
    if kind == "sphere":
        return [sphere(center, reach)]
    u, v, w = frame(draw)
    if kind == "triangle":
        corners = [center + reach * np.array([draw(COORDINATE) for _ in range(3)]) for _ in "abc"]
        return [triangle(*corners)]
    if kind == "polygon":
        return [_polygon(draw, center, reach * u, reach * v)]
    stretch = np.diag([1.0, draw(st.floats(0.3, 3)), 1.0])
    matrix = reach * np.column_stack((u, v, w)) @ stretch
    rows = [[*map(float, row), float(c)] for row, c in zip(matrix, center, strict=True)]
    file = draw(st.sampled_from(MESHES))
    return [{"type": "mesh", "file": file, "transform": [*rows, [0.0, 0.0, 0.0, 1.0]]}]


def tangent(draw: st.DrawFn, screen: Document) -> list[Document]:
    """A sphere that a pixel's ray just touches, or just misses."""
    ray = pixel_ray(
        screen, draw(st.integers(0, screen["nx"] - 1)), draw(st.integers(0, screen["ny"] - 1))
    )
    delta, radius = unit(ray), size(draw)
    side = unit(np.cross(delta, _least_axis(delta)))
    slip = draw(st.sampled_from([0.0, 1e-12, -1e-12, 1e-8, -1e-8, 1e-5, -1e-5]))
    away = draw(st.floats(2, 10))
    center = np.array(screen["P0"]) + away * delta + radius * (1 + slip) * side
    return [sphere(center, radius)]


def edge(draw: st.DrawFn, _: Document) -> list[Document]:
    """Two triangles that share an edge: flat, at an angle, or folded onto each other."""
    a, b, c, e = (point(draw) for _ in range(4))
    if draw(st.booleans()):
        e = a + b - c
    return [triangle(a, b, c), triangle(b, a, e)]


def contact(draw: st.DrawFn, _: Document) -> list[Document]:
    """A sphere that touches a polygon or another sphere in one point."""
    center, radius = point(draw), size(draw, -1.5)
    u, v, w = frame(draw)
    if draw(st.booleans()):
        other = size(draw, -1.5)
        return [sphere(center, other), sphere(center + (other + radius) * w, radius)]
    reach = radius * draw(st.floats(1, 4))
    return [_polygon(draw, center, reach * u, reach * v), sphere(center + radius * w, radius)]


def coplanar(draw: st.DrawFn, _: Document) -> list[Document]:
    """Two polygons that overlap in one plane, or lie very close together."""
    center, reach = point(draw), size(draw, -1.0)
    u, v, w = frame(draw)
    gap = draw(st.sampled_from([0.0, 0.0, 1e-9, 1e-6, 1e-4])) * reach
    shift = draw(st.floats(-0.5, 0.5)) * reach * u + gap * w
    share = draw(st.floats(0.3, 1.2))
    first = _polygon(draw, center, reach * u, reach * v)
    return [first, _polygon(draw, center + shift, share * reach * u, share * reach * v)]


def nested(draw: st.DrawFn, _: Document) -> list[Document]:
    """Concentric spheres, the smallest gap being a thin shell."""
    center, radius = point(draw), size(draw, -1.0)
    thickness = 10.0 ** draw(st.floats(-5, -0.3))
    shells = [sphere(center, radius), sphere(center, radius * (1 - thickness))]
    return [*shells, sphere(center, radius * 0.4)] if draw(st.booleans()) else shells


def parallel(draw: st.DrawFn, screen: Document) -> list[Document]:
    """A polygon that the rays meet at a grazing angle, down to 1e-8."""
    P0, center, reach = np.array(screen["P0"]), point(draw), size(draw, -1.0)
    away = center - P0
    if float(away @ away) < 1e-12:
        away = pixel_ray(screen, 0, 0)
    along = unit(away)
    side = unit(np.cross(along, _least_axis(along)))
    tilted = along + 10.0 ** draw(st.floats(-8, -1)) * np.cross(along, side)
    return [_polygon(draw, center, reach * unit(tilted), reach * side)]


#: How objects are placed, by the prefix of their names.
PLACEMENTS: dict[str, Placement] = {
    "free": free, "tangent": tangent, "edge": edge, "contact": contact,
    "coplanar": coplanar, "nested": nested, "parallel": parallel,
}  # fmt: skip


def sphere(center: Floats, radius: float) -> Document:
    """A sphere of the scene file, center (3,)."""
    return {"type": "sphere", "center": numbers(center), "radius": float(radius)}


def triangle(a: Floats, b: Floats, c: Floats) -> Document:
    """A triangle of the scene file, corners (3,)."""
    return {"type": "triangle", "vertices": [numbers(corner) for corner in (a, b, c)]}


def numbers(values: Floats) -> list[float]:
    """An array (n,) as a list for JSON."""
    return [float(x) for x in values]


def _polygon(draw: st.DrawFn, center: Floats, u: Floats, v: Floats) -> Document:
    """A convex polygon on an ellipse, its corners not quite evenly spaced."""
    count = draw(st.integers(3, 9))
    turn = draw(st.floats(0, 1))
    angles = [2 * math.pi * (k + turn + draw(st.floats(0, 0.4))) / count for k in range(count)]
    ring = [numbers(center + math.cos(a) * u + math.sin(a) * v) for a in angles]
    return {"type": "polygon", "vertices": ring}


def _least_axis(vector: Floats) -> Floats:
    axis = np.zeros(3)
    axis[int(np.abs(vector).argmin())] = 1.0
    return axis
