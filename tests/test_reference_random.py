"""Random scenes against every reference that is here: no false alarm."""

from __future__ import annotations

import os

import pytest
from random_scenes import random_scene

from reference.registry import REFERENCES
from reference.verify import verify

REQUIRED = {name for name in os.environ.get("MINIRT_REQUIRE", "").split(",") if name}
#: All but Mitsuba's scalar variant, which runs pixel by pixel and is the same code.
USED = [
    reference
    for name, reference in REFERENCES.items()
    if name != "mitsuba-scalar" and (name in REQUIRED or not reference.missing())
]


@pytest.mark.parametrize("first", range(0, 50, 5))
def test_references_agree_on_random_scenes(first: int) -> None:
    seeds = range(first, first + 5)
    compared = dict.fromkeys((reference.name for reference in USED), 0)
    for result in verify([random_scene(seed) for seed in seeds], USED, jobs=1):
        for answer in result.references:
            for check in answer.checks:
                where = f"{result.scene.name}, {answer.reference}, {check.quantity}"
                assert check.state in {"passed", "not supported"}, f"{where}: {check.reason}"
                compared[answer.reference] += check.state == "passed"
    assert min(compared.values()) >= 2 * len(seeds), compared
