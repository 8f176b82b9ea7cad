"""Mitsuba's three routes: their conventions, their limits, and that their errors are as declared.

The atlas is compared in test_verify_atlas.py; here are the scenes that it has no place for.
"""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.scene import Scene
from reference.compare.check import Check
from reference.jobs.isolate import Outcome, Workers
from reference.renderers.mitsuba import llvm
from reference.renderers.mitsuba.cli import MitsubaCommand
from reference.renderers.mitsuba.source import MitsubaReference, unsupported_colors
from reference.source import Reference, Rendering, Unsupported
from reference.verify.rendering import render_to_file
from reference.verify.scene import compare_scene
from tests.helpers.tiers import tiered

LLVM, SCALAR, COMMAND = MitsubaReference(), MitsubaReference("mitsuba-scalar"), MitsubaCommand()
ROUTES = [LLVM, SCALAR, COMMAND]
SCREEN: dict[str, Any] = {
    "P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
    "l": -0.5, "r": 0.5, "b": -0.375, "t": 0.375, "nx": 64, "ny": 48,
}  # fmt: skip
MATERIALS: dict[str, dict[str, Any]] = {
    "red": {"diffuse": [0.8, 0.1, 0.3]},
    "mirror": {"reflectance": 1.0},
    "glass": {"ior": 1.5, "transmittance": 1.0},
    "thin": {"ior": 0.8, "transmittance": 1.0},
}
TRIANGLE = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.3], [0.0, 1.0, -0.2]]


def scene(*objects: dict[str, Any], folder: Path = Path(), **changes: Any) -> Scene:
    document = {
        "minirt": 1, "name": "test", "screen": SCREEN, "light": {"direction": [-1, -2, -3]},
        "materials": MATERIALS, "objects": list(objects),
    }  # fmt: skip
    return minirt.load_scene(document | changes, folder)


def ball(
    material: str, center: tuple[float, ...] = (0, 0, 0), radius: float = 1.0
) -> dict[str, Any]:
    return {"type": "sphere", "material": material, "center": list(center), "radius": radius}


def triangle(material: str, vertices: list[list[float]] = TRIANGLE) -> dict[str, Any]:
    return {"type": "triangle", "material": material, "vertices": vertices}


def floor(material: str) -> dict[str, Any]:
    corners = [[-4, -1, 4], [4, -1, 4], [4, -1, -4], [-4, -1, -4]]
    return {"type": "polygon", "material": material, "vertices": corners}


def wheel(corners: int) -> dict[str, Any]:
    angle = np.arange(corners) * 2 * np.pi / corners
    vertices = np.stack((np.cos(angle), np.sin(angle), 0.2 * np.cos(angle)), axis=1)
    return {"type": "polygon", "material": "mirror", "vertices": vertices.tolist()}


def left_handed() -> dict[str, Any]:
    """A turned frame of determinant −1, ν > 0, an off-axis screen."""
    c, s = np.cos(0.3), np.sin(0.3)
    return SCREEN | {
        "u": [-c, 0, s], "n": [-s, 0, -c], "nu": 1.0, "P0": [5 * s, 0, 5 * c],
        "l": -0.3, "r": 0.7, "b": -0.5, "t": 0.25,
    }  # fmt: skip


def scenes(folder: Path) -> dict[str, Scene]:
    """By name; the mesh among them has a face without an area."""
    (folder / "mesh.obj").write_text(
        "v -1 -1 0\nv 1 -1 0\nv -1 1 0\nv 1 1 0.5\nf 1 2 3\nf 1 1 2\nf 3 2 4\n"
    )
    mesh = {"type": "mesh", "material": "glass", "file": "mesh.obj"}
    mixed = ball("glass", (-0.8, 0, 0)), ball("mirror", (0.9, 0.3, 0.5), 0.6), floor("red")
    return {
        "nothing at all": scene(),
        "degenerate alone": scene(triangle("red", [TRIANGLE[0], TRIANGLE[0], TRIANGLE[1]])),
        "left-handed": scene(*mixed, triangle("red"), screen=left_handed()),
        "inside glass": scene(
            ball("glass", (0, 0, 5), 2.0), ball("thin", (0, 0, 2.2), 0.5), ball("red")
        ),
        "mesh": scene(mesh, floor("mirror"), folder=folder),
        "64 corners": scene(wheel(64), ball("thin", (0, 0, 2), 0.2)),
        "huge": scene(ball("glass", (0, 0, -3e6), 3e6), screen=SCREEN | {"P0": [0, 0, 4e6]}),
        "diffuse and mirrors": scene(ball("mirror", (-0.8, 0, 0)), floor("red"), wheel(5)),
    }


NAMES = [
    "nothing at all", "degenerate alone", "left-handed", "inside glass", "mesh", "64 corners",
    "huge", "diffuse and mirrors",
]  # fmt: skip


@pytest.fixture(scope="module")
def workers() -> Iterator[Workers]:
    with Workers(1) as pool:
        yield pool


def outcome_of(route: Reference, whole: Scene, workers: Workers, folder: Path) -> Outcome:
    return workers.submit(120, route.render, whole, folder).outcome()


def rendering_of(route: Reference, whole: Scene, workers: Workers, folder: Path) -> Rendering:
    outcome = outcome_of(route, whole, workers, folder)
    assert outcome.state == "done", f"{outcome.reason}\n{outcome.output}"
    rendering: Rendering = outcome.value
    return rendering


def checks_of(
    route: Reference, whole: Scene, expected: Scene, workers: Workers, folder: Path
) -> dict[str, Check]:
    """Another scene's answers judged by what minirt expects of this one."""
    outcome = workers.submit(120, render_to_file, route, whole, folder).outcome()
    assert outcome.state == "done", f"{outcome.reason}\n{outcome.output}"
    verdict = compare_scene(expected, [(route, outcome.value)])
    (found,) = verdict.references.values()
    return {check.quantity: check for check in found.checks}


@pytest.mark.parametrize("route", ROUTES, ids=lambda route: route.name)
def test_every_route_is_here_and_travels(route: Reference) -> None:
    """Both variants are compared in CI: one that is absent is a failure, not a skip."""
    assert route.missing() is None
    assert pickle.loads(pickle.dumps(route)) == route  # noqa: S301 - our own bytes


@pytest.mark.parametrize("name", tiered(NAMES, lambda name: name in [*NAMES][::3]))
@pytest.mark.parametrize("route", ROUTES, ids=lambda route: route.name)
def test_it_agrees_with_minirt(
    route: Reference, name: str, workers: Workers, tmp_path: Path
) -> None:
    whole = scenes(tmp_path)[name]
    checks = checks_of(route, whole, whole, workers, tmp_path)
    given = [
        check for check in checks.values() if check.state not in ("not supported", "not given")
    ]
    assert [(c.quantity, c.wrong, c.worst) for c in given if c.wrong] == []
    assert {c.state for c in checks.values()} <= {"passed", "failed", "not supported"}
    assert len(given) >= (8 if route is COMMAND else 18)
    if name not in ("nothing at all", "degenerate alone"):
        assert checks["hit"].certain > 0.95 * checks["hit"].pixels
        assert minirt.render(whole)["hit"].sum() > 300


@pytest.mark.parametrize("route", ROUTES, ids=lambda route: route.name)
def test_a_ball_twenty_times_the_error_aside_is_seen(
    route: Reference, workers: Workers, tmp_path: Path
) -> None:
    """The planted fault: what is declared is small enough to see a shift of 20·δ."""
    whole = scene(ball("mirror"))
    aside = scene(ball("mirror", (0, 0, 20 * route.declare(whole).delta)))
    checks = checks_of(route, aside, whole, workers, tmp_path)
    wrong = {check.quantity for check in checks.values() if check.wrong}
    assert wrong >= {"t", "depth", "distance", "position"}


@pytest.mark.parametrize("route", [LLVM, SCALAR], ids=lambda route: route.name)
@pytest.mark.parametrize("max_depth", tiered([0, 1, 2, 5], lambda depth: depth == 2))
def test_colours_of_a_chain_of_mirrors(
    route: Reference, max_depth: int, workers: Workers, tmp_path: Path
) -> None:
    walls = [
        wheel(4),
        triangle("red", [[-2, -2, 3], [2, -2, 3], [0, 2, 3]]),
        ball("red", (0.4, 0, 1), 0.2),
    ]
    whole = scene(
        *walls, ball("mirror", (-0.7, 0, 1.2), 0.5),
        max_depth=max_depth, light={"direction": [-1, -2, -3], "color": [2, 1, 0.5]},
        screen=SCREEN | {"P0": [0, 0, 2.9]},
    )  # fmt: skip
    checks = checks_of(route, whole, whole, workers, tmp_path)
    assert checks["color"].wrong == 0, checks["color"].worst
    assert checks["color"].certain > 0.9 * checks["color"].pixels


def test_a_wrong_depth_of_mirrors_is_seen(workers: Workers, tmp_path: Path) -> None:
    """A lit ball behind the observer, seen in the tilted mirror only."""
    mirrored, light = (wheel(5), ball("red", (-2.7, 0, 6.5))), {"direction": [0.6, 0, 1]}
    deep, flat = (scene(*mirrored, max_depth=depth, light=light) for depth in (5, 0))
    assert minirt.render(deep)["color"].max() > 0.1
    assert checks_of(LLVM, deep, flat, workers, tmp_path)["color"].wrong > 50


@pytest.mark.parametrize(
    ("changes", "objects", "reasons"),
    [
        ({"background": [0.1, 0, 0]}, [ball("red")], ["background"]),
        ({"shadow_color": [0.1, 0, 0]}, [ball("red")], ["shadows"]),
        ({}, [ball("thin"), ball("red"), ball("glass")], ["'glass', 'thin'"]),
        (
            {"background": [0, 0, 1], "shadow_color": [0, 1, 0]}, [ball("glass")],
            ["background", "shadows", "'glass'"],
        ),
        ({}, [ball("red"), ball("mirror")], []),
        ({"shadow_color": [0, 0, 0]}, [floor("red")], []),
    ],
)  # fmt: skip
def test_colours_are_given_where_they_are_the_slides_own(
    changes: dict[str, Any], objects: list[dict[str, Any]], reasons: list[str]
) -> None:
    faults = unsupported_colors(scene(*objects, **changes))
    assert len(faults) == len(reasons)
    assert all(reason in fault for reason, fault in zip(reasons, faults, strict=True))


@pytest.mark.parametrize("route", ROUTES, ids=lambda route: route.name)
def test_pixels_that_are_not_square_are_not_supported(
    route: Reference, workers: Workers, tmp_path: Path
) -> None:
    outcome = outcome_of(route, scene(ball("red"), screen=SCREEN | {"ny": 40}), workers, tmp_path)
    assert outcome.state == "raised"
    assert isinstance(outcome.value, Unsupported)
    assert "square" in str(outcome.value)


@pytest.mark.parametrize("route", ROUTES, ids=lambda route: route.name)
def test_conventions(route: Reference, workers: Workers, tmp_path: Path) -> None:
    """Row 0 is the top; a normal follows its vertices' winding, whoever looks."""
    above = ball("red", (0, 1.2, 0), 0.5)
    behind = triangle("red", [[1, -1.5, 0], [-1, -1.5, 0], [0, -0.5, 0]])  # seen from behind
    frame = rendering_of(route, scene(above, behind), workers, tmp_path).frame
    rows = {k: np.nonzero((frame["object"] == k).any(axis=1))[0] for k in (0, 1)}
    assert rows[0].size > 3
    assert rows[0].max() < rows[1].min()
    seen = frame["normal"][frame["object"] == 1]
    np.testing.assert_array_equal(seen, np.broadcast_to([0.0, 0.0, -1.0], seen.shape))
    assert (frame["triangle"][frame["object"] == 0] == 0).all()
    assert np.isinf(frame["t"][~frame["hit"]]).all()


@pytest.mark.parametrize("route", [LLVM, SCALAR], ids=lambda route: route.name)
@pytest.mark.parametrize("width", [0.05, 1.0, 8.0])
def test_camera_rays_err_by_less_than_declared(
    route: Reference, width: float, workers: Workers, tmp_path: Path
) -> None:
    bounds = {"l": -width, "r": width, "b": -0.75 * width, "t": 0.75 * width}
    whole = scene(ball("red"), screen=left_handed() | bounds)
    theirs = rendering_of(route, whole, workers, tmp_path).frame["ray"]
    error = np.sqrt(((minirt.render(whole)["ray"] - theirs) ** 2).sum(axis=2)).max()
    assert 0 < error <= route.declare(whole).angle


def test_what_is_declared_follows_the_scene() -> None:
    whole = scene(ball("red"))
    usual, wide = declared_by(whole), declared_by(scene(ball("red"), screen=SCREEN | {"nu": -0.1}))
    assert usual.delta < 2.0**-24 * 20 * whole.extent
    assert wide.angle > usual.angle
    far = scene(ball("red", (1e5, 0, 0)), screen=SCREEN | {"P0": [1e5, 0, 5]})
    assert declared_by(far).delta < 2 * usual.delta  # a placement saves the digits
    assert "3·√3·u·R" in usual.derivation


def declared_by(whole: Scene) -> Any:
    assert LLVM.declare(whole) == COMMAND.declare(whole)
    return LLVM.declare(whole)


def test_llvm_chosen_by_the_user_is_taken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    chosen = tmp_path / "libLLVM-19.so"
    chosen.write_bytes(b"")
    monkeypatch.setenv(llvm.VARIABLE, str(chosen))
    assert llvm.find_llvm() == chosen
    chosen.unlink()
    assert llvm.find_llvm() is None
    assert "karellen-llvm-core" in str(LLVM.missing())


def test_llvm_must_be_new_enough(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(llvm.VARIABLE, raising=False)
    monkeypatch.setattr("sys.prefix", str(tmp_path))
    monkeypatch.setattr(llvm, "_FOLDERS", ())
    (tmp_path / "lib").mkdir()
    for name in ("libLLVM-14.so.1", "libLLVM-15.so.1", "libLLVM.so"):
        (tmp_path / "lib" / name).write_bytes(b"")
    assert llvm.find_llvm() is None
    for name in ("libLLVM.so.18.1", "libLLVM-19.so.1"):
        (tmp_path / "lib" / name).write_bytes(b"")
        found = llvm.find_llvm()
        assert found is not None
        assert found.name == name


def loaded_llvm() -> set[str]:
    """Files of LLVM that this process has loaded."""
    lines = Path("/proc/self/maps").read_text(encoding="utf-8").splitlines()
    return {line.split()[-1] for line in lines if "libLLVM" in line}


def test_llvm_is_the_suitable_one_after_a_variant_that_needs_none(tmp_path: Path) -> None:
    """drjit loads a library with the first variant and keeps it: it must not be an older one."""
    with Workers(1) as pool:
        for route in (SCALAR, LLVM):
            rendering_of(route, scene(ball("glass")), pool, tmp_path)
        assert pool.submit(60, loaded_llvm).outcome().value == {str(llvm.find_llvm())}
