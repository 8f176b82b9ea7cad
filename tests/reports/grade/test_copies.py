"""Copies are told from answers that are only right, and cost nothing."""

from __future__ import annotations

import numpy as np
import pytest

from minirt.frame import Frame
from reports.grade.copies import find_copies
from reports.grade.judging.fingerprint import fingerprint
from reports.grade.judging.judge import MarkSheet
from reports.grade.judging.score import Marks
from reports.grade.record import Student
from tests.helpers.grade_class import honest, mutant

SCENE = "ball-on-quad"


def rounded(frame: Frame, meta: dict[str, str] | None = None) -> Frame:
    arrays = {
        name: array.astype(np.float32).astype(np.float64) if array.dtype == np.float64 else array
        for name, array in frame.items()
    }
    return Frame(arrays, meta or {})


@pytest.mark.parametrize(
    ("theirs", "tells", "own"),
    [
        (mutant("none", SCENE), True, True),
        (honest(SCENE), True, False),
        (mutant("far-root", SCENE), True, False),
        (rounded(mutant("none", SCENE)), False, False),  # right, and rounded: anybody's
        (rounded(honest(SCENE)), False, False),
        (rounded(mutant("none", SCENE), {"sceneSha256": "1"}), True, True),  # minirt wrote it
        (rounded(mutant("far-root", SCENE)), True, False),
        (Frame({"depth": mutant("none", SCENE)["depth"]}), False, False),
        (Frame({"color": honest(SCENE)["color"]}), False, False),  # the same bits as minirt's
        (Frame({}), False, False),
    ],
    ids=["own", "honest", "wrong", "own rounded", "honest rounded", "signed", "wrong rounded",
         "depth alone", "colour alone", "nothing"],
)  # fmt: skip
def test_numbers_accuse_only_where_they_tell(theirs: Frame, tells: bool, own: bool) -> None:
    numbers, ours = fingerprint(mutant("none", SCENE), theirs)
    assert (bool(numbers), ours) == (tells, own)


def student(name: str, *results: MarkSheet) -> Student:
    marks = Marks(parts=(), earned=0, points=0, of=1)
    return Student(name=name, folder=name, key="", kind="program", marks=marks, results=results)


def sheet(
    scene: str, numbers: str, number: int = 0, wrong: int = 0, ours: bool = False
) -> MarkSheet:
    return MarkSheet(
        scene=scene, number=number, state="judged", numbers=numbers, wrong=wrong, ours=ours
    )  # fmt: skip


def test_groups_of_students_are_told_once() -> None:
    students = [student(name, sheet("a", "1"), sheet("b", "2")) for name in ("x", "y", "z")]
    (found,) = find_copies([*students, student("w", sheet("a", "3"), sheet("b", "4"))])
    assert (found.kind, found.students, found.scenes) == ("identical", ("x", "y", "z"), ("a", "b"))


def test_one_scene_in_common_of_many_is_no_copy() -> None:
    first = student("x", *(sheet(f"{k}", f"x{k}") for k in range(5)), sheet("c", "1"))
    other = student("y", *(sheet(f"{k}", f"y{k}") for k in range(5)), sheet("c", "1"))
    assert find_copies([first, other]) == ()


def test_output_that_stays_when_its_scene_changes_is_told() -> None:
    stays = student("x", sheet("a", "1"), sheet("a", "1", number=1, wrong=9))
    (found,) = find_copies([stays])
    assert found.kind == "unchanging"
    assert "does not read its scene" in found.sentence
    right = student("x", sheet("a", "1"), sheet("b", "1"))  # two scenes that look the same
    assert find_copies([right]) == ()


def test_numbers_of_minirts_own_are_told_where_they_are_most() -> None:
    some = student("x", sheet("a", "1", ours=True), sheet("b", "2"), sheet("c", "3"))
    most = student("y", sheet("a", "4", ours=True), sheet("b", "5", ours=True), sheet("c", "6"))
    assert [copy.students for copy in find_copies([some, most])] == [("y",)]
