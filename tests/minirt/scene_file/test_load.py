"""What is loaded has the format's defaults and can be written and read again."""

from __future__ import annotations

import json

import numpy as np
import pytest
from mpmath import mp

import minirt
from minirt.scene_file.atlas import atlas_names
from minirt.scene_file.look_at import half_angle_tangent
from tests.helpers.scene_documents import BASE, changed, look_at

ULP = 2.0**-52


@pytest.mark.parametrize("name", atlas_names())
def test_to_dict_is_read_back_as_the_same_scene(name: str) -> None:
    scene = minirt.load_scene(f"atlas:{name}")
    again = minirt.load_scene(scene.to_dict(), scene.folder)
    assert again.sha256 == scene.sha256
    assert again.canonical_json == scene.canonical_json
    assert json.loads(scene.canonical_json) == scene.to_dict()


@pytest.mark.parametrize("name", ["closed-mesh", "everything", "telephoto"])
def test_to_dict_renders_the_same_bytes(name: str) -> None:
    whole = minirt.load_scene(f"atlas:{name}")
    document = whole.to_dict()
    document["screen"] |= {"nx": 64, "ny": 48}
    scene = minirt.load_scene(document, whole.folder)
    again = minirt.load_scene(scene.to_dict(), scene.folder)
    quantities = ["object", "t", "normal", "color"]
    first, second = (minirt.render(s, quantities=quantities) for s in (scene, again))
    assert (first["object"] >= 0).any()
    for q in quantities:
        assert first[q].tobytes() == second[q].tobytes()


def test_an_integer_and_the_same_float_are_one_number() -> None:
    whole = minirt.load_scene(changed(("screen", "nu"), -1))
    assert whole.sha256 == minirt.load_scene(BASE).sha256


def test_a_change_changes_the_hash() -> None:
    larger = changed(("objects", 0, "radius"), 1.0 + ULP)
    assert minirt.load_scene(larger).sha256 != minirt.load_scene(BASE).sha256


def test_absent_keys_have_the_formats_defaults() -> None:
    scene = minirt.load_scene(BASE)
    assert scene.max_depth == 5
    assert scene.shadow_color is None
    assert scene.light_color == (1, 1, 1)
    # The box is that of the sphere and the square, (−1,−1,−1) to (1,1,1); P0 = (0,0,5) is farther
    # from its corner (1,1,−1), √(1 + 1 + 36), than its corners from each other, √12.
    assert scene.extent == pytest.approx(np.sqrt(38), rel=2 * ULP)
    assert scene.epsilon == pytest.approx(1e-6 * np.sqrt(38), rel=4 * ULP)
    assert [thing.name for thing in scene.objects] == ["sphere-0", "polygon-1", "triangle-2"]


def test_look_at_is_resolved_to_the_slides_screen() -> None:
    """n from target to eye, u = up × n, v = n × u, unit; ν = −1; t = tan(fov/2), r = t·nx/ny."""
    screen = minirt.load_scene(changed(("screen",), look_at())).screen
    eye, target = np.array([3, 2, 5.0]), np.array([0, 0.5, 0])
    n = (eye - target) / np.linalg.norm(eye - target)
    u = np.cross([0, 1, 0], n)
    u /= np.linalg.norm(u)
    for ours, expected in zip((screen.u, screen.v, screen.n), (u, np.cross(n, u), n), strict=True):
        assert ours == pytest.approx(expected, abs=4 * ULP)
    top = np.tan(np.radians(20))
    assert (screen.P0, screen.nu, screen.nx, screen.ny) == ((3, 2, 5), -1, 8, 4)
    assert [screen.l, screen.r, screen.b, screen.t] == pytest.approx(
        [-2 * top, 2 * top, -top, top], rel=4 * ULP
    )
    assert abs(np.dot(screen.u, screen.n)) <= 4 * ULP


@pytest.mark.parametrize("degrees", [1e-3, 1.0, 37.7, 90.0, 120.0, 179.0])
def test_half_angle_tangent_is_correct_to_an_ulp(degrees: float) -> None:
    with mp.workprec(200):
        exact = mp.tan(mp.mpf(degrees) * mp.pi / 360)
        assert abs(mp.mpf(half_angle_tangent(degrees)) / exact - 1) <= ULP / 2
