"""Change points: a step and another state are found, noise and constancy are not."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from reports.history.previous import Point
from reports.history.trends import LEAST, changes_of

RNG = np.random.default_rng(1)


def trend(ratios: Sequence[float | None], states: str = "", altered: int = -1) -> list[Point]:
    """Points with these ratios, and states given by their first letters; p without."""
    words = {"p": "passed", "f": "failed", "i": "incomplete", "n": "not compared"}
    return [
        Point(
            k + 1, f"2026-11-{k + 1:02}", f"{k:040x}", words[s], r, "old" if k < altered else "new"
        )
        for k, (r, s) in enumerate(zip(ratios, states or "p" * len(ratios), strict=True))
    ]


def where(points: Sequence[Point]) -> list[tuple[int, int]]:
    return [(change.before.run, change.after.run) for change in changes_of(points)]


@pytest.mark.parametrize("ratios", [[], [0.4], [0.0] * 50, [0.42] * 50, [None] * 9, [math.inf] * 9])
def test_a_constant_trend_has_no_change(ratios: list[float | None]) -> None:
    assert changes_of(trend(ratios)) == []


@pytest.mark.parametrize("spread", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("length", [2 * LEAST, 10, 30, 90])
def test_noise_is_hardly_ever_taken_for_a_change(spread: float, length: int) -> None:
    runs = 150
    alarms = sum(
        bool(changes_of(trend(list(0.4 * np.exp(RNG.normal(0, spread, length))))))
        for _ in range(runs)
    )
    assert alarms <= 0.02 * runs


@pytest.mark.parametrize(
    "ratios",
    [
        [0.3, 0.8] * 20,  # two machines by turns
        [0.4] * 20 + [4.0] + [0.4] * 20,  # one night
        [0.4] * 20 + [4.0] * 2,  # not lasting yet
        list(0.2 * 1.02 ** np.arange(60)),  # a slow drift
        [1e-9, 1e-5] * 3 + [1e-4] * 9,  # all of them next to nothing
        [0.40] * 10 + [0.48] * 10,  # a fifth more
    ],
)
def test_what_is_no_lasting_step_is_no_change(ratios: list[float]) -> None:
    assert changes_of(trend(ratios)) == []


@pytest.mark.parametrize("at", [LEAST, 10, 37, 50 - LEAST])
@pytest.mark.parametrize(("factor", "spread"), [(1.3, 0.0), (1.6, 0.02), (0.5, 0.05), (4.0, 0.1)])
def test_a_step_is_found_where_it_is(at: int, factor: float, spread: float) -> None:
    ratios = 0.2 * np.exp(RNG.normal(0, spread, 50))
    ratios[at:] *= factor
    (change,) = changes_of(trend(list(ratios)))
    assert (change.before.run, change.after.run) == (at, at + 1)
    assert change.better is (factor < 1)
    assert change.what.startswith("worst ratio 0.")


def test_two_steps_are_two_changes() -> None:
    assert where(trend([0.1] * 8 + [0.5] * 8 + [0.2] * 8)) == [(8, 9), (16, 17)]


def test_a_step_from_nothing_is_found() -> None:
    (change,) = changes_of(trend([0.0] * 5 + [0.9] * 3))
    assert change.what == "worst ratio <0.01× → 0.90×"


def test_another_state_is_a_change_at_once() -> None:
    changes = changes_of(trend([0.4, 0.4, math.inf, 0.4, None, 0.4], "ppfpip"))
    assert [(c.after.run, c.better, c.what) for c in changes] == [
        (3, False, "passed → failed"),
        (4, True, "failed → passed"),
        (5, False, "passed → incomplete"),
        (6, True, "incomplete → passed"),
    ]
    assert changes[0].before.commit == f"{1:040x}"
    assert changes[0].after.commit == f"{2:040x}"


def test_the_ratio_of_a_failing_night_is_no_step_besides() -> None:
    assert where(trend([0.4] * 5 + [20.0] * 5, "p" * 5 + "f" * 5)) == [(5, 6)]


def test_runs_without_a_ratio_do_not_hide_a_step() -> None:
    assert where(trend([0.1, None] * 4 + [None, 0.9] * 4)) == [(7, 10)]


def test_an_altered_scene_is_named() -> None:
    (change,) = changes_of(trend([0.1] * 5 + [0.9] * 5, altered=5))
    assert change.what == "worst ratio 0.10× → 0.90×; the scene itself was altered"
