"""Culling never changes a bit: every quantity, with the trees and by asking every pair."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.beams import Rays
from minirt.bvh import visit
from minirt.every_hit import every_hit
from minirt.geometry import Geometry
from minirt.rules import SLIDES, in_interval
from minirt.trace import Hits, nearest, occluded
from minirt.vectors import Floats

#: An equal rule that is not the same object: boxes are only trusted with the lecture's own rules.
BRUTE = SLIDES.replace(in_interval=lambda *interval: in_interval(*interval))

Objects = list[dict[str, Any]]


def _sphere(center: Any, radius: float, material: str = "all") -> dict[str, Any]:
    center = [float(x) for x in center]
    return {"type": "sphere", "material": material, "center": center, "radius": float(radius)}


def _triangle(vertices: Any, material: str = "all") -> dict[str, Any]:
    vertices = np.asarray(vertices, dtype=float).tolist()
    return {"type": "triangle", "material": material, "vertices": vertices}


def _polygon(vertices: Any, material: str = "all") -> dict[str, Any]:
    return {**_triangle(vertices, material), "type": "polygon"}


def _rectangle(low: Any, side: Any, up: Any) -> dict[str, Any]:
    low, side, up = (np.asarray(v, dtype=float) for v in (low, side, up))
    return _polygon([low, low + side, low + side + up, low + up])


def _scene(objects: Objects, eye: Any = (0.3, 0.4, 6.0), **more: Any) -> minirt.Scene:
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
    spheres = [_sphere(rng.uniform(-2, 2, 3), rng.uniform(0.05, 0.5)) for _ in range(40)]
    corners = rng.uniform(-2, 2, (60, 1, 3)) + rng.normal(size=(60, 3, 3)) * 0.4
    return [*spheres, *map(_triangle, corners), _rectangle((-3, -2, -3), (6, 0, 0), (0, 0, 6))]


def _coplanar(rng: np.random.Generator) -> Objects:
    low = rng.integers(-4, 4, (30, 2)) / 2
    flat = [_triangle([(x, y, 0), (x + 1, y, 0), (x, y + 1, 0)]) for x, y in low]
    return [*flat, *(_rectangle((x, y, 0), (0.5, 0, 0), (0, 0.5, 0)) for x, y in low[:10])]


def _touching(rng: np.random.Generator) -> Objects:
    grid = np.stack(np.meshgrid(*[np.arange(-1.0, 2.0)] * 3), axis=-1).reshape(-1, 3)
    return [*(_sphere(c, 0.5) for c in grid), _rectangle((-2, -1.5, -2), (4, 0, 0), (0, 0, 4))]


def _shared_edges(rng: np.random.Generator) -> Objects:
    z = rng.integers(0, 3, (9, 9)) / 4
    cells = [(i, j) for i in range(8) for j in range(8)]

    def point(i: int, j: int) -> tuple[float, float, float]:
        return (i - 4) / 2, (j - 4) / 2, z[i, j]

    lower = [_triangle([point(i, j), point(i + 1, j), point(i, j + 1)]) for i, j in cells]
    upper = [_triangle([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]) for i, j in cells]
    return lower + upper


def _duplicates(rng: np.random.Generator) -> Objects:
    once = _mixed(rng)[20:70]
    return [once[k] for k in rng.permutation(np.repeat(np.arange(len(once)), 3))]


def _scales(rng: np.random.Generator) -> Objects:
    spheres = [_sphere(rng.normal(size=3), 10.0 ** rng.uniform(-9, -1)) for _ in range(40)]
    corners = rng.normal(size=(60, 1, 3)) + rng.normal(size=(60, 3, 3)) * 10.0 ** rng.uniform(
        -8, 3, (60, 1, 1)
    )
    return [*spheres, _sphere((0, -1e6, 0), 1e6 - 2), *map(_triangle, corners)]


def _degenerate(rng: np.random.Generator) -> Objects:
    a, b = rng.uniform(-2, 2, (2, 40, 3))
    lines = [_triangle(v) for v in np.stack((a, b, a + (b - a) * rng.random((40, 1))), axis=1)]
    points = [_triangle([p, p, p]) for p in a[:10]]
    return lines + points + _mixed(rng)[::3]


def _edge_on(rng: np.random.Generator) -> Objects:
    eye = np.array([0.3, 0.4, 6.0])
    near, side = rng.uniform(-2, 2, (40, 3)), rng.uniform(-2, 2, (40, 3))
    fans = [_triangle([p, p + 0.5 * (p - eye), q]) for p, q in zip(near, side, strict=True)]
    through_eye = [
        _triangle([p, q, eye + 0.8 * (p - eye) + 0.1 * (q - eye)])
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


def _moved(objects: Objects, by: Floats) -> Objects:
    moved = []
    for thing in objects:
        key = "center" if "center" in thing else "vertices"
        moved.append({**thing, key: (np.array(thing[key]) + by).tolist()})
    return moved


def _assert_same(scene: minirt.Scene, least: int) -> None:
    culled, asked = minirt.render(scene), minirt.render(scene, rules=BRUTE)
    assert BRUTE.changed() == ("in_interval",)
    for name in minirt.QUANTITIES:
        assert culled[name].tobytes() == asked[name].tobytes(), name
    assert culled["hit"].sum() >= least


@pytest.mark.parametrize("family", FAMILIES)
def test_render_is_the_same_with_and_without_boxes(family: str) -> None:
    _assert_same(_scene(FAMILIES[family](np.random.default_rng(20))), 40)


@pytest.mark.parametrize("family", ["mixed", "touching", "shared_edges", "boxes"])
def test_render_is_the_same_1e5_away(family: str) -> None:
    by = np.array([1e5, -7e4, 3e4])
    objects = _moved(FAMILIES[family](np.random.default_rng(21)), by)
    _assert_same(_scene(objects, eye=by + np.array([0.3, 0.4, 6.0])), 40)


@pytest.mark.parametrize("family", ["coplanar", "touching", "shared_edges", "boxes"])
def test_render_is_the_same_for_rays_along_axes_and_through_edges(family: str) -> None:
    """An odd image centred on a lattice: the middle rays have zero components and run in faces."""
    objects = FAMILIES[family](np.random.default_rng(22))
    _assert_same(_scene(objects, eye=(0, 0, 4), nx=25, ny=25), 40)


def _rays(rng: np.random.Generator, scene: minirt.Scene, n: int) -> tuple[Floats, Floats]:
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


@pytest.mark.parametrize("family", FAMILIES)
def test_rt_is_the_same_with_and_without_boxes(family: str) -> None:
    rng = np.random.default_rng(23)
    scene = _scene(FAMILIES[family](rng))
    geometry, (P0, d) = Geometry.of(scene), _rays(rng, scene, 3000)
    met = 0
    for t0, t1 in ((0.0, np.inf), (0.5, 2.0), (1.0, 1.0)):
        culled, asked = (nearest(geometry, rules, P0, d, t0, t1) for rules in (SLIDES, BRUTE))
        for name, value in vars(culled).items():
            assert value.tobytes() == getattr(asked, name).tobytes(), (name, t0, t1)
        shadows = [occluded(geometry, rules, P0, d, t0, t1) for rules in (SLIDES, BRUTE)]
        assert np.array_equal(shadows[0], shadows[1])
        assert np.array_equal(shadows[0], culled.object >= 0)
        met += int(shadows[0].sum())
    assert met > 300


@pytest.mark.parametrize("family", FAMILIES)
def test_nearest_is_the_first_of_all_hits(family: str) -> None:
    rng = np.random.default_rng(24)
    scene = _scene(FAMILIES[family](rng))
    geometry, (P0, d) = Geometry.of(scene), _rays(rng, scene, 1000)
    first = nearest(geometry, SLIDES, P0, d, 0.0)
    every = every_hit(geometry, SLIDES, P0, d, 0.0, np.inf)
    assert every.t.shape[0] > 1
    for name, value in vars(every).items():
        assert value[0].tobytes() == getattr(first, name).tobytes(), name


def test_many_rays_meet_few_boxes() -> None:
    """That the boxes cull at all: a primitive is offered to a small part of the rays."""
    rng = np.random.default_rng(25)
    scene = _scene([_sphere(rng.uniform(-2, 2, 3), 0.02) for _ in range(500)])
    spheres = Geometry.of(scene).spheres
    rays = Rays(np.zeros((3, 2000)), rng.normal(size=(3, 2000)), np.zeros(2000))
    asked = sum(
        beams.size * len(primitives)
        for beams, _, primitives in visit(spheres.tree, rays.beams(), np.full(2000, np.inf), 0.0)
    )
    assert 0 < asked < 0.1 * 500 * 2000


def test_hits_of_no_ray_keep_their_shape() -> None:
    geometry = Geometry.of(_scene(_mixed(np.random.default_rng(26))))
    none = nearest(geometry, SLIDES, np.zeros((3, 0)), np.zeros((3, 0)), 0.0)
    assert isinstance(none, Hits)
    assert none.t.shape == none.object.shape == (0,)
