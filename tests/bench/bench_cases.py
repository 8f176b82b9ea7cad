"""What is timed: scenes of one kind of object, in growing numbers, seen in 640 × 480 pixels."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
import trimesh
from skimage.measure import marching_cubes

import minirt
from minirt.scene import Scene, Sphere
from minirt.vectors import Floats

SIZE = (640, 480)
#: Spheres by case.
SPHERES = {"1 sphere": 1, "10 spheres": 10, "100 spheres": 100, "1k spheres": 1_000,
           "10k spheres": 10_000}  # fmt: skip
#: Subdivisions of an icosahedron by case: 20 · 4ᵏ triangles.
BALLS = {"mesh, 5k": 4, "mesh, 82k": 6, "mesh, 328k": 7, "mesh, 1.3M": 8}
CASES = (*SPHERES, *BALLS, "gyroid, 201k")
#: The mesh that rays without any order are shot at.
INCOHERENT = "mesh, 82k"
#: Whole images by case: how many spheres stand on a floor, every other one a mirror.
IMAGES = {"image, 3 objects": 2, "image, 25 spheres": 25}
#: The image of a mesh of glass, whose rays leave in all directions.
GLASS = "glass mesh, 82k"

_SCREEN = {
    "look_at": {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y": 40},
    "nx": SIZE[0],
    "ny": SIZE[1],
}


@cache
def scene_of(case: str) -> Scene:
    """The scene of a case; the same one each time."""
    if case in SPHERES:
        return _spheres(SPHERES[case])
    if case in IMAGES:
        return image_scene(IMAGES[case])
    if case == GLASS:
        objects, folder = _mesh(_ball(6))
        glass = {"transmittance": 0.9, "ior": 1.5}
        return _loaded(objects, folder, glass, {"nx": SIZE[0] // 2, "ny": SIZE[1] // 2})
    return _loaded(*_mesh(_ball(BALLS[case]) if case in BALLS else _gyroid()))


def count(case: str) -> int:
    """How many primitives a case has."""
    return sum(
        1 if isinstance(thing, Sphere) else len(thing.faces) for thing in scene_of(case).objects
    )


def incoherent_rays(scene: Scene, n: int) -> tuple[Floats, Floats]:
    """Rays (3, n) from anywhere on a sphere around a scene to anywhere in its bounding box."""
    assert scene.bounds is not None
    rng = np.random.default_rng(n)
    low, high = scene.bounds
    out = rng.standard_normal((3, n))
    center, radius = (low + high) / 2, np.linalg.norm(high - low)
    P0 = center[:, None] + radius * out / np.linalg.norm(out, axis=0)
    return P0, rng.uniform(low, high, (n, 3)).T - P0


def image_scene(spheres: int, size: tuple[int, int] = SIZE, seed: int = 1) -> Scene:
    """Spheres on a floor in rows, every other one a mirror, to be drawn to depth 5."""
    rng = np.random.default_rng(seed)
    side = int(np.ceil(np.sqrt(spheres)))
    places = [(k % side - (side - 1) / 2, k // side - (side - 1) / 2) for k in range(spheres)]
    balls = [
        {"type": "sphere", "material": ("matt", "mirror")[k % 2], "radius": 0.42,
         "center": [x + rng.uniform(-0.05, 0.05), 0.42, z + rng.uniform(-0.05, 0.05)]}
        for k, (x, z) in enumerate(places)
    ]  # fmt: skip
    floor = [[-4, 0, 4], [4, 0, 4], [4, 0, -4], [-4, 0, -4]]
    objects = [*balls, {"type": "polygon", "material": "matt", "vertices": floor}]
    document = {
        "minirt": 1,
        "name": "bench",
        "screen": {
            "look_at": {"eye": [0, 1.6 * side, 2 * side], "target": [0, 0, 0], "up": [0, 1, 0],
                        "fov_y": 35},
            "nx": size[0], "ny": size[1],
        },
        "light": {"direction": [-1, -2, -1]},
        "background": [0.5, 0.6, 0.7],
        "max_depth": 5,
        "materials": {
            "matt": {"ambient": [0.1, 0.1, 0.1], "diffuse": [0.7, 0.5, 0.3]},
            "mirror": {"diffuse": [0.2, 0.2, 0.2], "reflectance": 0.8},
        },
        "objects": objects,
    }  # fmt: skip
    return minirt.load_scene(document)


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


def _ball(subdivisions: int) -> trimesh.Trimesh:
    """A wavy ball."""
    ball: trimesh.Trimesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    x, y, z = ball.vertices.T
    ball.vertices *= (1 + 0.06 * np.sin(9 * x) * np.sin(9 * y) * np.sin(9 * z))[:, None]
    return ball


def _gyroid() -> trimesh.Trimesh:
    """A surface of many layers and holes: sin x cos y + sin y cos z + sin z cos x = 0."""
    grid = np.linspace(-2 * np.pi, 2 * np.pi, 103)
    x, y, z = np.meshgrid(grid, grid, grid, indexing="ij")
    field = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    vertices, faces, _, _ = marching_cubes(field, 0.0)
    return trimesh.Trimesh(vertices / 51 - 1, faces, process=False)


def _mesh(mesh: trimesh.Trimesh) -> tuple[list[dict[str, Any]], Path]:
    folder = Path(mkdtemp(prefix="minirt-bench-"))
    mesh.export(folder / "mesh.ply")
    return [{"type": "mesh", "material": "grey", "file": "mesh.ply"}], folder


def _loaded(
    objects: list[dict[str, Any]],
    folder: Path | None = None,
    material: dict[str, float] | None = None,
    size: dict[str, int] | None = None,
) -> Scene:
    document = {
        "minirt": 1,
        "name": "bench",
        "screen": {**_SCREEN, **(size or {})},
        "light": {"direction": [-1, -1, -1]},
        "materials": {"grey": material or {}},
        "objects": objects,
    }
    return minirt.load_scene(document, folder=folder)
