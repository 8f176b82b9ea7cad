"""Marks: what lateness costs, what hidden scenes decide, what is missing."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import pytest

from reports.grade.assignment.assignment import Assignment, read_assignment
from reports.grade.assignment.rubric import LatePolicy
from reports.grade.judging.judge import MarkSheet
from reports.grade.judging.score import days_late, marks_of
from tests.helpers.grade_class import write_rubric

DEADLINE = datetime.fromisoformat("2027-01-31T23:59:00+02:00")
SCENES = ("ball-on-quad", "overlapping-spheres")


def assignment(folder: Path, extra: str = "") -> Assignment:
    path = write_rubric(folder, SCENES, extra)
    text = path.read_text(encoding="utf-8").partition("[[part]]")[0]
    part = '[[part]]\nname = "all"\npoints = 10\n'
    path.write_text(text + part, encoding="utf-8")
    return read_assignment(path)


def sheet(scene: str, right: int, number: int = 0, given: int = 20) -> MarkSheet:
    return MarkSheet(
        scene=scene, number=number, state="judged", tallies={0: (1000, right, given, 20)}
    )


def points(given: Assignment, *results: MarkSheet, late: int = 0) -> float:
    speaking = {(s.scene.name, s.number): (True,) for s in given.scenes}
    return marks_of(given, speaking, results, late).points


def test_credit_is_linear_and_a_missing_scene_earns_nothing(tmp_path: Path) -> None:
    given = assignment(tmp_path)  # zero at half of the pixels
    first, second = SCENES
    assert points(given, sheet(first, 1000), sheet(second, 1000)) == 10
    assert points(given, sheet(first, 1000), sheet(second, 750)) == 7.5
    assert points(given, sheet(first, 1000), sheet(second, 499)) == 5
    assert points(given, sheet(first, 1000)) == 5
    assert points(given, sheet(first, 1000, given=5), sheet(second, 1000)) == 6.25
    assert points(given) == 0


def test_hidden_scenes_decide_their_share(tmp_path: Path) -> None:
    given = assignment(tmp_path, "hidden = {seed = 1, variants = 2, share = 0.4}")
    public = [sheet(name, 1000) for name in SCENES]
    hidden = [sheet(name, 1000, number=k) for name in SCENES for k in (1, 2)]
    assert len(given.scenes) == 6
    assert points(given, *public) == 6
    assert points(given, *public, *hidden) == 10
    assert points(given, *public, *hidden[:2]) == 8


@pytest.mark.parametrize(
    ("after", "days"),
    [(-1, 0), (0, 0), (1, 1), (86_400, 1), (86_401, 2), (10 * 86_400, 10)],
)
def test_each_begun_day_counts(after: float, days: int) -> None:
    late = LatePolicy(deadline=DEADLINE, per_day=0.1)
    assert days_late(late, DEADLINE + timedelta(seconds=after)) == days
    assert days_late(late, None) == 0
    assert days_late(None, DEADLINE) == 0


@pytest.mark.parametrize(("days", "left"), [(0, 10), (1, 9), (3, 7), (4, 0), (99, 0)])
def test_lateness_costs_its_share_and_in_the_end_everything(
    days: int, left: float, tmp_path: Path
) -> None:
    late = f"late = {{deadline = {DEADLINE.isoformat()}, per_day = 0.1, most_days = 3}}"
    given = assignment(tmp_path, late)
    assert points(given, *(sheet(name, 1000) for name in SCENES), late=days) == left
