"""Triangles drawn over a grid of rays: never a bit changed, and asked where they are cheaper."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import minirt
from minirt.culling import SceneIndex, culled_pairs, rasteriser
from minirt.culling.projection import Projection
from minirt.culling.rasteriser import Rasteriser
from minirt.culling.ray_grid import grid_of
from minirt.geometry import Geometry
from minirt.rays import Rays
from minirt.rules import SLIDES
from minirt.vectors import Floats, Index
from tests.helpers.culling_scenes import (
    BRUTE,
    FAMILIES,
    nearest,
    occluded,
    scene_with,
    sphere,
    triangle,
)  # fmt: skip
from tests.helpers.tiers import tiered

EYE = np.array([0.3, 0.4, 6.0])
#: Families with more triangles than are offered without culling.
MANY = ("mixed", "shared_edges", "duplicates", "scales", "degenerate", "edge_on")


def _triangles(scene: minirt.Scene) -> Floats:
    """(m, 3, 3): the vertices of the scene's triangles."""
    found = Geometry.of(scene).triangles
    return np.stack((found.a, found.b, found.c)).transpose(2, 0, 1)


def _targets(rng: np.random.Generator, triangles: Floats, n: int) -> Floats:
    """Points (3, n) in triangles, on their edges and vertices, and a hair beside them."""
    weights = rng.dirichlet((1, 1, 1), n)
    weights[: n // 2, 0] = 0
    weights[: n // 4] = np.eye(3)[rng.integers(0, 3, n // 4)]
    weights /= weights.sum(axis=1, keepdims=True)
    chosen = triangles[rng.integers(0, len(triangles), n)]
    points = (chosen * weights[:, :, None]).sum(axis=1)
    points[::3] += rng.normal(size=points[::3].shape) * 10.0 ** rng.uniform(-15, -6, (n, 1))[::3]
    return np.ascontiguousarray(points.T)


def _central(rng: np.random.Generator, targets: Floats) -> tuple[Floats, Floats]:
    d = targets - EYE[:, None]
    return EYE[:, None], d


def _nearly_central(rng: np.random.Generator, targets: Floats) -> tuple[Floats, Floats]:
    P0 = EYE[:, None] + 1e-7 * rng.normal(size=targets.shape)
    return P0, targets - P0


def _parallel(rng: np.random.Generator, targets: Floats) -> tuple[Floats, Floats]:
    d = rng.normal(size=(3, 1))
    return targets - d * rng.integers(0, 3, targets.shape[1]) * rng.random(), d


def _along_an_axis(rng: np.random.Generator, targets: Floats) -> tuple[Floats, Floats]:
    d = np.array([[0.0], [0.0], [-2.0]])
    return targets - d * rng.integers(0, 3, targets.shape[1]), d


RAYS = {f.__name__[1:]: f for f in (_central, _nearly_central, _parallel, _along_an_axis)}


def _ahead(P0: Floats, d: Floats) -> Index:
    """Numbers of the rays that go about the way of most."""
    along = d / np.linalg.norm(d, axis=0)
    return np.flatnonzero(np.median(along, axis=1) @ along > 0.2)


@pytest.mark.parametrize("kind", tiered(RAYS, lambda kind: kind != "nearly_central"))
@pytest.mark.parametrize("family", MANY)
def test_rt_is_the_same_with_and_without_a_drawing(
    family: str, kind: str, drawn: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rasteriser, "_CHUNK", 64)  # so that what was met hides what is drawn later
    monkeypatch.setattr(rasteriser, "_PAIRS", 256)
    rng = np.random.default_rng(30)
    scene = scene_with(FAMILIES[family](rng))
    P0, d = RAYS[kind](rng, _targets(rng, _triangles(scene), 3000))
    if kind in ("central", "nearly_central"):
        ahead = _ahead(P0, d)
        d = d[:, ahead]
        P0 = P0[:, ahead] if kind == "nearly_central" else P0
    geometry = Geometry.of(scene)
    asked = nearest(geometry, BRUTE, P0, d, 0.0)
    until = np.where(np.isfinite(asked.t), asked.t * (1 + 1e-9), 1.0)
    for t0, t1 in ((0.0, np.inf), (1e-3, np.inf), (0.0, until)):
        hits = [nearest(geometry, rules, P0, d, t0, t1) for rules in (SLIDES, BRUTE)]
        for name, value in vars(hits[0]).items():
            assert value.tobytes() == getattr(hits[1], name).tobytes(), (name, t0)
        shadows = [occluded(geometry, rules, P0, d, t0) for rules in (SLIDES, BRUTE)]
        assert np.array_equal(shadows[0], shadows[1])
    assert len(drawn) in (6, 12)  # triangles, and spheres if there are many
    assert (asked.object >= 0).sum() > 900


@pytest.mark.parametrize("kind", RAYS)
def test_rays_that_graze_spheres_are_the_same(kind: str, drawn: list[int]) -> None:
    """Rays through points of spheres, half of them tangent there, or a hair beside."""
    rng = np.random.default_rng(32)
    center, radius = rng.uniform(-2, 2, (3, 60)), 10.0 ** rng.uniform(-6, -0.3, 60)
    scene = scene_with([sphere(c, r) for c, r in zip(center.T, radius, strict=True)])
    which, out = rng.integers(0, 60, 3000), rng.normal(size=(3, 3000))
    _, d = RAYS[kind](rng, center[:, which])
    out -= np.where(rng.random(3000) < 0.5, (out * d).sum(axis=0) / (d * d).sum(axis=0), 0.0) * d
    out /= np.linalg.norm(out, axis=0)
    off = 1 + rng.choice([0, 1e-15, -1e-15, 1e-9, -1e-9], 3000)
    P0, d = RAYS[kind](rng, center[:, which] + radius[which] * off * out)
    geometry = Geometry.of(scene)
    hits = [nearest(geometry, rules, P0, d, 0.0) for rules in (SLIDES, BRUTE)]
    for name, value in vars(hits[0]).items():
        assert value.tobytes() == getattr(hits[1], name).tobytes(), name
    assert drawn == [3000]
    assert 1000 < np.isfinite(hits[0].t).sum() < 3000


@pytest.mark.parametrize("away", [0.0, 1e5])
@pytest.mark.parametrize("family", ["mixed", "shared_edges", "scales"])
def test_images_are_the_same_with_and_without_a_drawing(
    family: str, away: float, drawn: list[int]
) -> None:
    by = away * np.array([1.0, -0.7, 0.3])
    objects = [triangle(v + by) for v in _triangles(scene_with(FAMILIES[family](_rng())))]
    scene = scene_with(objects, eye=(EYE + by).tolist(), nx=48, ny=48)
    culled, asked = (minirt.render(scene, rules=rules) for rules in (SLIDES, BRUTE))
    for name in minirt.QUANTITIES:
        assert culled[name].tobytes() == asked[name].tobytes(), name
    assert drawn[0] == 48 * 48


def _rng() -> np.random.Generator:
    return np.random.default_rng(31)


def test_a_room_around_the_observer_is_seen(drawn: list[int]) -> None:
    """Some triangles reach behind the observer, or lie beside it: they cannot be drawn."""
    ahead = _rng().normal(size=(60, 1, 3)) + _rng().normal(size=(60, 3, 3)) - (0, 0, 12)
    walls = [[(-9, -1, 9), (9, -1, 9), (0, -1, -30)], [(-9, 4, 9), (9, 4, 9), (0, 4, -30)]]
    beside = [[(-1e-6, 0, 0), (1e-6, 1e-6, 0), (0, 0, -1e-5)]]
    objects = [triangle(v + EYE) for v in np.concatenate((ahead, walls, beside))]
    scene = scene_with(objects, eye=EYE.tolist(), nx=64, ny=64)
    culled, asked = (
        minirt.render(scene, rules, quantities="t,object") for rules in (SLIDES, BRUTE)
    )
    assert culled["t"].tobytes() == asked["t"].tobytes()
    assert set(range(60, 63)) < set(np.unique(culled["object"]))
    assert drawn


def _lattice(rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Parallel rays along the diagonal of the cube that their origins fill."""
    P0 = np.stack(np.meshgrid(*[np.linspace(-2, 2, 9)] * 3)).reshape(3, -1)
    return P0, np.ones((3, 1))


def _in_file(rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Rays that start behind each other."""
    d = np.array([[0.3], [0.7], [0.2]])
    return 0.1 + d * rng.uniform(-5, 5, 2000), d


def _one_and_the_same(rng: np.random.Generator) -> tuple[Floats, Floats]:
    return np.tile([[0.0], [0.0], [3.0]], 4096), np.array([[0.0], [0.1], [-1.0]])


def _each_four_times(rng: np.random.Generator) -> tuple[Floats, Floats]:
    P0, d = _screen(32, 32)
    return P0, np.repeat(d, 4, axis=1)


def _next_to_no_width(rng: np.random.Generator) -> tuple[Floats, Floats]:
    P0, d = _screen(64, 64)
    return P0, np.stack((rng.integers(-3, 4, d.shape[1]) * 1e-310, d[1], d[2]))


ODD = (_lattice, _in_file, _one_and_the_same, _each_four_times, _next_to_no_width)


@pytest.mark.parametrize("rays", ODD)
def test_odd_bundles_of_rays_are_the_same(
    rays: Callable[[np.random.Generator], tuple[Floats, Floats]], drawn: list[int]
) -> None:
    rng = np.random.default_rng(33)
    balls = [sphere(c, 0.3) for c in rng.uniform(-2, 2, (60, 3))]
    corners = rng.uniform(-2, 2, (60, 1, 3)) + rng.normal(size=(60, 3, 3)) * 0.4
    geometry = Geometry.of(scene_with([*balls, *map(triangle, corners)]))
    P0, d = rays(rng)
    culled, asked = (nearest(geometry, rules, P0, d, 0.0) for rules in (SLIDES, BRUTE))
    for name, value in vars(culled).items():
        assert value.tobytes() == getattr(asked, name).tobytes(), name
    assert len(drawn) == 2
    assert np.isfinite(asked.t).any()


def test_small_things_far_away_are_culled_all_the_same() -> None:
    """Origins that are close together, for the numbers they have, are not one point for that."""
    rng = np.random.default_rng(34)
    far = np.array([1e6, -7e5, 3e5])
    corners = far + rng.uniform(-2, 2, (1000, 1, 3)) + rng.normal(size=(1000, 3, 3)) * 0.1
    geometry = Geometry.of(scene_with([triangle(v) for v in corners]))
    P0, d = far[:, None] + rng.uniform(-2, 2, (3, 2000)), rng.normal(size=(3, 2000))
    pairs = culled_pairs(SceneIndex.of(geometry), Rays.of(P0, d), np.full(2000, np.inf))
    assert sum(len(of) for _, of, _ in pairs) < 0.02 * 1000 * 2000


def test_a_group_around_the_observer_is_seen(drawn: list[int]) -> None:
    """Its middle is the observer, and projects nowhere."""
    shape = np.array([(-0.2, -0.1, 0.0), (0.2, -0.1, 0.0), (0.0, 0.2, 0.0)])
    scene = scene_with([triangle(shape + np.array([0, 0, z])) for z in np.linspace(-8, 8, 40)])
    _, d = _screen(64, 64)
    P0, geometry = np.zeros((3, 1)), Geometry.of(scene)
    for until in (np.inf, 6.0):
        culled, asked = (nearest(geometry, r, P0, d, 0.0, until) for r in (SLIDES, BRUTE))
        assert culled.t.tobytes() == asked.t.tobytes()
        assert np.isfinite(asked.t).any()
    assert len(drawn) == 2


def _shrunk(projection: Projection, length: Floats, depth: Floats) -> Floats:
    return np.full(length.shape, -0.01)


def test_a_drawing_that_is_too_small_would_be_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = _rng()
    scene = scene_with(FAMILIES["shared_edges"](rng))
    P0, d = _central(rng, _targets(rng, _triangles(scene), 3000))
    asked = nearest(Geometry.of(scene), BRUTE, P0, d, 0.0)
    monkeypatch.setattr(Projection, "seen_size", _shrunk)
    culled = nearest(Geometry.of(scene), SLIDES, P0, d, 0.0)
    assert (culled.triangle != asked.triangle).any()


def test_a_drawing_offers_few_pairs_and_hides_what_lies_behind() -> None:
    """Twenty layers of a fine grid, seen from the front: each pixel is offered the first few."""
    grid = np.linspace(-1, 1, 21)
    layers = [
        [(x, y, -k / 4), (x + 0.1, y, -k / 4), (x, y + 0.1, -k / 4)]
        for k in range(20)
        for x in grid[:-1]
        for y in grid[:-1]
    ]
    other = [
        [(x + 0.1, y, z), (x + 0.1, y + 0.1, z), (x, y + 0.1, z)] for (x, y, z), _, _ in layers
    ]
    scene = scene_with([triangle(v) for v in (*layers, *other)], eye=[0, 0, 3])
    P0, d = _screen(128, 128)
    triangles = Geometry.of(scene).triangles
    (index,) = SceneIndex.of(Geometry.of(scene)).kinds
    seen = grid_of(Rays.of(P0, d), 1e-11, index.tree.reach)
    assert seen is not None
    assert index.groups is not None
    drawing = Rasteriser.of(seen, index.groups)
    assert drawing is not None
    t_max = np.full(d.shape[1], np.inf)
    offered = 0
    for rays, which in drawing.pairs(t_max):
        offered += len(rays)
        depth = 3.0 - triangles.a[2, which]  # d's third component is −1
        np.minimum.at(t_max, rays, depth)
    first = nearest(Geometry.of(scene), SLIDES, P0, d, 0.0)
    assert offered < 4 * np.isfinite(first.t).sum()


def _screen(nx: int, ny: int) -> tuple[Floats, Floats]:
    """Rays from (0, 0, 3) through the pixels of a screen one unit ahead."""
    x, y = np.meshgrid((np.arange(nx) + 0.5) / nx - 0.5, (np.arange(ny) + 0.5) / ny - 0.5)
    d = np.stack((x.ravel(), y.ravel(), np.full(nx * ny, -1.0)))
    return np.array([[0.0], [0.0], [3.0]]), d


def _spread(P0: Floats, d: Floats) -> tuple[Floats, Floats]:
    return P0 + _rng().normal(size=d.shape), d


def _all_around(P0: Floats, d: Floats) -> tuple[Floats, Floats]:
    return P0, _rng().normal(size=d.shape)


def _few(P0: Floats, d: Floats) -> tuple[Floats, Floats]:
    return P0, d[:, :100]


def _without_a_direction(P0: Floats, d: Floats) -> tuple[Floats, Floats]:
    return P0, np.where(np.arange(d.shape[1]) == 7, np.nan, d)


@pytest.mark.parametrize(
    "change",
    [_spread, _all_around, _few, _without_a_direction],
)
def test_other_rays_have_no_picture(
    change: Callable[[Floats, Floats], tuple[Floats, Floats]],
) -> None:
    P0, d = _screen(64, 64)
    assert grid_of(Rays.of(P0, d), 1e-11, 5.0) is not None
    P0, d = change(P0, d)
    assert grid_of(Rays.of(P0, d), 1e-11, 5.0) is None


def test_rays_that_may_go_back_have_no_picture() -> None:
    P0, d = _screen(64, 64)
    assert grid_of(Rays.of(P0, d, -1.0), 1e-11, 5.0) is None


def test_rows_of_a_picture_are_those_of_the_screen() -> None:
    P0, d = _screen(64, 48)
    grid = grid_of(Rays.of(P0, d), 1e-11, 5.0)
    assert grid is not None
    first, count = grid.rows(np.array([-1.0]), np.array([1.0]))
    bottom, top = grid.band(np.arange(count[0]))
    assert (first[0], count[0]) == (0, 48)
    assert np.abs(bottom - top).max() < 1e-12
