"""Culling never changes a bit: every quantity, with the trees and by asking every pair."""

from __future__ import annotations

import numpy as np
import pytest

import minirt
from minirt.culling import SceneIndex, culled_pairs
from minirt.culling.tree import visit
from minirt.every_hit import every_hit
from minirt.geometry import Geometry
from minirt.hits import RayHits
from minirt.rays import Rays
from minirt.rules import SLIDES
from minirt.trace import World
from minirt.vectors import Floats, unit
from tests.helpers.culling_scenes import (
    BRUTE,
    FAMILIES,
    Objects,
    nearest,
    occluded,
    rays_around,
    scene_with,
    sphere,
    triangle,
)  # fmt: skip


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
    _assert_same(scene_with(FAMILIES[family](np.random.default_rng(20))), 40)


@pytest.mark.parametrize("family", ["mixed", "touching", "shared_edges", "boxes"])
def test_render_is_the_same_1e5_away(family: str) -> None:
    by = np.array([1e5, -7e4, 3e4])
    objects = _moved(FAMILIES[family](np.random.default_rng(21)), by)
    _assert_same(scene_with(objects, eye=by + np.array([0.3, 0.4, 6.0])), 40)


@pytest.mark.parametrize("family", ["coplanar", "touching", "shared_edges", "boxes"])
def test_render_is_the_same_for_rays_along_axes_and_through_edges(family: str) -> None:
    """An odd image centred on a lattice: the middle rays have zero components and run in faces."""
    objects = FAMILIES[family](np.random.default_rng(22))
    _assert_same(scene_with(objects, eye=(0, 0, 4), nx=25, ny=25), 40)


@pytest.mark.parametrize("family", FAMILIES)
def test_rt_is_the_same_with_and_without_boxes(family: str) -> None:
    rng = np.random.default_rng(23)
    scene = scene_with(FAMILIES[family](rng))
    geometry, (P0, d) = Geometry.of(scene), rays_around(rng, scene, 3000)
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
    scene = scene_with(FAMILIES[family](rng))
    geometry, (P0, d) = Geometry.of(scene), rays_around(rng, scene, 1000)
    first = nearest(geometry, SLIDES, P0, d, 0.0)
    every = every_hit(World.of(geometry, SLIDES), Rays.of(P0, d))
    assert every.t.shape[0] > 1
    for name, value in vars(every).items():
        assert value[0].tobytes() == getattr(first, name).tobytes(), name


def test_many_rays_meet_few_boxes() -> None:
    """That the boxes cull at all: a primitive is offered to a small part of the rays."""
    rng = np.random.default_rng(25)
    scene = scene_with([sphere(rng.uniform(-2, 2, 3), 0.02) for _ in range(500)])
    (spheres,) = SceneIndex.of(Geometry.of(scene)).kinds
    rays = Rays.of(np.zeros((3, 2000)), rng.normal(size=(3, 2000)))
    asked = sum(len(of) for of, _ in visit(spheres.tree, rays, np.full(2000, np.inf), 0.0))
    assert 0 < asked < 0.1 * 500 * 2000


def test_facets_seen_edge_on_are_met_where_the_ray_passes_them() -> None:
    """Rays in the planes of triangles, cutting a corner off; asked for exactly what they meet."""
    rng = np.random.default_rng(29)
    corners = rng.uniform(-2, 2, (60, 1, 3)) + rng.normal(size=(60, 3, 3))
    geometry = Geometry.of(scene_with([triangle(each) for each in corners]))
    a, b, c = corners[np.arange(3000) % 60].transpose(1, 2, 0)
    near, far = 10.0 ** rng.uniform(-3, -0.5, (2, 3000))
    start, end = a + near * (b - a), a + far * (c - a)
    N, d = np.cross(b - a, c - a, axis=0), end - start
    d, N = d / np.linalg.norm(d, axis=0), N / np.linalg.norm(N, axis=0)
    P0 = start - rng.uniform(1, 4, 3000) * d
    d += N * 10.0 ** rng.uniform(-17, -14, 3000) * rng.choice([-1, 1], 3000)
    found = nearest(geometry, BRUTE, P0, d, 0.0)
    assert (found.object >= 0).sum() > 1000
    at = np.where(np.isfinite(found.t), found.t, 1.0)
    for low, high in ((0.0, np.inf), (at, at), (np.nextafter(at, np.inf), np.inf)):
        hits = [nearest(geometry, rules, P0, d, low, high) for rules in (SLIDES, BRUTE)]
        for name, value in vars(hits[0]).items():
            assert value.tobytes() == getattr(hits[1], name).tobytes(), name


@pytest.mark.parametrize("large", [1e2, 1e4, 1e6, 1e9])
def test_rays_without_order_meet_few_boxes_beside_something_large(large: float) -> None:
    """What single precision makes boxes grow by is a share of the tree: detail must stay small."""
    rng = np.random.default_rng(27)
    detail = [sphere(rng.uniform(-1, 1, 3), 0.02) for _ in range(500)]
    scene = scene_with([sphere((0, 0, -large - 1), large), *detail])
    (spheres,) = SceneIndex.of(Geometry.of(scene)).kinds
    P0, d = rng.uniform(-1, 1, (3, 1000)) * [[1], [1], [3]], rng.normal(size=(3, 1000))
    found = visit(spheres.tree, Rays.of(P0, d), np.full(1000, np.inf), 1e-9)
    asked = sum(len(of) for of, _ in found)
    assert 1000 < asked < 0.05 * 501 * 1000


@pytest.mark.parametrize("size", [1e-25, 1e-20, 1.0])
def test_single_rays_from_very_far_are_the_same(size: float) -> None:
    """In units of a small tree the pad of a far origin is beyond single precision's range."""
    rng = np.random.default_rng(28)
    objects = [sphere(size * rng.uniform(-1, 1, 3), 0.3 * size) for _ in range(60)]
    geometry = Geometry.of(scene_with(objects))
    P0 = rng.normal(size=(3, 400)) * size
    d = -P0 / size
    P0[:, ::2] *= 2e29 / size
    hits = [nearest(geometry, rules, P0, d, 0.0) for rules in (SLIDES, BRUTE)]
    for name, value in vars(hits[0]).items():
        assert value.tobytes() == getattr(hits[1], name).tobytes(), name
    assert (hits[0].object >= 0).sum() > 150


def test_hits_of_no_ray_keep_their_shape() -> None:
    geometry = Geometry.of(scene_with(FAMILIES["mixed"](np.random.default_rng(26))))
    none = nearest(geometry, SLIDES, np.zeros((3, 0)), np.zeros((3, 0)), 0.0)
    assert isinstance(none, RayHits)
    assert none.t.shape == none.object.shape == (0,)


def _blocks(rng: np.random.Generator, objects: Objects, kind: str) -> Rays:
    """Blocks of rays, each of which keeps to some outline as closely as it likes.

    Every third one's origins are in the plane of what it keeps to, or nearly.
    """
    points, partners = [], []
    for thing in objects:
        vertices = np.atleast_2d(thing["center" if "center" in thing else "vertices"])
        away = unit(rng.normal(size=(3, 1)))[:, 0] * thing.get("radius", 0.0)
        points.append(vertices + away)
        partners.append(np.roll(vertices, 1, axis=0) - away)
    b = 60
    some = rng.integers(0, sum(map(len, points)), b)
    aim, other = np.concatenate(points)[some, None], np.concatenate(partners)[some, None]
    start = aim + rng.uniform(-3, 3, (b, 1, 3))
    above = 10.0 ** rng.uniform(-14, -2, (b, 1, 1)) * rng.normal(size=(b, 1, 3))
    start[::3] = (aim + 4.0 * (other - aim) + above)[::3]
    near = 10.0 ** rng.uniform(-14, 0, (2, b, 1, 1)) * rng.normal(size=(2, b, 64, 3))
    if kind == "one point":
        start, aim = np.broadcast_to(start[1:2], near[0].shape), aim + near[1]
    else:
        start, aim = start + near[0], aim + (near[0] if kind == "parallel" else near[1])
    P0, d = (x.reshape(-1, 3).T for x in (start, aim - start))
    return Rays.of(P0[:, :1] if kind == "one point" else P0, d)


@pytest.mark.parametrize("far", [0.0, 1e5])
@pytest.mark.parametrize("kind", ["one point", "own points", "parallel"])
@pytest.mark.parametrize("family", FAMILIES)
def test_few_objects_are_the_same_for_blocks_of_rays_that_graze_their_outlines(
    family: str, kind: str, far: float
) -> None:
    rng = np.random.default_rng(28)
    objects = FAMILIES[family](rng)
    few = [objects[k] for k in rng.permutation(len(objects))[:12]]
    few = _moved(few, far * np.array([1.0, -0.7, 0.3]))
    geometry, rays = Geometry.of(scene_with(few)), _blocks(rng, few, kind)
    for t1 in (np.inf, 1.0):
        culled, asked = (
            nearest(geometry, rules, rays.P0, rays.d, 0.0, t1) for rules in (SLIDES, BRUTE)
        )
        for name, values in vars(culled).items():
            assert values.tobytes() == vars(asked)[name].tobytes(), name
        assert (culled.object >= 0).mean() > 0.05


@pytest.mark.parametrize("n", [1, 64, 65, 130])
def test_no_ray_is_offered_one_of_few_primitives_twice(n: int) -> None:
    rng = np.random.default_rng(30)
    around = [sphere((0, 0, 0), radius) for radius in np.linspace(3, 5, 20)]
    beside = [sphere((9, k, 0), 0.3) for k in range(3)]
    geometry = Geometry.of(scene_with([*around, *beside]))
    for own in (0.0, 0.01, 0.5):
        P0 = rng.normal(size=(3, n)) * own
        d = np.array([[0.0], [0.0], [1.0]]) + 0.01 * rng.normal(size=(3, n))
        rays = Rays.of(P0 if own else P0[:, :1], d)
        batches = culled_pairs(SceneIndex.of(geometry), rays, np.full(n, np.inf))
        pairs = np.concatenate([np.stack((of, which)) for _, of, which in batches], axis=1)
        assert len(around) * n <= pairs.shape[1] == np.unique(pairs, axis=1).shape[1]
        assert pairs[0].max() < n


def test_a_triangle_whose_normal_has_no_square_is_seen() -> None:
    """The square of what is 1e-162 long is a few of the least numbers that there are: divided by
    the root of that, the normal would be half as long again, and the plane elsewhere.
    """
    corners = [
        (-2.999769419130499e-80, 6.6449612254156175e-80, 2.775867054795566e-79),
        (-2.98081375184444e-80, 6.779790035636816e-80, 2.7845146496407247e-79),
        (-2.9670842337022735e-80, 6.726952508011892e-80, 2.762366935062665e-79),
    ]
    scene = scene_with(
        [triangle(corners)], eye=(0, 0, 0), nu=1.0, nx=8, ny=8,
        l=-1.5935796243846148, r=-0.008437158141917589,
        b=0.22950850568308745, t=0.43142021159355437,
    )  # fmt: skip
    for names in ("t", "ray,t"):
        culled, asked = (minirt.render(scene, rules, names)["t"] for rules in (SLIDES, BRUTE))
        assert culled.tobytes() == asked.tobytes()
        assert np.isfinite(asked).sum() == 1


def test_a_polygon_off_its_plane_is_offered_at_small_angles() -> None:
    """Its corners lie 1.5e-9 beside its plane: rays through one cross that far outside."""
    corners = [(-2, -1, 0), (1, -1, 0), (1, 1, 3e-9), (-2, 1, 0)]
    geometry = Geometry.of(scene_with([{**triangle(corners), "type": "polygon"}]))
    rng = np.random.default_rng(29)
    n, b = 64, 40
    angle, wide = 10.0 ** rng.uniform(-7, -4, (b, 1)), 10.0 ** rng.uniform(-12, -8, (b, 1, 1))
    aim = (1, -1, 0) + np.abs(rng.normal(size=(b, n, 3))) * wide * (-1, 1, 0)
    start = np.array([-3.0, 2.0, 0.0]) + angle * (0, 0, -5)
    P0 = np.repeat(start, n, axis=0).T
    d = aim.reshape(-1, 3).T - P0
    culled, asked = (nearest(geometry, rules, P0, d, 0.0) for rules in (SLIDES, BRUTE))
    assert (asked.object >= 0).mean() > 0.9
    assert culled.t.tobytes() == asked.t.tobytes()
