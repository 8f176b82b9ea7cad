"""An explanation's numbers are the picture's, bit for bit."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.errors import InputError
from minirt.explain.candidates import MAX_LISTED
from minirt.explain.pixel import Explanation, explain
from minirt.explain.steps import Step, plain

NAMES = {"barycentric", "depth", "distance", "hit", "normal", "position", "ray", "shadow", "tir"}
NAMES |= {
    f"{kind}{what}" for kind in ("reflection", "refraction") for what in ("", "_object", "_t")
}


@cache
def _picture(name: str) -> tuple[minirt.Scene, minirt.Frame]:
    scene = minirt.load_scene(f"atlas:{name}")
    return scene, minirt.render(scene)


def _pixels(frame: minirt.Frame, n: int) -> Iterator[tuple[int, int]]:
    rng = np.random.default_rng(30)
    ny, nx = frame.size
    for _ in range(n):
        yield int(rng.integers(nx)), int(rng.integers(ny))


def _step(explanation: Explanation, title: str) -> Step:
    (found,) = [step for step in explanation.steps if step.title == title]
    return found


def _same(value: Any, array: Any) -> bool:
    return bool(np.asarray(value, dtype=array.dtype).tobytes() == array.tobytes())


@pytest.mark.parametrize("name", ["everything", "glass-slab", "hall-of-mirrors", "inside-glass"])
def test_every_number_is_the_frames_bit_for_bit(name: str) -> None:
    scene, frame = _picture(name)
    compared = set()
    for column, row in _pixels(frame, 15):
        explanation = explain(scene, column, row)
        values = {k: v for step in explanation.steps for k, v in step.values.items() if k in NAMES}
        for key, value in values.items():
            assert _same(value, frame[key][row, column]), (key, column, row)
        chosen = _step(explanation, "the first object hit").values
        for key in ("object", "triangle", "t"):
            assert _same(chosen[key], frame[key][row, column]), (key, column, row)
        color = _step(explanation, "the pixel's colour").values["color"]
        assert _same(color, frame["color"][row, column]), (column, row)
        compared |= set(values)
    assert compared >= NAMES - {"tir", "refraction", "refraction_object", "refraction_t"}
    if name != "hall-of-mirrors":
        assert compared >= NAMES


def test_steps_follow_the_algorithm() -> None:
    scene, frame = _picture("glass-slab")
    row, column = np.argwhere(frame["tir"] == 0)[0]
    rules = [step.rule for step in explain(scene, int(column), int(row)).steps]
    first = list(dict.fromkeys(rules))
    assert first[:5] == ["S1", "S2", "S3", "S5", "S4"]
    assert {"S12", "S14", "S15", "S16", "S13", "S7"} <= set(first)
    assert rules.index("S12") < rules.index("S14") < rules.index("S16") < rules.index("S13")


def test_angles_obey_snell() -> None:
    scene, frame = _picture("glass-slab")
    row, column = np.argwhere(frame["tir"] == 0)[0]
    values: dict[str, Any] = dict(
        _step(explain(scene, int(column), int(row)), "Snell's law").values
    )
    theta, phi = np.radians([values["theta"], values["phi"]])
    # Sine and arcsine err by an ulp each; the angles are above 1e-3.
    assert values["nu"] * np.sin(theta) == pytest.approx(values["nu_t"] * np.sin(phi), rel=1e-12)


def test_a_length_is_called_1_only_where_it_is() -> None:
    scene, _ = _picture("one-sphere")
    sentence = _step(explain(scene, 128, 96), "the ray").sentence
    assert "not normalised: length 1.00000" in sentence
    document = {**scene.to_dict()}
    document["screen"] |= {"nx": 1, "ny": 1, "l": -1, "r": 1, "b": -1, "t": 1, "nu": -1}
    central = explain(minirt.load_scene(document), 0, 0)
    assert "d = P − P0, of length 1; t = 1 at the screen" in _step(central, "the ray").sentence


def test_a_missed_pixel_ends_with_the_background() -> None:
    scene, frame = _picture("one-sphere")
    row, column = np.argwhere(~frame["hit"])[0]
    explanation = explain(scene, int(column), int(row))
    assert explanation.steps[-1].values["color"] == scene.background
    assert "Nothing is hit" in _step(explanation, "the first object hit").sentence
    assert not [step for step in explanation.steps if step.rule in ("S12", "S14")]


def test_only_the_nearest_candidates_are_listed_and_the_rest_counted() -> None:
    scene, frame = _picture("overlapping-spheres")
    row, column = np.argwhere(frame["hit"])[len(np.argwhere(frame["hit"])) // 2]
    explanation = explain(scene, int(column), int(row))
    counts = _step(explanation, "the objects asked").values
    listed = [step for step in explanation.steps if step.rule == "S8" and "near" in step.values]
    assert counts["asked"] + counts["culled"] == len(scene.objects)  # type: ignore[operator]
    assert len(listed) == min(MAX_LISTED, counts["asked"])  # type: ignore[type-var]
    t = [float(step.values["t"]) for step in listed]  # type: ignore[arg-type]
    assert t == sorted(t)


def test_as_json_it_holds_only_numbers_that_json_has() -> None:
    scene, frame = _picture("one-sphere")
    row, column = np.argwhere(~frame["hit"])[0]
    document = explain(scene, int(column), int(row)).to_dict()
    again = json.loads(json.dumps(document, allow_nan=False))
    assert again == document
    assert plain((float("nan"), -float("inf"), 1.0)) == ["nan", "-inf", 1.0]


def test_a_replaced_rule_is_followed() -> None:
    scene, _ = _picture("one-sphere")
    rules = minirt.SLIDES.replace(depth_of=lambda t, nu: t * 7.0)
    values = _step(explain(scene, 128, 96, rules), "the point").values
    assert values["depth"] == 7.0 * float(values["t"])  # type: ignore[arg-type]


@pytest.mark.parametrize(("column", "row"), [(-1, 0), (0, -1), (256, 0), (0, 192)])
def test_a_pixel_outside_the_image_is_one_clear_error(column: int, row: int) -> None:
    with pytest.raises(InputError, match=r"(column|row): the pixel lies outside .* expected 0 to"):
        explain(_picture("one-sphere")[0], column, row)
