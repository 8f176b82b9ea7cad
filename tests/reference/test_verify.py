"""References that end in every possible way, in real child processes."""

from __future__ import annotations

from functools import cache

import pytest

from minirt.errors import InputError
from minirt.quantities import QUANTITIES
from reference.compare.check import Check
from reference.jobs.isolate import Workers
from reference.verify.options import Callbacks, Options
from reference.verify.results import Evidence, ReferenceResult, SceneResult
from reference.verify.run import verify
from tests.helpers.fake_references import (
    Aborting,
    CannotSay,
    Faulty,
    Hanging,
    Honest,
    Missing,
    OnePixel,
    Partial,
    Raising,
    Silent,
    WrongSize,
    small_scene,
)


def sizes(evidence: Evidence) -> tuple[str, str, tuple[int, int]]:
    return evidence.scene.name, evidence.reference, evidence.theirs.size


@cache
def results() -> tuple[SceneResult, ...]:
    """Two scenes against everybody; one reference dies on the first scene only."""
    references = (
        Hanging(), Aborting(on="first"), Honest(), OnePixel(), Faulty(), Partial(), Silent(),
        WrongSize(), CannotSay(), Missing(), Raising(),
    )  # fmt: skip
    scenes = [small_scene("first"), small_scene("second")]
    return tuple(verify(scenes, references, Options(timeout=6.0, callbacks=Callbacks(sizes))))


def answer(scene: int, name: str) -> ReferenceResult:
    return next(a for a in results()[scene].references if a.reference == name)


def states(scene: int, name: str) -> set[str]:
    return {check.state for check in answer(scene, name).checks}


def check(scene: int, name: str, quantity: str) -> Check:
    return next(c for c in answer(scene, name).checks if c.quantity == quantity)


def test_scenes_and_references_keep_their_order() -> None:
    assert [result.scene.name for result in results()] == ["first", "second"]
    for result in results():
        names = [a.reference for a in result.references]
        assert names[:3] == ["hanging", "aborting", "honest"]
        assert len(names) == 11
        for found in result.references:
            assert [c.quantity for c in found.checks] == list(QUANTITIES)


@pytest.mark.parametrize(
    ("name", "expected", "reason"),
    [
        ("hanging", "timed out", "no answer within 6 s"),
        ("raising", "crashed", "ZeroDivisionError: the light is off"),
        ("missing", "missing", "not installed: pip install <nothing>"),
        ("cannot", "not supported", "its pixels are round"),
        ("silent", "not given", "the frame does not hold it"),
    ],
)
@pytest.mark.parametrize("scene", [0, 1])
def test_who_does_not_answer_says_why_in_each_of_its_cells(
    name: str, expected: str, reason: str, scene: int
) -> None:
    assert states(scene, name) == {expected}
    assert all(c.reason.startswith(reason) for c in answer(scene, name).checks)


def test_an_abort_costs_one_scene_of_one_reference() -> None:
    assert states(0, "aborting") == {"crashed"}
    assert check(0, "aborting", "hit").reason == "the process was ended by SIGABRT"
    assert "LLVM ERROR: cannot select" in answer(0, "aborting").output
    assert states(1, "aborting") == {"passed"}
    assert [states(scene, "honest") for scene in (0, 1)] == [{"passed"}, {"passed"}]


def test_output_of_who_hangs_is_kept() -> None:
    assert answer(0, "hanging").output == "loading the kernel\n"
    assert "ZeroDivisionError: the light is off" in answer(1, "raising").output


def test_each_wrong_pixel_is_found_and_charged_to_its_first_stage() -> None:
    failed = {c.quantity: c for c in answer(0, "one-pixel").checks if c.state == "failed"}
    assert set(failed) == {"shadow", "depth"}
    shadow, depth = failed["shadow"].worst, failed["depth"].worst
    assert shadow is not None
    assert depth is not None
    assert (shadow.column, shadow.row) == (10, 30)
    assert (depth.column, depth.row) == (20, 31)
    assert failed["shadow"].first_wrong == failed["depth"].first_wrong == 1


def test_a_wrong_rule_fails_where_it_matters_only() -> None:
    failed = {c.quantity for c in answer(0, "faulty").checks if c.state == "failed"}
    assert {"shadow", "reflection_object"} <= failed
    assert not failed & {"ray", "hit", "object", "t", "normal", "reflection"}


def test_what_is_given_is_compared_and_the_rest_is_named() -> None:
    assert check(0, "partial", "hit").state == check(0, "partial", "t").state == "passed"
    assert check(0, "partial", "color").state == "not supported"
    assert check(0, "partial", "color").reason == "it is colour-blind"
    assert check(0, "partial", "normal").state == "not given"


def test_a_wrong_size_fails_with_both_sizes() -> None:
    assert check(0, "wrong-size", "depth").state == "failed"
    assert check(0, "wrong-size", "depth").reason == "the image is 24×36, expected 48×36"


def test_digest_is_made_of_who_answered() -> None:
    assert answer(1, "honest").details == ("second", "honest", (36, 48))
    assert answer(1, "wrong-size").details == ("second", "wrong-size", (36, 24))
    assert answer(1, "hanging").details is None
    assert answer(0, "honest").declared is not None
    assert answer(0, "honest").program == "minirt as honest"


def test_only_the_chosen_quantities_are_compared() -> None:
    (result,) = verify([small_scene()], [Honest()], Options(("hit", "normal"), jobs=1))
    assert [c.quantity for c in result.references[0].checks] == ["hit", "normal"]
    assert {c.state for c in result.references[0].checks} == {"passed"}


def test_nothing_to_compare_is_no_failure_of_minirt() -> None:
    (result,) = verify([small_scene()], [Partial(), Honest()], Options(("color", "normal"), jobs=1))
    partial, honest = result.references
    assert [c.state for c in partial.checks] == ["not supported", "not given"]
    assert {c.state for c in honest.checks} == {"passed"}


def fails_on_first(evidence: Evidence) -> str:
    if evidence.scene.name == "first":
        raise RuntimeError("no more ink")
    return evidence.reference


def test_when_minirt_itself_fails_the_other_scenes_are_still_compared() -> None:
    scenes = [small_scene("first"), small_scene("second")]
    first, second = verify(scenes, [Honest()], Options(jobs=1, callbacks=Callbacks(fails_on_first)))
    (lost,), (kept,) = first.references, second.references
    assert {c.state for c in lost.checks} == {"crashed"}
    assert lost.checks[0].reason == "minirt itself failed: RuntimeError: no more ink"
    assert "no more ink" in lost.output
    assert {c.state for c in kept.checks} == {"passed"}
    assert kept.details == "honest"


def test_no_more_processes_are_started_than_there_is_work_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    counts = []

    class Counted(Workers):
        def __init__(self, count: int) -> None:
            counts.append(count)
            super().__init__(count)

    monkeypatch.setattr("reference.verify.run.Workers", Counted)
    assert len(list(verify([small_scene("one")], [], Options(jobs=64)))) == 1
    assert counts == [1, 1]


def test_what_does_not_fit_in_memory_is_refused_before_anybody_begins(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("minirt.memory.available", lambda: 1000)
    with pytest.raises(InputError, match="pixels of every quantity: not enough memory"):
        list(verify([small_scene()], [Honest()], Options(jobs=1)))
