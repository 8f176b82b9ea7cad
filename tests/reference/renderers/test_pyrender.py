"""pyrender through its child process: it agrees, a planted fault is seen, nothing leaks out."""

from __future__ import annotations

import ctypes
import importlib.util
import os
import pickle
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from converters.pyrender import LEAST_NEAR, PyrenderScene
from minirt.errors import MinirtError
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from minirt.vectors import Bools, Floats, Ints
from reference.compare.check import Check
from reference.jobs.isolate import Outcome, Workers
from reference.renderers.pyrender.draw import build, draw, object_color, object_numbers, start
from reference.renderers.pyrender.errors import declared
from reference.renderers.pyrender.source import PyrenderReference
from reference.source import Rendering, Unsupported
from reference.verify.rendering import render_to_file
from reference.verify.scene import compare_scene
from tests.helpers.tiers import tiered

PYRENDER = PyrenderReference()
GIVEN = {"hit", "object", "depth"}
SCREEN: dict[str, Any] = {
    "P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
    "l": -0.5, "r": 0.5, "b": -0.375, "t": 0.375, "nx": 96, "ny": 72,
}  # fmt: skip
#: A turned frame of determinant −1, ν > 0, off-axis, pixels that are not square.
LEFT = SCREEN | {
    "u": [-0.8, 0, 0.6], "n": [-0.6, 0, -0.8], "nu": 1.0, "P0": [3, 0, 4],
    "l": -0.3, "r": 0.7, "b": -0.5, "t": 0.25, "ny": 96,
}  # fmt: skip
#: A triangle, tilted, that no picture's edge cuts.
TILTED = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.9], [0.0, 1.0, -0.6]]


def scene(*objects: dict[str, Any], folder: Path = Path(), **changes: Any) -> Scene:
    document = {
        "minirt": 1, "name": "test", "screen": SCREEN, "light": {"direction": [-1, -2, -3]},
        "materials": {"red": {}}, "objects": [{"material": "red"} | o for o in objects],
    }  # fmt: skip
    return minirt.load_scene(document | changes, folder)


def ball(*center: float, radius: float = 1.0) -> dict[str, Any]:
    return {"type": "sphere", "center": list(center), "radius": radius}


def facet(*vertices: list[float]) -> dict[str, Any]:
    kind = "triangle" if len(vertices) == 3 else "polygon"
    return {"type": kind, "vertices": list(vertices)}


def floor(size: float = 4.0) -> dict[str, Any]:
    """It passes below the observer and beyond: cut by the near plane."""
    return facet([-size, -1, size + 5], [size, -1, size + 5], [size, -1, -size], [-size, -1, -size])


def confetti(count: int, seed: int) -> list[dict[str, Any]]:
    """Small triangles all over the view, at all angles and of either winding."""
    rng = np.random.default_rng(seed)
    centers = rng.uniform(-1.5, 1.5, (count, 1, 3)) * [1, 0.7, 1]
    return [facet(*t) for t in (centers + rng.normal(scale=0.3, size=(count, 3, 3))).tolist()]


def scenes(folder: Path) -> dict[str, Scene]:
    (folder / "mesh.obj").write_text(
        "v -1 -1 0\nv 1 -1 0\nv -1 1 0\nv 1 1 0.5\nf 1 2 3\nf 1 1 2\nf 3 2 4\n"
    )
    mesh = {"type": "mesh", "file": "mesh.obj"}
    angle = np.arange(64) * 2 * np.pi / 64
    wheel = facet(*np.stack((np.cos(angle), np.sin(angle), 0.2 * np.cos(angle)), 1).tolist())
    balls = ball(-0.8, 0, 0), ball(0.9, 0.3, 0.5, radius=0.6)
    return {
        "nothing at all": scene(),
        "degenerate alone": scene(facet(TILTED[0], TILTED[0], TILTED[1])),
        "behind": scene(ball(0, 0, 9), facet([0, 0, 6], [9, 0, 7], [0, 9, 8]), ball(0, 0, 0)),
        "left-handed": scene(*balls, floor(), facet(*TILTED), screen=LEFT),
        "right-handed": scene(*balls, floor(), facet(*TILTED)),
        "inside a sphere": scene(ball(0.3, 0, 5, radius=2.0), ball(0, 0, 4, radius=0.1)),
        "mesh": scene(mesh, floor(), folder=folder),
        "64 corners": scene(wheel, floor()),
        "two kilometres deep": scene(*balls, floor(), ball(600, 300, -1990, radius=400)),
        "huge": scene(ball(0, 0, -3e6, radius=3e6), screen=SCREEN | {"P0": [0, 0, 4e6]}),
        "confetti": scene(*confetti(60, seed=1)),
    }


NAMES = [
    "nothing at all", "degenerate alone", "behind", "left-handed", "right-handed",
    "inside a sphere", "mesh", "64 corners", "two kilometres deep", "huge", "confetti",
]  # fmt: skip
TRIANGLES_ONLY = {"mesh", "64 corners", "confetti"}


@pytest.fixture(scope="module")
def workers() -> Iterator[Workers]:
    with Workers(1) as pool:
        yield pool


def outcome_of(whole: Scene, workers: Workers) -> Outcome:
    return workers.submit(120, PYRENDER.render, whole, Path()).outcome()


def rendering_of(whole: Scene, workers: Workers) -> Rendering:
    outcome = outcome_of(whole, workers)
    assert outcome.state == "done", f"{outcome.reason}\n{outcome.output}"
    rendering: Rendering = outcome.value
    return rendering


def checks_of(whole: Scene, expected: Scene, workers: Workers, folder: Path) -> dict[str, Check]:
    """Another scene's answers judged by what minirt expects of this one."""
    outcome = workers.submit(120, render_to_file, PYRENDER, whole, folder).outcome()
    assert outcome.state == "done", f"{outcome.reason}\n{outcome.output}"
    verdict = compare_scene(expected, [(PYRENDER, outcome.value)])
    (found,) = verdict.references.values()
    return {check.quantity: check for check in found.checks}


def test_it_is_here_and_travels() -> None:
    assert PYRENDER.missing() is None
    assert pickle.loads(pickle.dumps(PYRENDER)) == PYRENDER  # noqa: S301 - our own bytes


@pytest.mark.parametrize("name", tiered(NAMES, lambda name: name in [*NAMES][::3]))
def test_it_agrees_with_minirt(name: str, workers: Workers, tmp_path: Path) -> None:
    whole = scenes(tmp_path)[name]
    checks = checks_of(whole, whole, workers, tmp_path)
    given = {q: c for q, c in checks.items() if c.state != "not supported"}
    assert [(c.quantity, c.reason, c.worst) for c in given.values() if c.state != "passed"] == []
    assert set(given) == GIVEN
    assert min(c.certain / c.pixels for c in given.values()) >= (
        0.995 if name in TRIANGLES_ONLY else 0.98
    )
    if name not in ("nothing at all", "degenerate alone"):
        assert checks["depth"].compared > 500
    assert all(checks[q].ssim is not None for q in ("hit", "depth"))


@pytest.mark.parametrize(
    ("quantity", "change"),
    [
        ("depth", ball(0, 0, 0.004)),  # nearer
        ("hit", ball(0.004, 0, 0)),  # a fifth of a pixel aside
        ("depth", ball(0, 0, 0, radius=1.004)),
    ],
)
def test_a_planted_fault_is_seen(
    quantity: str, change: dict[str, Any], workers: Workers, tmp_path: Path
) -> None:
    """What is declared is small enough to tell a ball that is 20 errors elsewhere."""
    whole = scene(ball(0, 0, 0), screen=SCREEN | {"nx": 256, "ny": 192})
    error = declared(PyrenderScene(whole))
    assert 20 * (error.delta + error.slope * 4 + error.grain * 4) < 0.004
    aside = scene(change, screen=SCREEN | {"nx": 256, "ny": 192})
    assert checks_of(aside, whole, workers, tmp_path)[quantity].wrong > 10


def test_faces_are_seen_from_either_side(workers: Workers) -> None:
    """pyrender's segmentation pass culls what turns its back, whatever its flags say."""
    a, b, c = TILTED
    front, back = (rendering_of(scene(facet(*f)), workers).frame for f in ((a, b, c), (a, c, b)))
    assert front["hit"].sum() > 700
    assert np.array_equal(front["hit"], back["hit"])
    np.testing.assert_allclose(front["depth"], back["depth"], rtol=1e-6)


def drawn_as(whole: Scene, numbers: list[int]) -> Ints:
    """The objects seen, had they been given other numbers. Runs in a child process."""
    view = PyrenderScene(whole)
    view.parts = tuple(replace(view.parts[k], object=n) for k, n in enumerate(numbers))
    return draw(view)[0]


def test_numbers_beyond_two_bytes_stay_right(workers: Workers) -> None:
    numbers = [0, 254, 255, 256, 65_534, 65_535, 65_536, 70_000, 2**24 - 2]
    whole = scene(*confetti(len(numbers), seed=2))
    outcome = workers.submit(60, drawn_as, whole, numbers).outcome()
    assert outcome.state == "done", outcome.output
    plain = rendering_of(whole, workers).frame["object"]
    assert set(np.unique(plain)) == {-1, *range(len(numbers))}
    np.testing.assert_array_equal(outcome.value, np.array([*numbers, -1])[plain])


def test_colours_are_numbers_in_three_bytes() -> None:
    numbers = np.array([[-1, 0, 254, 255, 65_534], [65_535, 70_000, 2**20, 2**24 - 3, 2**24 - 2]])
    colors = np.array([[object_color(k) for k in row] for row in numbers.tolist()])
    assert colors.min() >= 0
    assert colors.max() <= 255
    np.testing.assert_array_equal(object_numbers(colors.astype(np.uint8)), numbers)


def multisampled(whole: Scene) -> tuple[Bools, Floats]:
    """Hit and depth by pyrender's usual depth pass. Runs in a child process."""
    pyrender, size = start(), (whole.screen.nx, whole.screen.ny)
    view = PyrenderScene(whole)
    world, _ = build(pyrender, view)
    renderer = pyrender.OffscreenRenderer(*size)
    depth = renderer.render(world, pyrender.RenderFlags.DEPTH_ONLY) / view.scale
    renderer.delete()
    return depth > 0, depth.astype(np.float64)


def test_what_the_usual_multisampled_depth_pass_would_cost(workers: Workers) -> None:
    """Its depth is that of one sample, aside of the pixel's centre: several per cent of a small
    triangle's mask are wrong, and its depth by a part of its slope."""
    small = [[-0.36, -0.3, 3.0], [0.03, -0.27, 3.3], [-0.1, 0.2, 2.7]]
    whole = scene(facet(*small), screen=SCREEN | {"nx": 64, "ny": 48})
    ours = minirt.render(whole, quantities=["hit", "depth"])
    exact = rendering_of(whole, workers).frame
    outcome = workers.submit(60, multisampled, whole).outcome()
    assert outcome.state == "done", outcome.output
    hit, depth = outcome.value
    assert 80 < ours["hit"].sum() < 120
    assert (exact["hit"] != ours["hit"]).sum() == 0
    assert (hit != ours["hit"]).sum() > 0.03 * ours["hit"].sum()
    both = hit & ours["hit"]
    true = ours["depth"][both]
    assert true.size > 70
    off = np.abs(depth[both] - true).max()
    assert off > 1e-3
    assert off > 100 * np.abs(exact["depth"][both] - true).max()


@pytest.mark.parametrize(
    ("whole", "reason"),
    [
        (scene(facet([-9, -1e-5, 9], [9, -1e-5, 9], [0, -1e-5, -9])), "too near"),
        (scene(screen=SCREEN | {"nx": 16_385, "ny": 1}), "16,384 pixels"),
    ],
)
def test_what_does_not_fit_in_opengls_buffers_is_not_supported(
    whole: Scene, reason: str, workers: Workers
) -> None:
    outcome = outcome_of(whole, workers)
    assert isinstance(outcome.value, Unsupported), outcome.reason
    assert reason in str(outcome.value)


def test_conventions(workers: Workers) -> None:
    """Row 0 is the top, columns run to the right, a miss is minirt's miss."""
    whole = scene(ball(0, 1.2, 0, radius=0.5), ball(1.2, 0, 0, radius=0.5))
    rendering = rendering_of(whole, workers)
    top, right = (np.argwhere(rendering.frame["object"] == k).mean(axis=0) for k in (0, 1))
    assert top[0] < 20
    assert right[1] > 65
    miss = ~rendering.frame["hit"]
    assert (rendering.frame["object"][miss] == -1).all()
    assert np.isposinf(rendering.frame["depth"][miss]).all()
    assert set(rendering.unsupported) == set(QUANTITIES) - GIVEN
    assert rendering.program.startswith("pyrender ")


def test_opengl_stays_in_the_child(workers: Workers) -> None:
    rendering_of(scene(ball(0, 0, 0)), workers)
    assert "PYOPENGL_PLATFORM" not in os.environ
    assert not {"pyrender", "OpenGL"} & set(sys.modules)


def test_what_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_library(name: str) -> None:
        raise OSError(name)

    with monkeypatch.context() as patch:
        patch.setattr(ctypes, "CDLL", no_library)
        assert "apt-get install libegl1 libgl1-mesa-dri" in str(PYRENDER.missing())
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert "pip install 'minirt[pyrender]'" in str(PYRENDER.missing())


def test_no_driver_is_one_sentence_with_the_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    """libEGL alone draws nothing: the child that finds no driver says what brings one."""
    monkeypatch.setenv("__EGL_VENDOR_LIBRARY_DIRS", os.devnull)
    with Workers(1) as workers:
        outcome = outcome_of(scene(ball(0, 0, 0)), workers)
    assert isinstance(outcome.value, MinirtError), outcome.reason
    assert "OpenGL does not start" in str(outcome.value)
    assert "apt-get install libegl1 libgl1-mesa-dri" in str(outcome.value)


def test_what_is_declared_follows_the_scene() -> None:
    usual = PYRENDER.declare(scene(ball(0, 0, 0)))
    fine = PYRENDER.declare(scene(ball(0, 0, 0), screen=SCREEN | {"nx": 960, "ny": 720}))
    assert 5 < usual.slope / fine.slope < 11
    near = PYRENDER.declare(scene(ball(0, 0, 0), ball(0, 0, 4.95, radius=0.01)))
    assert near.grain > 30 * usual.grain
    assert usual.delta < 2.0**-24 * 20 * scene(ball(0, 0, 0)).extent
    assert "1/256 pixel" in usual.derivation
    touching = PyrenderScene(scene(ball(0, 0, 5, radius=1 + 1e-7)))
    assert declared(touching).delta > 1e-6
    assert touching.camera.znear > LEAST_NEAR * touching.camera.zfar
