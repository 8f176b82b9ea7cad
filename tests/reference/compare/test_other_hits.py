"""What rays meet beside the first hit, which the error model asks for."""

from __future__ import annotations

import numpy as np
import pytest

from minirt.every_hit import every_hit
from minirt.geometry import Geometry
from minirt.rays import Rays
from minirt.rules import SLIDES
from minirt.trace import RT, World
from reference.compare.other_hits import nearest_other, nearest_two
from tests.helpers.culling_scenes import BRUTE, FAMILIES, rays_around, scene_with


@pytest.mark.parametrize("family", sorted(FAMILIES.keys() - {"scales"}))  # its hits lie far apart
def test_the_next_hit_is_known_as_far_as_it_is_looked_for(family: str) -> None:
    rng = np.random.default_rng(27)
    scene = scene_with(FAMILIES[family](rng))
    world, rays = World.of(Geometry.of(scene), SLIDES), Rays.of(*rays_around(rng, scene, 1000))
    first, next_t = nearest_two(world, rays, 0.1, 0.3)
    every = every_hit(world, rays)
    own = (every.object == first.object) & (every.triangle == first.triangle)
    second = np.where(own, np.inf, every.t).min(axis=0)
    near = np.flatnonzero((second < np.inf) & (second <= first.t * 1.3 + 0.1))
    assert first.t.tobytes() == every.t[0].tobytes()
    assert (first.t <= next_t).all()
    assert (next_t[near] <= second[near]).all()
    assert len(near) > 5


@pytest.mark.parametrize("family", FAMILIES)
def test_another_surface_is_the_same_with_and_without_culling(family: str) -> None:
    rng = np.random.default_rng(30)
    scene = scene_with(FAMILIES[family](rng))
    P0, d = rays_around(rng, scene, 1000)
    first = RT(World.of(Geometry.of(scene), SLIDES), Rays.of(P0, d))
    until = np.where(np.isfinite(first.t), first.t * (1 + 1e-9), 1.0)
    for t1 in (np.inf, until):
        for face in (first.triangle, None):
            others = [
                nearest_other(
                    World.of(Geometry.of(scene), rules),
                    Rays.of(P0, d, 0.0, t1),
                    (first.object, face),
                )
                for rules in (SLIDES, BRUTE)
            ]
            for name, value in vars(others[0]).items():
                assert value.tobytes() == getattr(others[1], name).tobytes(), name
            assert (
                (others[0].object != first.object)
                | (others[0].object < 0)
                | ((others[0].triangle != first.triangle) & (face is not None))
            ).all()


def test_a_polygon_is_passed_over_as_a_whole() -> None:
    """Whatever triangle of its fan is named: a ray has one hit at most on it."""
    square = {"type": "polygon", "material": "all",
              "vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]}  # fmt: skip
    geometry = Geometry.of(scene_with([square]))
    P0, d = np.array([[-0.5, 0.5], [0.5, -0.5], [3, 3]]), np.array([[0.0, 0], [0, 0], [-1, -1]])
    assert set(RT(World.of(geometry, SLIDES), Rays.of(P0, d)).triangle) == {0, 1}
    for rules in (SLIDES, BRUTE):
        for face in (0, 1):
            passed = np.zeros(2, dtype=np.int32), np.full(2, face, dtype=np.int32)
            other = nearest_other(World.of(geometry, rules), Rays.of(P0, d), passed)
            assert (other.object == -1).all()
