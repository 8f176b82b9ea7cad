"""Every known mistake costs marks in the part about its rule; what is right costs none."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from grade_class import small as of_the_atlas

from minirt.frame import Frame
from minirt.quantities import QUANTITIES, STAGES, Stage
from minirt.scene import Scene, load_scene
from reference.compare import compare
from reference.mutants import CATALOGUE, HONEST
from reference.mutants.mutant import Mutant
from reference.mutants.thin_gap import THIN_GAP
from reference.precision import Claim, declared
from reference.stability import Exact, Stability, exact_answer, stability_of
from reference.verify import Evidence
from reports.grade.parts import quantities_judged, tally
from reports.grade.rubric import Part

#: Scenes on which every mistake shows, in few pixels.
SHOWING = (
    "ball-on-quad", "left-handed-frame", "inside-glass", "snells-window", "negative-nu",
    "non-square-pixels", "behind-the-observer", "pentagon-and-octagon", "inside-a-sphere", "alpha",
    "thin-gap",
)  # fmt: skip
ALL = tuple(QUANTITIES)


@cache
def small(name: str) -> Scene:
    return load_scene(THIN_GAP) if name == "thin-gap" else of_the_atlas(name)


@cache
def answered(name: str) -> tuple[Exact, Stability]:
    exact = exact_answer(small(name))
    return exact, stability_of(exact, declared(exact.scene, Claim()))


def seen(name: str, theirs: Frame) -> Evidence:
    exact, stability = answered(name)
    comparison = compare(exact.scene, exact.frame, stability, theirs, {}, pictures=False)
    return Evidence(exact.scene, "subject", exact.frame, theirs, stability, comparison)


def share(rule: str, evidence: Evidence, charged: Sequence[Stage] = STAGES) -> float:
    part = Part(name=rule, points=1.0, rules=(rule,))
    return tally(part, quantities_judged(part, ALL), evidence, charged).share


@pytest.mark.parametrize("mutant", CATALOGUE.values(), ids=CATALOGUE)
def test_a_mistake_costs_marks_in_the_part_about_its_rule(mutant: Mutant) -> None:
    for name in SHOWING:
        if share(mutant.rule, seen(name, mutant.render(small(name)))) < 1:
            return
    pytest.fail("no scene shows it")


@pytest.mark.parametrize("name", SHOWING)
def test_what_is_right_costs_nothing(name: str) -> None:
    evidence = seen(name, HONEST.render(small(name)))
    rules = {mutant.rule for mutant in CATALOGUE.values()}
    assert len(rules) == 16
    assert {rule: share(rule, evidence) for rule in rules} == dict.fromkeys(rules, 1.0)


def test_a_consequence_is_left_out_of_the_count() -> None:
    """Where a tenth of the pixels has a wrong ray and all that follows, shadows lose nothing."""
    arrays = {name: array.copy() for name, array in answered("ball-on-quad")[0].frame.items()}
    arrays["ray"][:3] *= -1
    arrays["shadow"][:3] = 1 - arrays["shadow"][:3]
    evidence = seen("ball-on-quad", Frame(arrays))
    part = Part(name="shadows", points=1.0, rules=("S12",))
    counted = tally(part, ("shadow",), evidence, STAGES)
    assert counted.share == 1
    assert counted.judged == evidence.ours["hit"].size - int(
        (evidence.comparison.ratio["shadow"] > 1).sum()
    )
    assert share("S2", evidence) == pytest.approx(1 - 3 / 36)


def test_a_mistake_that_no_part_is_about_excuses_nothing() -> None:
    """Else wrong flags of hits, which cost nothing, would hide half of the colours."""
    arrays = {name: array.copy() for name, array in answered("ball-on-quad")[0].frame.items()}
    arrays["hit"][:17] = ~arrays["hit"][:17]
    arrays["color"][:17] += 1
    evidence = seen("ball-on-quad", Frame(arrays))
    assert share("S13", evidence) == 1
    assert share("S13", evidence, ["colour"]) == pytest.approx(1 - 17 / 36, abs=0.01)


def test_consequences_that_leave_less_than_half_count_as_wrong() -> None:
    arrays = {name: array.copy() for name, array in answered("ball-on-quad")[0].frame.items()}
    arrays["ray"] *= -1
    arrays["shadow"] = (1 - arrays["shadow"]).astype(np.int8)
    assert share("S12", seen("ball-on-quad", Frame(arrays))) == 0


def test_a_kind_of_object_is_judged_where_it_stands() -> None:
    exact, _ = answered("ball-on-quad")
    arrays = {name: array.copy() for name, array in exact.frame.items()}
    ball = np.array([thing.type == "sphere" for thing in exact.scene.objects])[
        exact.frame["object"]
    ]
    arrays["normal"][ball & exact.frame["hit"]] *= -1
    evidence = seen("ball-on-quad", Frame(arrays))
    assert share("S8", evidence) < 0.1
    assert share("S9", evidence) == 1


def test_what_is_not_given_is_counted() -> None:
    exact, _ = answered("ball-on-quad")
    part = Part(name="order", points=1.0, rules=("S5",))
    names = quantities_judged(part, ALL)
    depth, hit = (Frame({name: exact.frame[name]}) for name in ("depth", "hit"))
    some = tally(part, names, seen("ball-on-quad", depth), STAGES)
    none = tally(part, names, seen("ball-on-quad", hit), STAGES)
    assert (some.share, some.given, some.asked) == (1.0, 1, len(names))
    assert (none.share, none.given) == (0.0, 0)
