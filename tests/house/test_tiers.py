"""Each test is in exactly one of the two tiers, and none is lost between them."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.helpers.places import ROOT
from tests.helpers.tiers import COLLECTED, TIERS, makefile_choices, misplaced, tiers_of


def test_each_test_is_in_exactly_one_tier(request: pytest.FixtureRequest) -> None:
    collected = request.config.stash[COLLECTED]
    assert {item.nodeid for item in request.session.items} <= {item.nodeid for item in collected}
    assert misplaced(collected, makefile_choices()) == {}


def test_a_test_is_fast_unless_it_is_marked(request: pytest.FixtureRequest) -> None:
    choices = makefile_choices()
    marked = [each for each in request.config.stash[COLLECTED] if each.get_closest_marker("full")]
    assert {tuple(tiers_of(item, choices)) for item in marked} <= {("test-rest",)}
    assert tiers_of(request.node, choices) == ["test-fast"]


def test_a_test_that_would_be_lost_or_run_twice_is_noticed(request: pytest.FixtureRequest) -> None:
    item: pytest.Item = request.node
    assert misplaced([item], {"fast": "also_named", "rest": "full"}) == {item.nodeid: []}
    assert misplaced([item], {"fast": "not full", "rest": "not slow"}) == {
        item.nodeid: ["fast", "rest"]
    }


def collected(*arguments: str) -> list[str]:
    """The names of the tests that pytest collects for these arguments."""
    words = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--collect-only", "-q"]
    done = subprocess.run([*words, *arguments], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return [line for line in done.stdout.splitlines() if "::" in line]


@pytest.mark.full
def test_the_two_tiers_together_are_all_tests() -> None:
    fast, rest = (collected("-m", makefile_choices()[tier]) for tier in TIERS)
    everything = collected()
    assert len(fast) > len(rest) > 100
    assert sorted([*fast, *rest]) == sorted(everything)
    assert len(set(everything)) == len(everything)
