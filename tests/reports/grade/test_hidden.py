"""HiddenScenes scenes: the same for a seed, and no answer to the public scene is one to them."""

from __future__ import annotations

import pytest

from minirt import render
from reference.compare.comparison import compare
from reference.compare.stability import exact_answer, stability_of
from reference.mutants.scenes import float64_rounding
from reports.grade.assignment.hidden import variant
from tests.helpers.grade_class import small

NAMES = ("ball-on-quad", "one-sphere", "glass-ball", "closed-mesh", "off-axis-screen")


@pytest.mark.parametrize("name", NAMES)
def test_an_answer_to_the_public_scene_fails(name: str) -> None:
    public = small(name)
    hidden = variant(public, seed=7, number=1)
    exact = exact_answer(hidden)
    stability = stability_of(exact, float64_rounding(hidden))
    copied = compare(hidden, exact.frame, stability, render(public), {}, pictures=False)
    honest = compare(hidden, exact.frame, stability, render(hidden), {}, pictures=False)
    wrong = {check.quantity: check.wrong / check.pixels for check in copied.checks}
    assert wrong["ray"] > 0.9
    assert wrong["color"] > 0.05
    assert sum(check.wrong for check in honest.checks) == 0
    assert exact.frame["hit"].any()


def test_a_seed_decides_and_nothing_tells_that_it_is_hidden() -> None:
    public = small("ball-on-quad")
    again = [variant(public, 7, 1).sha256 for _ in range(2)]
    assert again[0] == again[1]
    others = {variant(public, seed, k).sha256 for seed in (7, 8) for k in (1, 2)}
    assert len(others | {public.sha256}) == 5
    assert variant(public, 7, 1).name == public.name
    assert variant(public, 7, 1).about == public.about
