"""What rays share is said by a shape alone: how arrays lie in memory decides nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import minirt
from minirt.geometry import Geometry
from minirt.rays import Rays
from minirt.rules import SLIDES
from minirt.trace import RT, World
from minirt.vectors import Floats
from tests.helpers.culling_scenes import BRUTE, FAMILIES, nearest, scene_with


def _scene() -> minirt.Scene:
    return scene_with(FAMILIES["mixed"](np.random.default_rng(40)))


def _rays(shared: str) -> tuple[Floats, Floats]:
    """Arrays whose last axis is 1 where it is shared, and broadcast where it only seems so."""
    rng = np.random.default_rng(41)
    P0, d = np.array([[0.3], [0.4], [6.0]]), rng.uniform(-0.4, 0.4, (3, 500)) - [[0], [0], [1]]
    if shared == "direction":
        return rng.uniform((-2, -2, 4), (2, 2, 8), (500, 3)).T, np.array([[0.0], [0.1], [-1.0]])
    return (np.broadcast_to(P0, d.shape) if shared == "seemingly" else P0), d


@pytest.mark.parametrize("shared", ["origin", "direction", "seemingly"])
def test_copies_of_the_arrays_are_traced_by_the_same_algorithm(
    shared: str, drawn: list[int]
) -> None:
    world, given = World.of(Geometry.of(_scene()), SLIDES), Rays.of(*_rays(shared))
    copies = [
        replace(given, P0=given.P0.copy(), d=given.d.copy()),
        replace(given, P0=np.asfortranarray(given.P0), d=np.asfortranarray(given.d)),
    ]
    first = RT(world, given)
    asked = drawn[:]
    for rays in copies:
        drawn.clear()
        again = RT(world, rays)
        assert drawn == asked
        for name, value in vars(first).items():
            assert value.tobytes() == getattr(again, name).tobytes(), name
    assert np.isfinite(first.t).sum() > 50


def test_one_ray_many_times_is_one_ray() -> None:
    """Origin and direction are shared; the intervals are not."""
    geometry, t0 = Geometry.of(_scene()), np.linspace(0, 10, 400)
    P0, d = np.array([[0.3], [0.4], [6.0]]), np.array([[0.0], [0.0], [-1.0]])
    culled, asked = (nearest(geometry, rules, P0, d, t0) for rules in (SLIDES, BRUTE))
    for name, value in vars(culled).items():
        assert value.tobytes() == getattr(asked, name).tobytes(), name
    assert len(np.unique(culled.object)) > 2


@pytest.mark.parametrize("given", [(3,), (3, 1), (3, 500)])
def test_a_point_given_once_is_the_point_of_each_ray(given: tuple[int, ...]) -> None:
    P0, d = _rays("origin")
    scene = _scene()
    origin = np.broadcast_to(P0, (3, 500)) if given == (3, 500) else P0.reshape(given)
    hits = [minirt.RT(scene, each, d) for each in (origin, origin.copy(), np.tile(P0, 500))]
    for name, value in vars(hits[0]).items():
        for other in hits[1:]:
            assert value.tobytes() == getattr(other, name).tobytes(), name
