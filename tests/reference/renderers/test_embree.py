"""Embree: its conventions, its errors as declared, its stand-in, and formulas of its own.

The atlas is compared in test_verify_atlas.py; here are the scenes that it has no place for.
"""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from converters.placement import centered_placement
from minirt.quantities import QUANTITIES
from minirt.rules import SLIDES
from minirt.scene import Scene
from minirt.whitted import primary_directions
from reference.compare.check import Check
from reference.registry import choose_references
from reference.renderers.embree import source as embree
from reference.renderers.embree.rays import Embree, Engine
from reference.renderers.embree.secondary import mirrored, refracted
from reference.renderers.embree.source import EmbreeReference
from reference.renderers.embree.sphere_rays import SphereSet
from reference.renderers.embree.trimesh_rays import TrimeshEngine
from reference.verify.rendering import render_to_file
from reference.verify.scene import compare_scene

SCREEN: dict[str, Any] = {
    "P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
    "l": -0.5, "r": 0.5, "b": -0.375, "t": 0.375, "nx": 64, "ny": 48,
}  # fmt: skip
MATERIALS: dict[str, dict[str, Any]] = {
    "red": {"diffuse": [0.8, 0.1, 0.3]},
    "glass": {"ior": 1.5, "transmittance": 1.0},
    "thin": {"ior": 0.6, "transmittance": 1.0},
}
ENGINES: list[type[Engine]] = [Embree, TrimeshEngine]
GIVEN = set(QUANTITIES) - {"ray", "color", "alpha"}


def scene(*objects: dict[str, Any], **changes: Any) -> Scene:
    document = {
        "minirt": 1, "name": "test", "screen": SCREEN, "light": {"direction": [-1, -2, -3]},
        "materials": MATERIALS, "objects": list(objects),
    }  # fmt: skip
    return minirt.load_scene(document | changes)


def tent(material: str) -> dict[str, Any]:
    corners = [[-1.0, -1.0, 0.2], [1.0, -1.0, 0.3], [0.0, 1.0, -0.2]]
    return {"type": "triangle", "material": material, "vertices": corners}


def slab(material: str, z: float) -> dict[str, Any]:
    corners = [[-3, -2, z], [3, -2, z], [3, 2, z], [-3, 2, z]]
    return {"type": "polygon", "material": material, "vertices": corners}


def ball(material: str, center: list[float], radius: float) -> dict[str, Any]:
    return {"type": "sphere", "material": material, "center": center, "radius": radius}


def tilted() -> dict[str, Any]:
    """A left-handed frame, ν > 0, an off-axis screen of pixels that are not square."""
    c, s = np.cos(0.3), np.sin(0.3)
    return SCREEN | {
        "u": [-c, 0, s], "n": [-s, 0, -c], "nu": 1.0, "P0": [5 * s, 0, 5 * c],
        "l": -0.3, "r": 0.7, "b": -0.6, "t": 0.25,
    }  # fmt: skip


def scenes() -> dict[str, Scene]:
    mixed = [slab("red", -2.0), tent("glass"), ball("thin", [0.9, 0.5, 0.4], 0.4)]
    here = np.array([1e5, -2e5, 3e4])
    far = [
        ball("red", [1e5 + 0.4, -2e5, 3e4], 0.5),
        {**tent("red"), "vertices": (np.array(tent("red")["vertices"]) + here).tolist()},
    ]
    tiny = {**tent("glass"), "vertices": (1e-6 * np.array(tent("red")["vertices"])).tolist()}
    line = {**tent("red"), "vertices": [[-1, 0, 1], [0, 0, 1], [1, 0, 1]]}
    return {
        "mixed": scene(*mixed),
        "tilted": scene(*mixed, screen=tilted()),
        "far": scene(*far, screen=SCREEN | {"P0": [1e5, -2e5, 3e4 + 5]}),
        "tiny": scene(tiny, screen=SCREEN | {"P0": [0, 0, 5e-6]}),
        "degenerate": scene(line, tent("red")),
        "spheres": scene(ball("glass", [0, 0, 0], 1.0), ball("red", [0, 1.5, 0], 0.5)),
        "empty": scene(),
    }


def checks(of: Scene, folder: Path) -> dict[str, Check]:
    folder.mkdir(exist_ok=True)
    answer = render_to_file(EmbreeReference(), of, folder)
    verdict = compare_scene(of, [(EmbreeReference(), answer)])
    return {check.quantity: check for check in verdict.references["embree"].checks}


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", scenes())
def test_it_agrees_with_minirt_within_what_it_declares(
    name: str, engine: type[Engine], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(embree, "engine_here", lambda: engine)
    found = checks(scenes()[name], tmp_path)
    assert {quantity for quantity, check in found.items() if check.state == "passed"} == GIVEN
    assert {check.state for check in found.values()} == {"passed", "not supported"}
    seen = found["t"].compared
    assert (seen == 0) == (name == "empty")


def test_it_is_not_blind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A directional error of 2e-5, some 30 times what is declared, does not pass."""

    def turned(*args: Any) -> Any:
        return primary_directions(*args) + np.array([[2e-5], [0.0], [0.0]])

    monkeypatch.setattr(embree, "primary_directions", turned)
    found = checks(scenes()["mixed"], tmp_path)
    assert found["t"].state == found["position"].state == "failed"


def test_a_wrong_rule_of_minirt_shows_in_what_leaves_the_surface(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The reference uses none of minirt's rules for it, so it does not make the same mistake."""
    of = scenes()["mixed"]
    frame = EmbreeReference().render(of, tmp_path).frame
    for rule, quantity in (("reflect", "reflection"), ("refract", "refraction")):
        wrong = minirt.render(of, SLIDES.replace(**{rule: lambda delta, *rest: delta}))
        where = np.isfinite(frame[quantity]).all(axis=2)
        assert where.any()
        off = np.abs(wrong[quantity] - frame[quantity])[where]
        assert (off.max(axis=1) > 1e-3).mean() > 0.5


def test_it_is_named_after_what_really_ran(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flat, curved = scenes()["degenerate"], scenes()["spheres"]
    assert EmbreeReference().render(flat, tmp_path).program.startswith("Embree, embreex 4.")
    assert EmbreeReference().render(curved, tmp_path).program.endswith("; spheres in closed form")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    stand_in = EmbreeReference().render(flat, tmp_path).program
    assert stand_in.startswith("trimesh ")
    assert stand_in.endswith("its own engine for want of embreex")


def test_it_is_registered_and_travels_to_a_child() -> None:
    (reference,) = choose_references(["embree"])
    assert pickle.loads(pickle.dumps(reference)) == EmbreeReference()  # noqa: S301  our own
    assert reference.missing() is None


def test_it_declares_an_error_that_grows_with_the_scene() -> None:
    small, large = scenes()["tiny"], scenes()["mixed"]
    declared = EmbreeReference().declare(large)
    assert 0 < EmbreeReference().declare(small).delta < 1e-5 * declared.delta * 1.01
    # u · (2·√3·R + 15·E) with R < E: below 19·2⁻²⁴ of the extent
    assert declared.delta < 19 * 2.0**-24 * large.extent
    assert "u = 2⁻²⁴" in declared.derivation


@pytest.mark.parametrize("size", [0, 6])
def test_the_placement_has_the_size_that_was_asked_for(size: int) -> None:
    for of in scenes().values():
        placement = centered_placement(of, size)
        assert 2.0 ** (size - 1) <= placement.length(of.extent) < 2.0**size


@pytest.mark.parametrize("engine", ENGINES)
def test_u_and_v_weigh_the_second_and_third_corner(engine: type[Engine]) -> None:
    corners = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    origins = np.array([[0.25, 0.9, 0.25], [0.125, 0.9, 0.125], [0.5, 0.5, -0.5]])
    directions = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-1.0, -1.0, 1.0]])
    met = engine(corners).nearest(origins, directions)
    assert met.triangle.tolist() == [0, -1, 0]
    # Embree divides by reciprocals, whose last bit depends on the processor
    np.testing.assert_allclose(met.distance, [0.5, np.inf, 0.5], rtol=2.0**-22)
    np.testing.assert_allclose(met.uv[:, [0, 2]], [[0.25, 0.25], [0.125, 0.125]], atol=1e-6)
    assert met.normal[:, 0].tolist() == [0, 0, 1]
    assert engine(corners).occluded(origins, directions).tolist() == [True, False, True]


def test_balls_are_met_from_outside_from_inside_and_not_behind() -> None:
    spheres = SphereSet(np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 0.5]]), np.array([0.25, 0.125]))
    origins = np.array([[0.0, 0.0, 0.0, 0.3], [0.0] * 4, [-1.0, 0.0, 1.0, -1.0]])
    directions = np.array([[0.0] * 4, [0.0] * 4, [1.0, 1.0, 1.0, 1.0]])
    number, distance = spheres.nearest(origins, directions)
    assert number.tolist() == [0, 0, -1, -1]
    assert distance.tolist() == [0.75, 0.25, np.inf, np.inf]


def test_a_mirror_and_a_pane_by_their_own_formulas() -> None:
    """Against the angles themselves: 45° in a mirror, and Snell's law from 30°, both ways."""
    down = np.array([[np.sqrt(0.5)], [0.0], [-np.sqrt(0.5)]])
    up = np.array([[0.0], [0.0], [1.0]])
    np.testing.assert_allclose(mirrored(down, up)[:, 0], down[:, 0] * [1, 1, -1], atol=1e-15)
    thirty = np.array([[0.5], [0.0], [-np.sqrt(0.75)]])
    for delta, sine in ((thirty, 0.5 / 1.5), (thirty * [[1], [1], [-1]], 0.5 * 1.5)):
        bent = refracted(delta, up, np.array([1.5]))[:, 0]
        np.testing.assert_allclose(bent[0], sine, atol=1e-15)
        assert np.sign(bent[2]) == np.sign(delta[2, 0])
        np.testing.assert_allclose((bent * bent).sum(), 1, atol=1e-15)
    steep = np.array([[0.9], [0.0], [np.sqrt(1 - 0.81)]])
    assert np.isnan(refracted(steep, up, np.array([1.5]))).all()
