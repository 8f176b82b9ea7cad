"""POV-Ray as a reference: scenes that the atlas has no place for, and how it is started.

The atlas is compared in test_verify_atlas.py.
"""

from __future__ import annotations

import os
import pickle
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from converters.povray.media import transparent_bodies
from converters.povray.shapes import povray_placement
from minirt.errors import ReferenceError
from minirt.quantities import QUANTITIES
from minirt.scene import Facets, Scene
from reference.compare.check import Check
from reference.compare.comparison import compare
from reference.compare.stability import measure
from reference.renderers.povray import run as povray_run
from reference.renderers.povray import source as povray
from reference.renderers.povray.errors import coarse_color, exposure_of
from reference.renderers.povray.media_lists import media_fault
from reference.renderers.povray.passes import Grid, read_normal, read_what
from reference.renderers.povray.source import PovrayReference
from reference.source import Declared, Rendering
from tests.helpers.tiers import tiered

POVRAY = PovrayReference()
GIVEN = {
    "hit", "object", "triangle", "t", "depth", "distance", "position", "normal", "shadow", "color",
}  # fmt: skip
SCREEN: dict[str, Any] = {
    "P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
    "l": -0.5, "r": 0.5, "b": -0.375, "t": 0.375, "nx": 64, "ny": 48,
}  # fmt: skip
MATERIALS: dict[str, dict[str, Any]] = {
    "red": {"diffuse": [0.8, 0.1, 0.3], "ambient": [0.1, 0.05, 0.2]},
    "tinted": {"diffuse": [0.3, 0.3, 0], "specular": [0.7, 0.2, 0], "shininess": 9},
    "mirror": {"reflectance": 1.0},
    "glass": {"ior": 1.5, "transmittance": 0.7, "reflectance": 0.1, "specular": [0.5, 0.4, 0.3],
              "diffuse": [0, 0.5, 0.2], "ambient": [0.1, 0.1, 0], "shininess": 30},
    "air": {"ior": 1 / 1.5, "transmittance": 1.0},
    "nothing": {"ior": 1.0, "transmittance": 0.5},
}  # fmt: skip


def scene(*objects: dict[str, Any], folder: Path = Path(), **changes: Any) -> Scene:
    document = {
        "minirt": 1, "name": "test", "screen": SCREEN, "background": [0.2, 0.3, 0.4],
        "light": {"direction": [-1, -2, -3], "color": [0.9, 0.8, 1.0]},
        "materials": MATERIALS, "objects": list(objects),
    }  # fmt: skip
    return minirt.load_scene(document | changes, folder)


def ball(material: str, center: Any = (0, 0, 0), radius: float = 1.0) -> dict[str, Any]:
    return {"type": "sphere", "material": material, "center": list(center), "radius": radius}


def floor(material: str) -> dict[str, Any]:
    corners = [[-4, -1.2, 4], [4, -1.2, 4], [4, -1.2, -4], [-4, -1.2, -4]]
    return {"type": "polygon", "material": material, "vertices": corners}


def roof() -> dict[str, Any]:
    return {"type": "triangle", "material": "red", "vertices": [[-2, 2, 0], [3, 2, 2], [3, 2, -2]]}


def compared(loaded: Scene, folder: Path) -> tuple[dict[str, Check], Rendering]:
    folder.mkdir(exist_ok=True)
    rendering = POVRAY.render(loaded, folder)
    ours, stability = measure(loaded, POVRAY.declare(loaded), tuple(rendering.frame))
    checks = compare(loaded, ours, stability, rendering.frame, rendering.unsupported).checks
    return {check.quantity: check for check in checks}, rendering


def all_pass(loaded: Scene, folder: Path, given: set[str] = GIVEN) -> dict[str, Check]:
    """Every quantity given is compared at nearly every pixel and right; nothing else is given."""
    checks, rendering = compared(loaded, folder)
    assert set(rendering.frame) == given
    assert set(rendering.unsupported) == set(QUANTITIES) - given
    assert [c for c in checks.values() if c.quantity in given and c.state != "passed"] == []
    assert min(checks[name].certain for name in given) >= 0.998 * 64 * 48
    return checks


# scenes


def torus(folder: Path) -> dict[str, Any]:
    import trimesh

    mesh = trimesh.creation.torus(0.8, 0.35, major_sections=24, minor_sections=12)
    mesh.export(folder / "torus.ply")
    turned = [[1, 0, 0, 0], [0, 0.6, -0.8, 0], [0, 0.8, 0.6, 0], [0, 0, 0, 1]]
    return {"type": "mesh", "material": "tinted", "file": "torus.ply", "transform": turned}


SCENES: dict[str, Callable[[Path], Scene]] = {
    "coloured shadow": lambda _: scene(
        ball("tinted"), floor("red"), roof(), shadow_color=[0.3, 0.01, 0.1]
    ),
    "bright light": lambda _: scene(
        ball("tinted"), floor("mirror"), light={"direction": [0, -1, -1], "color": [7, 5, 0]}
    ),
    "glass with all terms": lambda _: scene(ball("glass"), floor("red"), roof(), max_depth=6),
    "no reflected rays": lambda _: scene(ball("glass"), floor("mirror"), max_depth=0),
    "two spheres around the observer": lambda _: scene(
        ball("air", (0, 0, 5), 0.5), ball("glass", (0, 0, 5), 2), ball("red"), floor("tinted")
    ),
    "opaque sphere around the observer": lambda _: scene(
        ball("red", (0, 0, 0), 20), ball("glass"), ball("air", (0, 0, 0), 0.5)
    ),
    "mesh": lambda folder: scene(torus(folder), floor("mirror"), folder=folder),
    "specks": lambda _: scene(
        *(ball("tinted", (0.3 * k - 1.5, 0.2 * k - 1, 0), 10.0**-k) for k in range(1, 5)),
        floor("red"),
    ),
    "nothing there": lambda _: scene(),
}  # fmt: skip


#: The scenes of the fast tier.
FEW = [*SCENES][::3]


@pytest.mark.parametrize("name", tiered(SCENES, lambda name: name in FEW))
def test_every_quantity_agrees(name: str, tmp_path: Path) -> None:
    loaded = SCENES[name](tmp_path)
    checks = all_pass(loaded, tmp_path / "scratch")
    if loaded.objects:
        assert all(checks[q].compared > 300 for q in ("hit", "t", "normal", "color"))
        assert len({float(x) for x in minirt.render(loaded)["color"].reshape(-1)}) > 10


@pytest.mark.full
@pytest.mark.parametrize("size", [1e-7, 1e6])
def test_any_size_agrees(size: float, tmp_path: Path) -> None:
    screen = SCREEN | {"P0": [0, 0, 5 * size]}
    small = ball("glass", (0, 0.2 * size, 0), 0.6 * size)
    table = {**floor("mirror"), "vertices": (size * np.array(floor("red")["vertices"])).tolist()}
    checks = all_pass(scene(small, table, screen=screen), tmp_path)
    assert checks["t"].compared > 300


# planted faults


@pytest.mark.parametrize(
    ("said", "instead", "wrong"),
    tiered(
        [
            ("phong_size 9", "phong_size 8", {"color"}),
            ("max_trace_level 6", "max_trace_level 2", {"color"}),
            ("no_shadow", "", {"color"}),
            ("what nobody says", "", set()),
            ("brilliance 0", "brilliance 1", {"shadow"}),
            ("location <0.0, 0.0,", "location <0.0, 2.0,", GIVEN),
        ],
        lambda case: case[0] in ("phong_size 9", "what nobody says", "brilliance 0"),
    ),
)
def test_a_planted_fault_is_found(
    said: str, instead: str, wrong: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loaded = scene(ball("glass"), ball("tinted", (1.2, 0, 0)), floor("mirror"), roof())
    changed: list[str] = []

    def planted(pictures: dict[str, str], *rest: Any) -> Any:
        texts = {name: text.replace(said, instead) for name, text in pictures.items()}
        changed.extend(name for name in texts if texts[name] != pictures[name])
        return povray_run.render_pictures(texts, *rest)

    monkeypatch.setattr(povray, "render_pictures", planted)
    checks, _ = compared(loaded, tmp_path)
    assert {name for name, check in checks.items() if check.state == "failed"} >= wrong
    assert bool(changed) == bool(wrong)


# what is not supported


@pytest.mark.parametrize(
    ("objects", "reason"),
    [
        ((ball("glass"), ball("glass", (0.9, 0, 0))), "disagree"),
        ((ball("nothing"),), "index 1"),
        ((ball("blue"),), "lacks a channel"),
    ],
)
def test_colours_that_it_cannot_give_are_refused_with_the_reason(
    objects: tuple[dict[str, Any], ...], reason: str, tmp_path: Path
) -> None:
    blue = {"ior": 1.5, "transmittance": 0.5, "specular": [0, 0, 1.0]}
    loaded = scene(*objects, floor("red"), materials=MATERIALS | {"blue": blue})
    checks = all_pass(loaded, tmp_path, GIVEN - {"color"})
    assert checks["color"].state == "not supported"
    assert reason in checks["color"].reason


def test_colours_far_beyond_white_are_not_judged_by_steps_that_hide_the_dark_ones(
    tmp_path: Path,
) -> None:
    lamp = {"direction": [0, -1, -1], "color": [300.0] * 3}
    bright = scene(ball("red"), floor("red"), light=lamp)
    checks = all_pass(bright, tmp_path, GIVEN - {"color"})
    assert checks["color"].state == "not supported"
    assert "between POV-Ray's codes" in checks["color"].reason
    assert coarse_color(scene(ball("red"), floor("red"))) is None


@pytest.mark.parametrize("name", ["nested-glass", "glass-slab", "inside-glass", "snells-window"])
def test_the_list_of_media_is_followed(name: str) -> None:
    loaded = minirt.load_scene(f"atlas:{name}")
    bodies = transparent_bodies(loaded)
    assert media_fault(loaded, bodies) is None
    off = (replace(bodies[0], index=1.01 * bodies[0].index), *bodies[1:])
    assert "disagree" in str(media_fault(loaded, off))


# codes


def test_numbers_beyond_16_bits_and_both_sides_are_read() -> None:
    loaded = scene(ball("red"), floor("red"), roof())
    vertices, faces = np.zeros((3, 3)), np.zeros((70_000, 3), dtype=np.int32)
    many = Facets("mesh", "many", "red", vertices, faces)
    loaded = replace(loaded, objects=(loaded.objects[0], many, loaded.objects[2]))
    number = np.array([0, 1, 65_537, 70_000, 70_001]) + 1
    blue = np.array([1, 2, 2**14 + 1, 2**14 + 2, 1])
    codes = np.stack([number % 2**16, number // 2**16, blue], axis=1).astype(np.int32)
    codes = np.concatenate([codes, np.zeros((1, 3), dtype=np.int32)])
    thing, face, outside, lit = read_what(loaded, codes)
    assert thing.tolist() == [0, 1, 1, 1, 2, -1]
    assert face.tolist() == [0, 0, 65_536, 69_999, 0, -1]
    assert outside.tolist()[:5] == [True, False, True, False, True]
    assert lit.tolist() == [False, False, True, True, False, False]


def test_positions_and_normals_are_read_within_half_a_step() -> None:
    loaded = scene(ball("red"), floor("red"))
    grid = Grid.of(loaded, povray_placement(loaded))
    points = grid.low + grid.span * np.random.default_rng(3).random((500, 3))
    steps = np.floor((points - grid.low) / grid.step).astype(np.int64)
    assert steps.min() >= 0
    assert steps.max() < 2**30
    found = grid.position(*(part.astype(np.int32) for part in (steps // 2**15, steps % 2**15)))
    assert np.abs(found - points).max() <= grid.step / 2 * (1 + 1e-3)
    codes = np.array([[65535, 32767, 0]] * 2, dtype=np.int32)
    normals = read_normal(codes, np.array([True, False]))
    assert np.abs(normals - [[1, 0, -1], [-1, 0, 1]]).max() <= 1 / 65535


# how it errs


def test_the_steps_of_the_format_are_in_the_tolerance() -> None:
    loaded = minirt.load_scene("atlas:one-sphere")
    plain = Declared(0.0, 0.0, 0.0, 0.0, None, "exact")
    stepped = replace(plain, steps=(("t", 0.5), ("position", 0.25), ("color", 0.125)))
    names = ("t", "distance", "position", "color")
    ours, exact = measure(loaded, plain, names)
    _, coarse = measure(loaded, stepped, names)
    added = {name: coarse.tolerance[name] - exact.tolerance[name] for name in names}
    hit = ours["hit"]
    assert hit.sum() > 1000
    assert np.allclose(added["t"][hit], 0.5 * ours["t"][hit] / ours["distance"][hit])
    assert [float(added[name].max()) for name in names[1:]] == [0.0, 0.25, 0.125]


def test_a_ray_through_an_edge_is_uncertain_where_facets_may_leave_a_gap() -> None:
    loaded = minirt.load_scene("atlas:fan-of-triangles")
    declared = POVRAY.declare(loaded)
    assert not declared.watertight
    certain = {
        tight: measure(loaded, replace(declared, watertight=tight), ["hit", "triangle"])[1].certain
        for tight in (True, False)
    }
    assert certain[True]["hit"].sum() > certain[False]["hit"].sum()
    assert (certain[False]["hit"] == certain[False]["triangle"]).all()


@pytest.mark.parametrize(("light", "factor"), [(0.2, 4.0), (1.0, 0.5), (9.0, 2.0**-4)])
def test_the_exposure_fits_the_file(light: float, factor: float) -> None:
    lamp = {"direction": [0, -1, 0], "color": [light] * 3}
    plain = {"red": {"diffuse": [1.0, 1.0, 1.0]}}
    loaded = scene(ball("red"), light=lamp, materials=plain, background=[0, 0, 0])
    assert exposure_of(loaded) == factor
    assert exposure_of(scene(background=[0, 0, 0])) == 1


# the program


def fake(folder: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    program = folder / "bin" / "povray"
    program.parent.mkdir()
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")


def test_a_missing_program_is_said_with_the_command_that_brings_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert POVRAY.missing() is None
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "apt-get install povray" in str(POVRAY.missing())


def test_a_failure_shows_what_the_program_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake(tmp_path, monkeypatch, "echo 'Parse Error: no sun' >&2; exit 3")
    with pytest.raises(ReferenceError, match=r"status 3.*no sun"):
        POVRAY.render(scene(ball("red")), tmp_path)


def test_an_image_of_nothing_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(tmp_path, monkeypatch, "exit 0")
    with pytest.raises(ReferenceError, match="cannot be used"):
        POVRAY.render(scene(ball("red")), tmp_path)


def test_a_program_that_hangs_is_ended_with_its_children(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake(tmp_path, monkeypatch, f"sleep 60 & echo $! >> {tmp_path}/children; wait")
    monkeypatch.setattr(povray_run, "TIMEOUT", 3.0)
    begin = time.monotonic()
    with pytest.raises(ReferenceError, match=r"more than 3 s"):
        POVRAY.render(scene(ball("red")), tmp_path)
    assert time.monotonic() - begin < 20
    children = (tmp_path / "children").read_text().split()
    assert len(children) == 5
    time.sleep(0.2)
    assert [child for child in children if _running(Path("/proc") / child)] == []


def _running(process: Path) -> bool:
    """Whether a process is there and not merely waiting to be buried."""
    try:
        return ") Z" not in (process / "stat").read_text()
    except OSError:
        return False


def test_it_can_be_handed_to_a_child_process() -> None:
    assert pickle.loads(pickle.dumps(POVRAY)) == POVRAY  # noqa: S301
    assert "POV-Ray 3.7" in povray_run.povray_version()
