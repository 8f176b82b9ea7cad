"""S17: the exercises are solved, and answers judged by what they must be, not by one of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.errors import InputError
from minirt.explain.exercise_kinds import Reflection
from minirt.explain.exercises import EXERCISES, checked, generated
from reports.cli.main import run

SQ3 = 3.0**0.5


def answers() -> dict[str, Any]:
    return {str(k): each.answer for k, each in enumerate(EXERCISES, start=1)}


def test_the_lectures_own_answers_are_right() -> None:
    first, second, third = EXERCISES
    assert first.answer == {"direction": [1, -1, 0]}
    assert second.answer == {"center": [5, 3, 1], "radius": SQ3}
    assert third.answer == {"direction": [3, 1, 2]}
    assert checked(EXERCISES, answers()) == {"1": "", "2": "", "3": ""}


@pytest.mark.parametrize("turn", np.linspace(0, 2 * np.pi, 9)[:-1])
def test_every_direction_of_the_cone_is_right_and_none_beside_it(turn: float) -> None:
    L = np.array([1.0, -3.0, 0.0])
    across, up = np.array([3.0, 1.0, 0.0]) / 10**0.5, np.array([0.0, 0.0, 1.0])
    side = np.cos(turn) * across + np.sin(turn) * up
    for angle, right in ((1.0, True), (1.001, False), (0.999, False)):
        alpha = angle * np.arcsin((2 / 10) ** 0.5)
        d = np.cos(alpha) * L / 10**0.5 + np.sin(alpha) * side
        fault = EXERCISES[0].check({"direction": d.tolist()})
        assert (fault == "") == right
        assert right or ("misses" if angle > 1 else "twice") in fault


@pytest.mark.parametrize(
    ("number", "answer", "words"),
    [
        ("1", {"direction": [-1, 1, 0]}, "behind the ray"),
        ("1", {"direction": [0, 0, 0]}, "zero vector"),
        ("1", {"direction": [1, -3, 0]}, "twice, at t = 0.55"),
        ("2", {"center": [5, 3, 1], "radius": 2}, "passes the centre at 1.73205"),
        ("2", {"center": [5, 3, 1], "radius": -SQ3}, "positive"),
        ("2", {"center": [3, 0, -1], "radius": 1.0}, "passes the centre"),
        ("2", {"center": [3, -1, -1], "radius": SQ3}, "behind"),
        ("3", {"direction": [-3, -1, -2]}, "opposite way"),
        ("3", {"direction": [6, 2, 4]}, "7.48331 long, and δ 3.74166"),
        ("3", {"direction": [3, 2, 1]}, "its part along"),
    ],
)
def test_a_wrong_answer_is_explained(number: str, answer: dict[str, Any], words: str) -> None:
    assert words in EXERCISES[int(number) - 1].check(answer)


def test_a_few_decimals_are_enough() -> None:
    given = {"2": {"center": [5, 3, 1], "radius": 1.73205}, "3": {"direction": [3.0, 1.00001, 2]}}
    assert checked(EXERCISES, given) == {"1": None, "2": "", "3": ""}


@pytest.mark.parametrize("seed", range(40))
def test_generated_exercises_have_the_solutions_that_they_print(seed: int) -> None:
    first, second, third = made = generated(seed)
    assert made == generated(seed)
    assert all(each.check(each.answer) == "" for each in made)
    assert all(each.text and each.solution for each in made)
    assert first.text != EXERCISES[0].text
    d, C, R = np.array(first.d), np.array(first.C), first.R  # type: ignore[attr-defined]
    around = minirt.intersect_sphere(first.P0, d, C, R * (1 + 1e-9))  # type: ignore[attr-defined]
    assert np.isfinite(around.near)
    inside = minirt.intersect_sphere(first.P0, d, C, R * (1 - 1e-9))  # type: ignore[attr-defined]
    assert np.isinf(inside.near)
    assert second.check(first.answer | {"center": [99, 0, 0], "radius": 1}) != ""
    assert isinstance(third, Reflection)
    assert third.check({"direction": list(third.delta)}) != ""


def test_different_seeds_differ() -> None:
    assert len({generated(seed) for seed in range(40)}) == 40


@pytest.mark.parametrize(
    "given",
    [{"4": {}}, {"1": []}, {"1": {}}, {"1": {"direction": [1, 2]}}, {"1": {"direction": "1 2 3"}},
     {"1": {"direction": [1, 2, "x"]}}, {"1": {"direction": [1, 2, True]}},
     {"1": {"direction": [1, 2, 1e300]}}, {"2": {"center": [1, 2, 3]}},
     {"3": {"direction": [1, 2, float("nan")]}}],
)  # fmt: skip
def test_a_malformed_answer_is_refused(given: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="answer"):
        checked(EXERCISES, given)


def test_the_command_prints_marks_and_hides_solutions(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["exercises"]) == 0
    assert "(3, 1, 2)" in capsys.readouterr().out
    assert run(["exercises", "--unsolved", "--json"]) == 0
    assert "solution" not in capsys.readouterr().out
    file = tmp_path / "answers.json"
    file.write_text(json.dumps(answers()), encoding="utf-8")
    assert run(["exercises", "--check", str(file)]) == 0
    assert capsys.readouterr().out == "1. right\n2. right\n3. right\n"
    file.write_text(json.dumps(answers() | {"3": {"direction": [3, 2, 1]}}), encoding="utf-8")
    assert run(["exercises", "--check", str(file)]) == 1
    assert "3. wrong: its part" in capsys.readouterr().out
    for text in ("", "[]", "{"):
        file.write_text(text, encoding="utf-8")
        assert run(["exercises", "--check", str(file)]) == 2
    for path in (tmp_path, Path("/dev/zero")):
        assert run(["exercises", "--check", str(path)]) == 2
    file.write_text('{"1": {"direction": [1, 2, 3]}, "2": {"center": [1], "radius": 1}}')
    capsys.readouterr()
    assert run(["exercises", "--check", str(file)]) == 2
    assert "2: center: not an answer; got [1]; expected 3 numbers" in capsys.readouterr().err
