"""The verdict, for every way a run can end; the results are made by hand."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from reference.compare.check import Check, State
from reference.verify.results import ReferenceResult, SceneResult
from reports.results.cells import first_wrong_stage
from reports.results.findings import findings_of
from reports.results.verdict import Verdict, decide
from tests.helpers.fake_references import small_scene
from tests.helpers.report_runs import good_run, troubled_run

SCENE = small_scene()


def verdict(
    scenes: Sequence[dict[str, State]], required: Sequence[str] = (), chosen: Sequence[str] = ()
) -> Verdict:
    """The verdict on scenes given as reference → state of its only check."""
    results = [
        SceneResult(SCENE, tuple(answer(name, state) for name, state in scene.items()))
        for scene in scenes
    ]
    names = list(chosen) or list(scenes[0] if scenes else [])
    return decide(findings_of(results, names), names, required)


def answer(name: str, state: State) -> ReferenceResult:
    wrong = 3 if state == "failed" else 0
    check = Check("shadow", "shadow", state, state, 9, 9, 9, wrong=wrong, first_wrong=wrong)
    return ReferenceResult(name, name, (check,))


@pytest.mark.parametrize(
    ("scenes", "required", "status"),
    [
        ([{"a": "passed"}], [], 0),
        ([{"a": "passed"}], ["a"], 0),
        ([{"a": "passed"}, {"a": "not supported"}], ["a"], 0),
        ([{"a": "passed", "b": "missing"}], [], 0),
        ([{"a": "passed", "b": "not given"}], [], 0),
        ([{"a": "failed"}], [], 1),
        ([{"a": "passed"}, {"a": "failed"}], [], 1),
        ([{"a": "failed", "b": "crashed"}], [], 1),
        ([{"a": "failed", "b": "missing"}], ["b"], 1),
        ([{"a": "passed", "b": "crashed"}], [], 3),
        ([{"a": "passed", "b": "timed out"}], [], 3),
        ([{"a": "passed"}, {"a": "crashed"}], [], 3),
        ([{"a": "passed", "b": "missing"}], ["b"], 3),
        ([{"a": "passed", "b": "not given"}], ["b"], 3),
        ([{"a": "passed"}, {"a": "not given"}], [], 0),
        ([{"a": "passed"}, {"a": "not given"}], ["a"], 3),
        ([{"a": "passed"}], ["b"], 3),
        ([{"a": "missing"}], [], 3),
        ([{"a": "not supported"}], [], 3),
        ([{"a": "not given"}], [], 3),
        ([{}], [], 3),
        ([], [], 2),
    ],
)
def test_exit_status(scenes: list[dict[str, State]], required: list[str], status: int) -> None:
    decided = verdict(scenes, required)
    assert decided.exit_status == status
    assert decided.sentence.startswith({0: "PASS", 1: "FAIL", 2: "FAIL", 3: "INCOMPLETE"}[status])
    assert bool(decided.troubles) == (status > 1 or (len(scenes[0]) > 1 and status == 1))


def test_failure_names_how_many_scenes_and_the_first_wrong_stage() -> None:
    sentence = verdict([{"a": "failed"}, {"a": "passed"}, {"a": "failed"}]).sentence
    assert sentence == "FAIL: 2 of 3 scenes; first wrong stage: shadow"


def test_what_is_incomplete_is_named_with_the_reason() -> None:
    sentence = verdict([{"a": "passed", "b": "missing", "c": "crashed"}], ["b", "z"]).sentence
    assert sentence == (
        "INCOMPLETE: z is required and was not chosen; b is missing (missing); "
        "c crashed on 1 of 1 scene"
    )


def test_why_nothing_was_compared_is_said_once() -> None:
    sentence = verdict([{"a": "not supported", "b": "not supported"}], ["a"]).sentence
    assert sentence == "INCOMPLETE: nothing was compared: not supported (a, b)"


def test_success_names_only_who_really_compared() -> None:
    sentence = verdict([{"a": "passed", "b": "not given"}]).sentence
    assert sentence.startswith("PASS: 1 scene agrees with a; ")
    assert "scene not compared" in verdict([{"a": "passed"}, {"a": "not given"}]).sentence


def test_no_scene_is_said_clearly() -> None:
    assert verdict([]).sentence == "FAIL: no scene was chosen, so nothing was compared"


def test_first_wrong_stage_is_the_earliest_in_causal_order() -> None:
    late = Check("color", "colour", "failed", first_wrong=2, wrong=2)
    early = Check("t", "t", "failed", first_wrong=1, wrong=1)
    follows = Check("hit", "hit", "failed", first_wrong=0, wrong=1)
    assert first_wrong_stage([late, early, follows]) == "t"
    assert first_wrong_stage([follows]) == ""


def test_counts_cover_every_check_and_every_scene() -> None:
    findings = troubled_run().findings
    by_state = findings.checks
    assert sum(by_state.values()) == 2 * 9 * 20
    assert {state for state, n in by_state.items() if not n} == {"known"}  # there is no baseline
    assert findings.scene_states["failed"] == 2
    assert good_run().findings.checks["passed"] == 2 * 20


def test_references_without_an_answer_are_grouped_by_reason() -> None:
    groups = {group.reference: group for group in troubled_run().findings.unanswered}
    assert set(groups) == {"missing", "aborting", "hanging"}
    assert len(groups["aborting"].scenes) == 2
    assert "LLVM ERROR" in groups["aborting"].output
