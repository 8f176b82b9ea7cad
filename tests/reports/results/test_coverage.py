"""What a run has not checked is said, and no rule passes for want of a comparison."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.compare.check import Check, State
from reference.verify.results import ReferenceResult, SceneResult
from reports.results.coverage import gap_in_words, gaps, not_checked, not_compared, rule_coverage
from tests.helpers.fake_references import small_scene


def result(
    scene: Scene, checks: Mapping[str, State | tuple[State, str]], reference: str = "a"
) -> SceneResult:
    """One scene against one reference, its checks given by quantity; compared where passed."""
    made = []
    for name, given in checks.items():
        state, reason = (given, "") if isinstance(given, str) else given
        seen = 9 if state in ("passed", "failed") else 0
        made.append(Check(name, QUANTITIES[name].stage, state, reason, 9, seen, seen))
    return SceneResult(scene, (ReferenceResult(reference, reference, tuple(made)),))


LISTS_S5 = small_scene("one", rules=["S5"])
ALL: dict[str, State] = dict.fromkeys(("ray", "t", "depth", "distance", "position"), "passed")


@pytest.mark.parametrize(
    ("checks", "state", "passed"),
    [
        (ALL, "passed", 1),
        (ALL | {"position": "not given"}, "partly checked", 1),
        (ALL | {"position": "failed"}, "failed", 0),
        (ALL | {"shadow": "failed"}, "passed", 1),
        (dict.fromkeys(ALL, "not supported"), "not checked", 0),
        (dict.fromkeys(ALL, "missing"), "not checked", 0),
    ],
)
def test_a_rule_passes_only_where_each_of_its_quantities_was_compared(
    checks: dict[str, State], state: str, passed: int
) -> None:
    found = rule_coverage([result(LISTS_S5, checks)])["S5"]
    assert (found.state, found.passed) == (state, passed)


def test_what_one_scene_lacks_another_may_show() -> None:
    first = result(LISTS_S5, ALL | {"position": "not given"})
    second = result(small_scene("two", rules=["S5"]), ALL | {"ray": "not given"})
    found = rule_coverage([first, second])["S5"]
    assert found.state == "passed"
    assert found.trace.checked == {"ray": 1, "t": 2, "depth": 2, "distance": 2, "position": 1}


def test_rays_of_our_own_say_nothing_about_the_camera() -> None:
    scene = small_scene(rules=["S1", "S6"])
    found = rule_coverage([result(scene, {"hit": "passed"}, "embree")])
    assert (found["S1"].state, found["S6"].state) == ("not checked", "passed")
    assert found["S2"].state == "no scene"


def test_a_pass_without_any_value_shows_no_rule() -> None:
    check = Check("barycentric", "t", "passed", "", 9, 9, 0)
    scene = small_scene(rules=["S9"])
    found = rule_coverage([SceneResult(scene, (ReferenceResult("a", "a", (check,)),))])["S9"]
    assert found.state == "not checked"


def test_quantities_that_nobody_compared_are_named_with_the_number_of_scenes() -> None:
    some = {"hit": "passed", "color": "passed", "alpha": "not supported"}
    few = {"hit": "passed", "color": "not supported", "alpha": "not supported"}
    none = dict.fromkeys(some, "not supported")
    scenes = [result(small_scene(str(k)), c) for k, c in enumerate((some, few, few, none))]  # type: ignore[arg-type]
    assert not_checked(scenes) == "alpha on all 3 scenes; color on 2 of 3 scenes"
    assert not_checked(scenes[:1]) == "alpha on the scene"
    assert not_checked([result(small_scene(), {"hit": "passed"})]) == ""
    assert not_checked(scenes[3:]) == ""


def test_scenes_that_nobody_compared_are_named_with_the_reason() -> None:
    square: tuple[State, str] = ("not supported", "square pixels only")
    scenes = [result(small_scene(name), {"hit": square, "t": square}) for name in ("x", "y")]
    assert not_compared([*scenes, result(small_scene(), {"hit": "passed"})]) == [
        "x, y: square pixels only (a)"
    ]


def test_gaps_are_counted_by_reason_whatever_the_materials_are_called() -> None:
    def fault(name: str) -> tuple[State, str]:
        return "not supported", f"it's not black; the slides' own, not for '{name}', 'b'"

    scenes = [
        result(small_scene(name), {"hit": "passed", "color": fault(name)}) for name in ("x", "y")
    ]
    found = gaps(scenes)
    assert [(gap.reason, gap.checks, gap.scenes) for gap in found] == [
        ("it's not black", 2, 2), ("the slides' own, not for …", 2, 2),
    ]  # fmt: skip
    assert gap_in_words(found[0]) == "color on 2 scenes"
    many = dict.fromkeys(ALL, ("not given", "why")) | {"hit": "passed"}
    assert gap_in_words(gaps([result(LISTS_S5, many)])[0]) == "5 quantities on 1 scene"  # type: ignore[arg-type]
    assert gaps([result(LISTS_S5, {"hit": ("not supported", "why")})]) == []
