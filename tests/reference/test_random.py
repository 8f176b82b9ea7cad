"""Random scenes against every reference that is here: no false alarm."""

from __future__ import annotations

import os
from collections import Counter

import pytest

from reference.registry import REFERENCES
from reference.verify.options import Options
from reference.verify.run import verify
from tests.helpers.random_scenes import random_scene

REQUIRED = {name for name in os.environ.get("MINIRT_REQUIRE", "").split(",") if name}
#: All but Mitsuba's scalar variant, which runs pixel by pixel and is the same code.
USED = [
    reference
    for name, reference in REFERENCES.items()
    if name != "mitsuba-scalar" and (name in REQUIRED or not reference.missing())
]
#: Scenes among which every reference gives two quantities a scene that are compared.
FEW = 5


@pytest.mark.parametrize(
    ("first", "scenes_of_a_run"),
    [
        (0, FEW),
        pytest.param(FEW, 20, marks=pytest.mark.full),
        pytest.param(25, 25, marks=pytest.mark.full),
    ],
)
def test_references_agree_on_random_scenes(first: int, scenes_of_a_run: int) -> None:
    """Many scenes a run: starting the references takes as long as a scene or two."""
    scenes = [random_scene(seed) for seed in range(first, first + scenes_of_a_run)]
    alarms = []
    compared = Counter[tuple[str, int]]()
    for k, result in enumerate(verify(scenes, USED, Options(jobs=1))):
        for answer in result.references:
            for check in answer.checks:
                compared[answer.reference, k // FEW] += check.state == "passed"
                if check.state not in {"passed", "not supported"}:
                    where = f"{result.scene.name}, {answer.reference}, {check.quantity}"
                    alarms.append(f"{where}: {check.reason}")
    assert alarms == []
    assert len(compared) == len(USED) * scenes_of_a_run // FEW
    assert min(compared.values()) >= 2 * FEW, compared
