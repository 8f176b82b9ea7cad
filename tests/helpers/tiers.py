"""Which tier a test belongs to, by the expressions with which the Makefile chooses."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any

import pytest
from _pytest.mark.expression import Expression

from tests.helpers.places import ROOT

#: All that pytest collected, before it chose by marks and words.
COLLECTED = pytest.StashKey[tuple[pytest.Item, ...]]()
#: The Makefile's targets that run tests.
TIERS = ("test-fast", "test-rest")


def tiered(cases: Iterable[Any], fast: Callable[[Any], bool]) -> list[Any]:
    """Cases for ``parametrize``: those that `fast` chooses, and the others marked ``full``."""
    return [
        case
        if fast(case)
        else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.full)
        for case in cases
    ]


def makefile_choices() -> dict[str, str]:
    """The expression for pytest's ``-m``, by tier, as the Makefile gives it."""
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    found = re.findall(r"^([a-z-]+): .*\n\t\$\(BIN\)/pytest \$\(PYTEST\) -m '([^']+)'$", text, re.M)
    assert tuple(target for target, _ in found) == TIERS
    return dict(found)


def tiers_of(item: pytest.Item, choices: dict[str, str]) -> list[str]:
    """The tiers in which a test runs."""
    marks = {mark.name for mark in item.iter_markers()}

    def is_marked(name: str, /, **_: object) -> bool:
        return name in marks

    return [tier for tier, text in choices.items() if Expression.compile(text).evaluate(is_marked)]


def misplaced(items: Iterable[pytest.Item], choices: dict[str, str]) -> dict[str, list[str]]:
    """The tests that run in no tier or in two, with these tiers."""
    found = {item.nodeid: tiers_of(item, choices) for item in items}
    return {name: tiers for name, tiers in found.items() if len(tiers) != 1}
