"""What is timed: scenes of one kind of object, in growing numbers, seen in 640 × 480 pixels."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
import trimesh

import minirt
from minirt.scene import Scene

SIZE = (640, 480)
#: Spheres by case.
SPHERES = {"1 sphere": 1, "10 spheres": 10, "100 spheres": 100, "1k spheres": 1_000,
           "10k spheres": 10_000}  # fmt: skip
#: Subdivisions of an icosahedron by case: 20 · 4ᵏ triangles.
MESHES = {"mesh, 5k": 4, "mesh, 82k": 6, "mesh, 328k": 7, "mesh, 1.3M": 8}
CASES = (*SPHERES, *MESHES)

_SCREEN = {
    "look_at": {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y": 40},
    "nx": SIZE[0],
    "ny": SIZE[1],
}


@cache
def scene_of(case: str) -> Scene:
    """The scene of a case; the same one each time."""
    return _spheres(SPHERES[case]) if case in SPHERES else _mesh(MESHES[case])


def count(case: str) -> int:
    """How many primitives a case has."""
    return SPHERES[case] if case in SPHERES else 20 * 4 ** MESHES[case]


def _spheres(n: int) -> Scene:
    """Spheres in a cube that fill about the same share of it, however many there are."""
    rng = np.random.default_rng(n)
    centers = rng.uniform(-1, 1, (n, 3)) if n > 1 else np.zeros((1, 3))
    radius = 0.9 if n == 1 else 0.55 / n ** (1 / 3)
    return _loaded(
        [
            {"type": "sphere", "material": "grey", "center": c.tolist(), "radius": radius}
            for c in centers
        ]
    )


def _mesh(subdivisions: int) -> Scene:
    """A wavy ball."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    x, y, z = ball.vertices.T
    ball.vertices *= (1 + 0.06 * np.sin(9 * x) * np.sin(9 * y) * np.sin(9 * z))[:, None]
    folder = Path(mkdtemp(prefix="minirt-bench-"))
    ball.export(folder / "ball.ply")
    return _loaded([{"type": "mesh", "material": "grey", "file": "ball.ply"}], folder)


def _loaded(objects: list[dict[str, Any]], folder: Path | None = None) -> Scene:
    document = {
        "minirt": 1,
        "name": "bench",
        "screen": _SCREEN,
        "light": {"direction": [-1, -1, -1]},
        "materials": {"grey": {}},
        "objects": objects,
    }
    return minirt.load_scene(document, folder=folder)
