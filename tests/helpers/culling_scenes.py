"""Scenes and rays that culling could get wrong."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import minirt
from minirt.geometry import Geometry
from minirt.hits import RayHits
from minirt.rays import Rays
from minirt.rules import SLIDES, Rules, in_interval
from minirt.trace import RT, World
from minirt.trace import occluded as any_hit
from minirt.vectors import Bools, Floats

#: An equal rule that is not the same object: boxes are only trusted with the lecture's own rules.
BRUTE = SLIDES.replace(in_interval=lambda *interval: in_interval(*interval))

Objects = list[dict[str, Any]]


def nearest(
    geometry: Geometry, rules: Rules, P0: Floats, d: Floats,
    t0: Floats | float = 0.0, t1: Floats | float = np.inf,
) -> RayHits:  # fmt: skip
    return RT(World.of(geometry, rules), Rays.of(P0, d, t0, t1))


def occluded(
    geometry: Geometry, rules: Rules, P0: Floats, d: Floats,
    t0: Floats | float = 0.0, t1: Floats | float = np.inf,
) -> Bools:  # fmt: skip
    return any_hit(World.of(geometry, rules), Rays.of(P0, d, t0, t1))


def sphere(center: Any, radius: float, material: str = "all") -> dict[str, Any]:
    center = [float(x) for x in center]
    return {"type": "sphere", "material": material, "center": center, "radius": float(radius)}


def triangle(vertices: Any, material: str = "all") -> dict[str, Any]:
    vertices = np.asarray(vertices, dtype=float).tolist()
    return {"type": "triangle", "material": material, "vertices": vertices}


def _polygon(vertices: Any, material: str = "all") -> dict[str, Any]:
    return {**triangle(vertices, material), "type": "polygon"}


def _rectangle(low: Any, side: Any, up: Any) -> dict[str, Any]:
    low, side, up = (np.asarray(v, dtype=float) for v in (low, side, up))
    return _polygon([low, low + side, low + side + up, low + up])


def scene_with(objects: Objects, eye: Any = (0.3, 0.4, 6.0), **more: Any) -> minirt.Scene:
    screen = {"P0": list(eye), "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
              "l": -0.5, "r": 0.5, "b": -0.5, "t": 0.5, "nx": 24, "ny": 24}  # fmt: skip
    materials = {
        "all": {"specular": [0.3, 0.3, 0.3], "shininess": 7, "reflectance": 0.3,
                "transmittance": 0.3, "ior": 1.5},
        "plain": {},
    }  # fmt: skip
    document = {"minirt": 1, "name": "culling", "screen": {**screen, **more},
                "light": {"direction": [-1.0, -2.0, -1.0]}, "max_depth": 3,
                "materials": materials, "objects": objects}  # fmt: skip
    return minirt.load_scene(document)


def _mixed(rng: np.random.Generator) -> Objects:
    spheres = [sphere(rng.uniform(-2, 2, 3), rng.uniform(0.05, 0.5)) for _ in range(40)]
    corners = rng.uniform(-2, 2, (60, 1, 3)) + rng.normal(size=(60, 3, 3)) * 0.4
    return [*spheres, *map(triangle, corners), _rectangle((-3, -2, -3), (6, 0, 0), (0, 0, 6))]


def _coplanar(rng: np.random.Generator) -> Objects:
    low = rng.integers(-4, 4, (30, 2)) / 2
    flat = [triangle([(x, y, 0), (x + 1, y, 0), (x, y + 1, 0)]) for x, y in low]
    return [*flat, *(_rectangle((x, y, 0), (0.5, 0, 0), (0, 0.5, 0)) for x, y in low[:10])]


def _touching(rng: np.random.Generator) -> Objects:
    grid = np.stack(np.meshgrid(*[np.arange(-1.0, 2.0)] * 3), axis=-1).reshape(-1, 3)
    return [*(sphere(c, 0.5) for c in grid), _rectangle((-2, -1.5, -2), (4, 0, 0), (0, 0, 4))]


def _shared_edges(rng: np.random.Generator) -> Objects:
    z = rng.integers(0, 3, (9, 9)) / 4
    cells = [(i, j) for i in range(8) for j in range(8)]

    def point(i: int, j: int) -> tuple[float, float, float]:
        return (i - 4) / 2, (j - 4) / 2, z[i, j]

    lower = [triangle([point(i, j), point(i + 1, j), point(i, j + 1)]) for i, j in cells]
    upper = [triangle([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]) for i, j in cells]
    return lower + upper


def _duplicates(rng: np.random.Generator) -> Objects:
    once = _mixed(rng)[20:70]
    return [once[k] for k in rng.permutation(np.repeat(np.arange(len(once)), 3))]


def _scales(rng: np.random.Generator) -> Objects:
    spheres = [sphere(rng.normal(size=3), 10.0 ** rng.uniform(-9, -1)) for _ in range(40)]
    corners = rng.normal(size=(60, 1, 3)) + rng.normal(size=(60, 3, 3)) * 10.0 ** rng.uniform(
        -8, 3, (60, 1, 1)
    )
    return [*spheres, sphere((0, -1e6, 0), 1e6 - 2), *map(triangle, corners)]


def _degenerate(rng: np.random.Generator) -> Objects:
    a, b = rng.uniform(-2, 2, (2, 40, 3))
    lines = [triangle(v) for v in np.stack((a, b, a + (b - a) * rng.random((40, 1))), axis=1)]
    points = [triangle([p, p, p]) for p in a[:10]]
    return lines + points + _mixed(rng)[::3]


def _edge_on(rng: np.random.Generator) -> Objects:
    eye = np.array([0.3, 0.4, 6.0])
    near, side = rng.uniform(-2, 2, (40, 3)), rng.uniform(-2, 2, (40, 3))
    fans = [triangle([p, p + 0.5 * (p - eye), q]) for p, q in zip(near, side, strict=True)]
    through_eye = [
        triangle([p, q, eye + 0.8 * (p - eye) + 0.1 * (q - eye)])
        for p, q in zip(near, side, strict=True)
    ]
    return fans + through_eye + _mixed(rng)[::5]


def _boxes(rng: np.random.Generator) -> Objects:
    faces: Objects = []
    for c in rng.integers(-2, 3, (6, 3)).astype(float):
        for k in range(3):
            e, f = np.eye(3)[(k + 1) % 3], np.eye(3)[(k + 2) % 3]
            faces += [_rectangle(c, e, f), _rectangle(c + np.eye(3)[k], e, f)]
    return faces


FAMILIES: dict[str, Callable[[np.random.Generator], Objects]] = {
    f.__name__[1:]: f
    for f in (
        _mixed, _coplanar, _touching, _shared_edges, _duplicates, _scales, _degenerate, _edge_on,
        _boxes,
    )
}  # fmt: skip


def rays_around(rng: np.random.Generator, scene: minirt.Scene, n: int) -> tuple[Floats, Floats]:
    """Rays that start on boxes and corners, with and without zero components."""
    bounds = scene.bounds
    assert bounds is not None
    low, high = bounds
    P0 = rng.uniform(low - 1, high + 1, (n, 3))
    P0[::2] = np.where(rng.random((len(P0[::2]), 3)) < 0.5, low, high)
    P0[::3] = np.round(P0[::3] * 2) / 2
    d = rng.uniform(low, high, (n, 3)) - P0
    d[::2] = rng.integers(-1, 2, d[::2].shape)
    d[(d == 0).all(axis=1)] = (0, 0, -1)
    return np.ascontiguousarray(P0.T), np.ascontiguousarray(d.T)
