"""What is hidden is behind everything that the rays around it have met."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from minirt.culling import candidates, rasteriser
from minirt.culling.occlusion import OcclusionMap
from minirt.culling.ray_grid import RayGrid, grid_of
from minirt.geometry import Geometry
from minirt.rays import Rays
from minirt.rules import SLIDES
from minirt.vectors import Bools, Floats
from tests.helpers.culling_scenes import BRUTE, nearest, scene_with, triangle

EYE = (0.3, 0.4, 6.0)


def _targets(n: int, depth: float) -> Floats:
    side = np.linspace(-1, 1, n)
    x, y = np.meshgrid(side, side)
    return np.stack((x.ravel(), y.ravel(), np.full(n * n, depth)))


def _central(targets: Floats) -> Rays:
    P0 = np.array(EYE)[:, None]
    return Rays.of(P0, targets - P0)


def _parallel(targets: Floats) -> Rays:
    d = np.array([[0.1], [0.2], [-1.0]])
    return Rays.of(targets - 6.0 * d, d)


WAYS = pytest.mark.parametrize("way", [_central, _parallel])


def _grid(way: Callable[[Floats], Rays]) -> RayGrid:
    grid = grid_of(way(_targets(40, 0.0)), 0.0, 10.0)
    assert grid is not None
    return grid


@WAYS
@pytest.mark.parametrize("seed", range(4))
def test_no_ray_reaches_a_hidden_square(way: Callable[[Floats], Rays], seed: int) -> None:
    rng, grid = np.random.default_rng(seed), _grid(way)
    t_max = rng.uniform(0.5, 1.5, len(grid)) * (6.0 if way is _parallel else 1.0)
    u, v = (low + rng.uniform(-0.1, 1.1, 4_000) * size
            for low, size in zip(grid.low, grid.size, strict=True))  # fmt: skip
    radius = rng.uniform(0, 0.3, 4_000) * grid.size.max()
    near = rng.uniform(2.0, 12.0, 4_000)
    hidden = OcclusionMap(grid).hides(u, v, radius, near, t_max)
    reached = grid.begin + grid.speed * t_max
    inside = (np.abs(grid.u - u[:, None]) <= radius[:, None]) & (
        np.abs(grid.v - v[:, None]) <= radius[:, None]
    )
    met = (inside & (reached >= near[:, None])).any(axis=1)
    assert min(hidden.sum(), met.sum()) > 100
    assert not (hidden & met).any()


@WAYS
def test_layers_behind_each_other_are_met_as_without_culling(
    way: Callable[[Floats], Rays], monkeypatch: pytest.MonkeyPatch
) -> None:
    rng, counts = np.random.default_rng(1), [0]
    hides = OcclusionMap.hides

    def counted(occlusion: OcclusionMap, *squares: Floats) -> Bools:
        hidden = hides(occlusion, *squares)
        counts[0] += int(hidden.sum())
        return hidden

    monkeypatch.setattr(OcclusionMap, "hides", counted)
    monkeypatch.setattr(rasteriser, "_CHUNK", 64)
    monkeypatch.setattr(candidates, "_BATCH", 64)
    corners = np.array([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0, 0.1, 0]])
    layer = np.repeat([0.0, -1.0], 2_000)
    middles = np.stack((*rng.uniform(-1.1, 1.1, (2, 4_000)), layer + rng.uniform(-0.02, 0, 4_000)))
    scene = scene_with([triangle(corners + middle) for middle in middles.T])
    geometry, rays = Geometry.of(scene), way(_targets(40, -2.0))
    expected = nearest(geometry, BRUTE, rays.P0, rays.d)
    found = nearest(geometry, SLIDES, rays.P0, rays.d)
    assert counts[0] > 0
    for name in ("t", "object", "triangle", "beta", "gamma"):
        assert getattr(found, name).tobytes() == getattr(expected, name).tobytes(), name
