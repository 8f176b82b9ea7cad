"""One pixel whose ray, mirrored, shadowed or refracted, passes an edge or the critical angle."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from minirt.rays import Rays
from minirt.scene import Scene
from minirt.vectors import Floats, column, unit
from minirt.whitted import Whitted
from reference.compare.displaced import carried, sideways
from reference.compare.stability import measure
from reference.source import Declared
from tests.helpers.tiers import tiered
from tests.reference.compare.test_stability import scene_of

DELTA = 1e-6
EXACT = Declared(DELTA, 0, 0, 0, None, "")
#: One pixel, seen from z = 5 towards the origin.
PIXEL = {"P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
         "l": -0.1, "r": 0.1, "b": -0.1, "t": 0.1, "nx": 1, "ny": 1}  # fmt: skip
Vector = NDArray[np.float64]


def quad(corners: list[Vector], material: str = "paint") -> dict[str, Any]:
    vertices = [corner.tolist() for corner in corners]
    return {"type": "polygon", "material": material, "vertices": vertices}


def beside(edge: Vector, out: Vector, along: Vector) -> dict[str, Any]:
    """A quad whose edge lies at a point, on the side that `out` points away from."""
    return quad([edge - 0.6 * along, edge + 0.6 * along,
                 edge + 0.6 * along - 1.2 * out, edge - 0.6 * along - 1.2 * out])  # fmt: skip


def around(axis: Vector, angle: float) -> tuple[Vector, Vector]:
    """A unit vector perpendicular to an axis, at an angle, and the one after it."""
    first = np.cross(axis, [0.3, 0.5, -0.7])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    out = np.cos(angle) * first + np.sin(angle) * second
    return out, np.cross(axis, out)


def certain(scene: Scene, name: str, error: Declared = EXACT) -> bool:
    _, stability = measure(scene, error, [name, "object"])
    return bool(stability.certain[name][0, 0])


@pytest.mark.parametrize("angle", np.linspace(0.1, 6.0, 24))
def test_what_is_contested_is_not_nothing(angle: float) -> None:
    """Two quads in one place, and the ray just beside their common edge: it meets nothing."""
    out, along = around(np.array([0.0, 0.0, 1.0]), angle)
    for share, sure in ((-0.5, False), (-10.0, True)):
        twice = [beside(share * DELTA * out, out, along)] * 2
        assert certain(scene_of(twice, screen=PIXEL), "object") is sure


def leaving(way: str, rng: np.random.Generator) -> tuple[Vector, Vector]:
    """A normal, and how the ray along −z leaves there: neither grazing nor in its own way."""
    arrives = np.array([0.0, 0.0, -1.0])
    while True:
        n = rng.normal(size=3) + np.array([0.0, 0.0, 2.0])
        n /= np.linalg.norm(n)
        if way == "shadow":
            leaves = rng.normal(size=3)
            leaves *= np.sign(leaves @ n) / np.linalg.norm(leaves)
        elif way == "reflection_object":
            leaves = arrives - 2 * (arrives @ n) * n
        else:
            cosine = np.sqrt(1 - (1 - (arrives @ n) ** 2) / 2.25)
            leaves = arrives / 1.5 + (-(arrives @ n) / 1.5 - cosine) * n
        if abs(leaves @ n) > 0.3 and leaves[2] < 0.9 and n[2] > 0.3:
            return n, leaves


@pytest.mark.parametrize("seed", tiered(range(40), lambda seed: seed < 5))
@pytest.mark.parametrize("way", ["shadow", "reflection_object", "refraction_object"])
@pytest.mark.parametrize(("share", "sure"), [(0.9, False), (0.3, False), (-0.9, False), (60, True)])
def test_an_edge_beside_a_ray_that_leaves_makes_it_uncertain(
    way: str, seed: int, share: float, sure: bool
) -> None:
    """What the primary ray's movement does to the next must not take that one's own away."""
    rng = np.random.default_rng(seed)
    n, leaves = leaving(way, rng)
    u, v = around(n, 0.3)
    surface = [0.9 * (s * u + t * v) + 0.1 * u for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    out, along = around(leaves, rng.uniform(0, 2 * np.pi))
    material = {"shadow": "paint", "reflection_object": "mirror", "refraction_object": "glass"}[way]
    scene = scene_of(
        [quad(surface, material), beside(share * DELTA * out + 3 * leaves, out, along)],
        screen=PIXEL,
        light={"direction": (-leaves).tolist()},
        materials={"paint": {}, "mirror": {"reflectance": 0.8},
                   "glass": {"ior": 1.5, "transmittance": 0.7}},
    )  # fmt: skip
    assert certain(scene, way) is sure


@pytest.mark.parametrize("share", [-0.9, -0.6, 0.6, 0.9])
def test_total_reflection_within_a_normals_rounding_is_uncertain(share: float) -> None:
    angle = 1e-6
    critical = np.arcsin(1 / 1.5)
    for azimuth in np.linspace(0.01, 6.2, 24):
        for off, sure in ((share * angle, False), (20 * share * angle, True)):
            theta = critical - off
            d = np.array([np.sin(theta) * np.cos(azimuth), np.sin(theta) * np.sin(azimuth),
                          -np.cos(theta)])  # fmt: skip
            u, v = around(-d, 0.0)
            screen = {**PIXEL, "P0": (-4 * d).tolist(), "u": u.tolist(), "v": v.tolist(),
                      "n": (-d).tolist()}  # fmt: skip
            pane = {"type": "triangle", "material": "glass",
                    "vertices": [[-9, 8, 0], [8, 9, 0], [1, -12, 0]]}  # fmt: skip
            error = Declared(1e-9, 1e-9, angle, 1e-7, None, "")
            assert certain(scene_of([pane], screen=screen), "tir", error) is sure


def test_what_is_carried_on_is_as_far_aside() -> None:
    """Unit vectors perpendicular to the rays that leave, mirrored or turned as these are."""
    ball = {"type": "sphere", "material": "glass", "center": [0, 0, 0], "radius": 1.5}
    whitted = Whitted(scene_of([ball]))
    rng = np.random.default_rng(2)
    d: Floats = rng.normal(scale=0.2, size=(3, 500)) + column([0, 0, -1])
    rays = Rays.of(column([0, 0, 5.0]), d)
    points = whitted.points(rays, whitted.first_hits(rays))
    assert len(points.rays) > 100
    for k in range(3):
        e = sideways(points.delta, k)
        mirrored = whitted.reflected(points).direction
        expected = e - 2 * (e * points.normal).sum(axis=0) * points.normal
        assert np.abs(carried(points, mirrored, k) - expected).max() < 1e-9
        assert np.abs(carried(points, points.delta, k) - e).max() < 1e-12
        anywhere = unit(rng.normal(size=points.M.shape))
        moved = carried(points, anywhere, k)
        assert np.abs((moved * anywhere).sum(axis=0)).max() < 1e-9
        assert np.abs((moved * moved).sum(axis=0) - 1).max() < 1e-9
