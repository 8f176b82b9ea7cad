"""Every known mistake costs marks in the part about its rule; what is right costs none."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest

from minirt import load_scene
from minirt.frame import Array, Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.compare.comparison import compare
from reference.compare.precision import Claim, declared
from reference.compare.stability import Exact, Stability, exact_answer, stability_of
from reference.mutants import CATALOGUE, ORIGINAL
from reference.mutants.mutant import Mutant
from reference.mutants.scenes import THIN_GAP
from reference.traceability import TRACED
from reference.verify.results import Evidence
from reports.grade.assignment.part_quantities import quantities_judged
from reports.grade.assignment.rubric import Part
from reports.grade.judging.tally import Tally, charged_pixels, tally
from tests.helpers.grade_class import small as of_the_atlas

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


#: A rubric about every rule.
EVERY = tuple(TRACED)


def share(rule: str, evidence: Evidence, rubric: Sequence[str] = EVERY) -> float:
    """The share of right pixels in the part about a rule, in a rubric with a part a rule."""
    return counted(rule, ALL, evidence, rubric).share


def counted(
    rule: str, names: tuple[str, ...], evidence: Evidence, rubric: Sequence[str] = EVERY
) -> Tally:
    parts = [about(each) for each in rubric]
    excused = charged_pixels([(part, quantities_judged(part, ALL)) for part in parts], evidence)
    return tally(about(rule), names, evidence, excused)


def about(rule: str) -> Part:
    return Part(name=rule, points=1.0, rules=(rule,))


def changed(name: str, **arrays: Array) -> Evidence:
    """minirt's own answer with some quantities exchanged."""
    return seen(name, Frame({**answered(name)[0].frame.arrays, **arrays}))


@pytest.mark.parametrize("mutant", CATALOGUE.values(), ids=CATALOGUE)
def test_a_mistake_costs_marks_in_the_part_about_its_rule(mutant: Mutant) -> None:
    for name in SHOWING:
        if share(mutant.rule, seen(name, mutant.render(small(name)))) < 1:
            return
    pytest.fail("no scene shows it")


@pytest.mark.parametrize("name", SHOWING)
def test_what_is_right_costs_nothing(name: str) -> None:
    evidence = seen(name, ORIGINAL.render(small(name)))
    rules = {mutant.rule for mutant in CATALOGUE.values()}
    assert len(rules) == 16
    assert {rule: share(rule, evidence) for rule in rules} == dict.fromkeys(rules, 1.0)


def test_a_consequence_is_left_out_of_the_count() -> None:
    """Where a tenth of the pixels has a wrong ray and all that follows, shadows lose nothing."""
    arrays = {name: array.copy() for name, array in answered("ball-on-quad")[0].frame.items()}
    arrays["ray"][:3] *= -1
    arrays["shadow"][:3] = 1 - arrays["shadow"][:3]
    evidence = seen("ball-on-quad", Frame(arrays))
    shadows = counted("S12", ("shadow",), evidence)
    assert shadows.share == 1
    assert shadows.judged == evidence.ours["hit"].size - int(
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
    assert share("S13", evidence, ["S13"]) == pytest.approx(1 - 17 / 36, abs=0.01)


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
    names = quantities_judged(about("S5"), ALL)
    depth, hit = (Frame({name: exact.frame[name]}) for name in ("depth", "hit"))
    some = counted("S5", names, seen("ball-on-quad", depth))
    none = counted("S5", names, seen("ball-on-quad", hit))
    assert (some.share, some.given, some.asked) == (1.0, 1, len(names))
    assert (none.share, none.given) == (0.0, 0)


def losing(evidence: Evidence) -> set[str]:
    return {rule for rule in TRACED if share(rule, evidence) < 1}


@pytest.mark.parametrize("name", ["ball-on-quad", "pentagon-and-octagon"])
def test_flipped_normals_cost_nothing_under_the_screen(name: str) -> None:
    evidence = changed(name, normal=-answered(name)[0].frame["normal"])
    assert losing(evidence) <= {"S8", "S9", "S10"}
    assert share("S9", evidence) < 0.5


def test_normals_in_viewing_coordinates_cost_marks_under_s3() -> None:
    evidence = seen("left-handed-frame", by_name("normal-in-viewing-coordinates"))
    assert share("S3", evidence) < 0.5
    assert share("S2", evidence) == 1


def by_name(mistake: str) -> Frame:
    return CATALOGUE[mistake].render(small("left-handed-frame"))


def test_a_wrong_hit_is_not_the_screens_fault_where_the_rays_are_right() -> None:
    hit = answered("ball-on-quad")[0].frame["hit"]
    evidence = changed("ball-on-quad", hit=~hit)
    assert share("S1", evidence) == share("S3", evidence) == 1
    assert share("S6", evidence) < 0.5
    alone = seen("ball-on-quad", Frame({"hit": ~hit}))
    assert share("S1", alone) < 0.5


def test_a_wrong_t_is_no_matter_of_the_interval_where_something_is_hit() -> None:
    t = answered("ball-on-quad")[0].frame["t"]
    assert losing(changed("ball-on-quad", t=2 * t)) == {"S5", "S8", "S9", "S10"}
    nothing = changed("ball-on-quad", t=np.where(np.isinf(t), 0.0, t))
    assert losing(nothing) == {"S5", "S6"}
