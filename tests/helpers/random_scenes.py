"""Random scenes of all kinds of objects, materials and screens; the seed is the scene."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

import minirt
from minirt.scene import Scene

#: Meshes that ship with the atlas: an octahedron, a gem, and one with degenerate faces.
MESHES = ("octahedron.obj", "gem.obj", "folded.obj")


def random_scene(seed: int, nx: int = 64, ny: int = 48) -> Scene:
    """A scene of 5–60 objects in a box of side 4 around the origin, seen from outside it."""
    rng = np.random.default_rng(seed)
    document: dict[str, Any] = {
        "minirt": 1,
        "name": f"random-{seed}",
        "screen": _screen(rng, nx, ny),
        "light": {"direction": _vector(rng.normal(size=3)), "color": [1.0, 0.9, 0.8]},
        "background": _vector(rng.uniform(0, 0.5, 3)) if rng.random() < 0.5 else [0, 0, 0],
        "shadow_color": None if rng.random() < 0.7 else _vector(rng.uniform(0, 0.3, 3)),
        "max_depth": int(rng.integers(0, 4)),
        "materials": {f"m{k}": _material(rng) for k in range(6)},
        "objects": [_object(rng) for _ in range(int(rng.integers(5, 61)))],
    }
    with resources.as_file(resources.files("minirt").joinpath("atlas")) as folder:
        return minirt.load_scene(document, folder=Path(folder))


def _screen(rng: np.random.Generator, nx: int, ny: int) -> dict[str, Any]:
    """Either handedness, either sign of ν, on and off the axis, square pixels."""
    eye = _unit(rng.normal(size=3)) * rng.uniform(4, 9)
    n = _unit(eye - rng.uniform(-0.5, 0.5, 3))
    u = _unit(np.cross(rng.normal(size=3), n))
    v = np.cross(n, u) * rng.choice([-1.0, 1.0])
    nu = -rng.uniform(0.5, 2.0)
    if rng.random() < 0.5:
        n, nu = -n, -nu
    width = abs(nu) * rng.uniform(0.4, 1.2)
    side = width / nx
    left, bottom = (-0.5 + rng.uniform(-0.15, 0.15, 2)) * side * np.array([nx, ny])
    return {
        "P0": _vector(eye), "u": _vector(u), "v": _vector(v), "n": _vector(n), "nu": float(nu),
        "l": float(left), "r": float(left + side * nx),
        "b": float(bottom), "t": float(bottom + side * ny), "nx": nx, "ny": ny,
    }  # fmt: skip


def _material(rng: np.random.Generator) -> dict[str, Any]:
    material: dict[str, Any] = {
        "ambient": _vector(rng.uniform(0, 0.1, 3)),
        "diffuse": _vector(rng.uniform(0, 0.9, 3)),
        "specular": _vector(rng.uniform(0, 0.5, 3)),
        "shininess": int(rng.integers(1, 60)),
    }
    kind = rng.integers(4)
    if kind == 1:
        material["reflectance"] = float(rng.uniform(0.1, 1.0))
    elif kind >= 2:
        material["ior"] = float(rng.uniform(0.6, 2.2))
    if kind == 3:
        material["transmittance"] = float(rng.uniform(0.1, 0.6))
        material["reflectance"] = float(rng.uniform(0.0, 0.4))
    return material


def _object(rng: np.random.Generator) -> dict[str, Any]:
    center = rng.uniform(-2, 2, 3)
    size = float(np.exp(rng.uniform(np.log(0.05), np.log(1.0))))
    thing: dict[str, Any] = {"material": f"m{rng.integers(6)}"}
    kind = rng.choice(["sphere", "triangle", "polygon", "mesh"], p=[0.45, 0.25, 0.2, 0.1])
    thing["type"] = str(kind)
    if kind == "sphere":
        return thing | {"center": _vector(center), "radius": size}
    if kind == "triangle":
        corners = center + rng.normal(scale=size, size=(3, 3))
        return thing | {"vertices": [_vector(corner) for corner in corners]}
    u, v, w = _frame(rng)
    if kind == "polygon":
        angles = np.sort(rng.uniform(0, 2 * np.pi, int(rng.integers(3, 12))))
        ring = [center + size * (np.cos(a) * u + np.sin(a) * v) for a in angles]
        return thing | {"vertices": [_vector(point) for point in ring]}
    matrix = np.column_stack((size * u, size * v, size * w, center))
    rows = [[float(x) for x in row] for row in matrix] + [[0.0, 0.0, 0.0, 1.0]]
    return thing | {"file": str(rng.choice(MESHES)), "transform": rows}


def _frame(rng: np.random.Generator) -> tuple[Any, Any, Any]:
    u = _unit(rng.normal(size=3))
    v = _unit(np.cross(u, rng.normal(size=3)))
    return u, v, np.cross(u, v)


def _unit(vector: Any) -> Any:
    once = vector / np.sqrt((vector * vector).sum())
    return once / np.sqrt((once * once).sum())


def _vector(values: Any) -> list[float]:
    return [float(x) for x in values]
