"""The sample class: what each submission must earn, and that nothing disturbs the others."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path

import pytest
from grade_class import CLASS, PARTS, TOTAL, Submission, write_class
from junitparser import JUnitXml

from reference.cache import Cache
from reports.grade import run
from reports.grade.assignment import read_assignment
from reports.grade.files import write_class as write_reports
from reports.grade.judge import Desk
from reports.grade.record import ClassRecord, Student
from reports.grade.run import grade_class
from reports.grade.submission import students_in
from reports.grade.times import read_times


@dataclass
class Graded:
    folder: Path
    record: ClassRecord
    desk: Desk

    @property
    def out(self) -> Path:
        return self.folder / "out"

    def again(self, jobs: int = 1) -> ClassRecord:
        handed = students_in(self.folder / "submissions")
        times = read_times(self.folder / "times.csv")
        return grade_class(handed, self.desk, self.out, jobs, times)

    def student(self, name: str) -> Student:
        return next(each for each in self.record.students if each.name == name)


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Graded:
    folder = tmp_path_factory.mktemp("class")
    handed, rubric, times = write_class(folder)
    desk = Desk(read_assignment(rubric), Cache(folder / "cache"), True)
    out = folder / "out"
    record = grade_class(students_in(handed), desk, out, 2, read_times(times))
    write_reports(record, out)
    return Graded(folder, record, desk)


@pytest.mark.parametrize("each", CLASS, ids=lambda each: each.name.encode("ascii", "replace"))
def test_a_submission_earns_what_it_must(each: Submission, graded: Graded) -> None:
    student = graded.student(each.name)
    earned = {part.name: part.points / part.of for part in student.marks.parts}
    assert student.marks.points == each.points
    assert each.message in student.message
    assert bool(each.message) == bool(student.message)
    assert {name for name in each.keeps.split() if earned[name] < 1} == set()
    assert not each.right or earned[each.right] < 1
    assert set(earned) == set(PARTS)


def test_nobody_is_missing_and_nothing_was_written_elsewhere(graded: Graded) -> None:
    assert len(CLASS) == len(graded.record.students) == 20
    assert not list(graded.folder.parent.rglob("evil.txt"))
    names = {path.name for path in graded.out.iterdir()}
    assert names == {"grades.csv", "students", "staff"}


@pytest.mark.parametrize(
    ("name", "rule"),
    [("farid", "S2"), ("hugo", "S8"), ("irina", "S9"), ("katya", "S12"), ("nadia", "S16")],
)
def test_a_mistake_is_named_with_its_rule(name: str, rule: str, graded: Graded) -> None:
    (first, *_) = graded.student(name).closer
    assert first.rule == rule
    assert first.mistake.startswith(f"agrees with rule {rule} ")
    assert any(line.state == "wrong" for line in first.lines)
    assert "the viewing frame" in first.explanation


def test_copies_are_reported_and_cost_nothing(graded: Graded) -> None:
    found = {(copy.kind, copy.students) for copy in graded.record.copies}
    assert ("identical", ("katya", "sven")) in found
    assert ("identical", ("ana", "boris", "carmen", "quentin", "élodie")) in found
    assert ("reference", ("tara",)) in found
    accused = {name for copy in graded.record.copies for name in copy.students}
    assert accused & {"dan", "farid", "greta", "hugo", "rosa"} == set()
    assert graded.student("tara").marks.points == TOTAL


def test_grades_csv_has_a_row_a_student_and_a_column_a_part(graded: Graded) -> None:
    with (graded.out / "grades.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["student"]: float(row["points"]) for row in rows} == {
        each.name: each.points for each in CLASS
    }
    late = next(row for row in rows if row["student"] == "élodie")
    assert (late["late_days"], late["penalty"]) == ("1", "7.2")
    assert all(float(late[part]) == 4 for part in PARTS)


def test_gradescope_gets_a_test_a_part(graded: Graded) -> None:
    for each in graded.record.students:
        path = graded.out / "students" / each.folder / "results.json"
        document = json.loads(path.read_text(encoding="utf-8"))
        assert document["score"] == each.marks.points
        assert [test["name"] for test in document["tests"]] == list(PARTS)
        assert sum(test["max_score"] for test in document["tests"]) == TOTAL
        assert all(test["visibility"] == "visible" for test in document["tests"])
        assert document["output_format"] == "text"


def test_junit_has_a_suite_a_student(graded: Graded) -> None:
    report = JUnitXml.fromstring((graded.out / "staff" / "junit.xml").read_bytes())
    failures = {suite.name: suite.failures for suite in report}
    assert failures["ana"] == 0
    assert failures["lars"] == 1
    assert failures["olga"] == len(PARTS)


def test_a_run_goes_on_where_it_was(graded: Graded, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    really = run._opened

    def counting(office: run._Office, path: Path, room: Path) -> object:
        opened.append(path.name)
        return really(office, path, room)

    monkeypatch.setattr(run, "_opened", counting)
    assert graded.again() == graded.record
    assert opened == []
    (graded.out / "staff" / "state" / "lars.json").write_text("{", encoding="ascii")
    again = graded.again()
    assert opened == ["lars"]
    assert again == graded.record  # the same submission, the same marks
