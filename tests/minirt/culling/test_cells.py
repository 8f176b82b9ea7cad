"""Cells of pixels: those that can show nothing are left out, and no other."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.culling import squares
from minirt.culling.image_cells import CELL
from minirt.rules import SLIDES
from minirt.screen import pixel_center
from tests.helpers.culling_scenes import BRUTE, FAMILIES, scene_with, sphere, triangle

#: Everything that does not ask for each pixel's own ray.
SEEN = [name for name in minirt.QUANTITIES if name != "ray"]


def _turned(rng: np.random.Generator) -> list[list[float]]:
    """Three orthonormal axes, of either handedness."""
    axes: list[list[float]] = np.linalg.qr(rng.normal(size=(3, 3)))[0].T.tolist()
    return axes


def _screen(rng: np.random.Generator, kind: str, nx: int, ny: int) -> dict[str, Any]:
    u, v, n = _turned(rng)
    left, bottom = rng.uniform(-0.1, 0, 2).tolist()
    wide, high = rng.uniform(0.05, 0.2, 2).tolist()  # cells are narrow: bounds have little slack
    nu = float(rng.uniform(0.3, 3)) * (-1) ** int(rng.integers(2))
    if kind == "aside":  # the pixels are small beside the screen's own numbers
        left, bottom, nu = left + 3e6, bottom - 1e6, nu * 1e5
    eye = rng.uniform(-5, 5, 3)
    if kind == "tiny":
        left, bottom, wide, high, nu, eye = (1e-9 * x for x in (left, bottom, wide, high, nu, eye))
    return {"P0": eye.tolist(), "u": u, "v": v, "n": n, "nu": nu,
            "l": left, "r": left + wide, "b": bottom, "t": bottom + high,
            "nx": nx, "ny": ny}  # fmt: skip


def _specks(
    rng: np.random.Generator, screen: dict[str, Any], pixels: list[tuple[int, int]], kind: str
) -> list[dict[str, Any]]:
    """Of each of some pixels (row, column) a thing around its ray, a millionth of a pixel wide."""
    objects: list[dict[str, Any]] = []
    u, v, n = (np.array(screen[axis]) for axis in "uvn")
    for row, column in pixels:
        u_s = screen["l"] + (screen["r"] - screen["l"]) / screen["nx"] * (column + 0.5)
        v_s = screen["b"] + (screen["t"] - screen["b"]) / screen["ny"] * (screen["ny"] - row - 0.5)
        t = rng.uniform(0.5, 20)
        at = np.array(screen["P0"]) + t * (u * u_s + v * v_s + n * screen["nu"])
        size = 1e-6 * t * (screen["r"] - screen["l"]) / screen["nx"]
        if kind == "aside":
            size *= 1e4
        if len(objects) % 3 == 0:
            objects.append(sphere(at, size))
        else:
            corners = at + size * np.array([3 * u, 3 * v, -3 * (u + v)])
            objects.append(triangle(corners))
            if len(objects) % 3 == 0:
                objects[-1]["type"] = "polygon"
    return objects


def _at_the_edges(nx: int, ny: int) -> list[tuple[int, int]]:
    """The corners of the first cells, of some in the middle, and of the last."""
    ends = [(0, 7), (16, 23)]
    rows = [*ends, (ny - ny % CELL if ny % CELL else ny - CELL, ny - 1)]
    columns = [*ends, (nx - nx % CELL if nx % CELL else nx - CELL, nx - 1)]
    return [(row, column) for r in rows for c in columns for row in r for column in c]


@pytest.mark.parametrize("size", [(48, 40), (45, 37), (41, 33)])
@pytest.mark.parametrize("kind", ["plain", "aside", "tiny"])
def test_a_speck_in_the_outermost_pixel_of_a_cell_is_seen(kind: str, size: tuple[int, int]) -> None:
    rng = np.random.default_rng(70)
    pixels = sorted(set(_at_the_edges(*size)))
    seen = 0
    for some in np.array_split(rng.permutation(len(pixels)), 4):
        screen = _screen(rng, kind, *size)
        chosen = [pixels[k] for k in some]
        scene = scene_with(_specks(rng, screen, chosen, kind), **screen)
        culled, asked = (minirt.render(scene, rules, SEEN) for rules in (SLIDES, BRUTE))
        for name in SEEN:
            assert culled[name].tobytes() == asked[name].tobytes(), name
        seen += int(asked["hit"].sum())
    assert seen > 0.9 * len(pixels)


@pytest.mark.parametrize("family", FAMILIES)
def test_few_objects_on_much_background_are_the_same(family: str) -> None:
    rng = np.random.default_rng(71)
    objects = FAMILIES[family](rng)
    few = [objects[k] for k in rng.permutation(len(objects))[:8]]
    seen = 0
    for eye in ((0.3, 0.4, 14.0), (0.1, -0.2, 3.0), (0.0, 0.0, 0.1)):
        scene = scene_with(few, eye=eye, nx=67, ny=50)
        culled, asked = (minirt.render(scene, rules, SEEN) for rules in (SLIDES, BRUTE))
        for name in SEEN:
            assert culled[name].tobytes() == asked[name].tobytes(), name
        seen += int(asked["hit"].sum())
    assert seen > 50


@pytest.fixture
def traced(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many pixels were traced together, call by call."""
    module, counts = sys.modules["minirt.render"], []
    honest = module.trace_pixels

    def counted(whitted: Any, pixels: Any, wanted: Any) -> Any:
        counts.append(len(pixels))
        return honest(whitted, pixels, wanted)

    monkeypatch.setattr(module, "trace_pixels", counted)
    return counts


def test_only_cells_that_may_show_something_are_traced(traced: list[int]) -> None:
    """A ball of a few pixels: no more than its cells and those that it may just not reach."""
    scene = scene_with([sphere((0, 0, 0), 0.3)], nx=200, ny=160)
    frame = minirt.render(scene, quantities="hit,depth,color")
    cells = frame["hit"].reshape(20, CELL, 25, CELL).any(axis=(1, 3)).sum()
    assert 0 < cells * CELL * CELL <= sum(traced) <= 1.5 * cells * CELL * CELL
    assert (frame["color"][~frame["hit"]] == scene.background).all()


@pytest.mark.parametrize("replaced", ["pixel_center", "sphere"])
def test_a_replaced_rule_is_asked_about_every_pixel(traced: list[int], replaced: str) -> None:
    scene = scene_with([sphere((0, 0, 0), 0.3)], nx=64, ny=48)
    own = getattr(SLIDES, replaced)
    rules = SLIDES.replace(**{replaced: lambda *arguments: own(*arguments)})
    minirt.render(scene, rules, "hit")
    assert sum(traced) == 64 * 48


def test_a_pixel_moved_by_a_rule_is_seen_where_it_went() -> None:
    """Replaced, the rule shows the ball where no cell of the slide's own could."""
    scene = scene_with([sphere((0, 0, 0), 0.3)], nx=64, ny=48)
    moved = SLIDES.replace(pixel_center=lambda screen, i, j: pixel_center(screen, i + 20.0, j))
    hits = [minirt.render(scene, rules, "hit")["hit"] for rules in (SLIDES, moved)]
    assert np.array_equal(np.flatnonzero(hits[0]), np.flatnonzero(hits[1]) + 20)
    assert hits[0].any()


def test_rays_are_given_at_every_pixel(traced: list[int]) -> None:
    frame = minirt.render(scene_with([sphere((0, 0, 0), 0.3)], nx=50, ny=30), quantities="ray,hit")
    assert sum(traced) == 50 * 30
    assert np.isfinite(frame["ray"]).all()


@pytest.mark.parametrize("center", [(0, 0, 0), (0, 0, 50)])
def test_progress_counts_what_is_left_out(center: tuple[float, ...]) -> None:
    told: list[tuple[int, int]] = []
    scene = scene_with([sphere(center, 0.3)], nx=700, ny=900)
    frame = minirt.render(scene, quantities="hit", progress=lambda *of: told.append(of))
    assert frame["hit"].any() == (center[2] == 0)
    assert told == sorted(told)
    assert len(told) > 1
    assert told[-1] == (700 * 900, 700 * 900)


@pytest.mark.parametrize("size", [(1, 1), (7, 3), (64, 48), (300, 270), (261, 13)])
def test_squares_hold_each_pixel_once_and_cell_by_cell(size: tuple[int, int]) -> None:
    nx, ny = size
    pixels = np.concatenate(list(squares(nx, ny)))
    assert np.array_equal(np.sort(pixels), np.arange(nx * ny))
    cell = (pixels // nx // CELL) * (nx // CELL + 1) + pixels % nx // CELL
    changes = int((np.diff(cell) != 0).sum())
    assert changes + 1 == -(-nx // CELL) * -(-ny // CELL)
