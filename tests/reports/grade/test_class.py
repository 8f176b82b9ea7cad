"""The sample class: what each submission must earn, and that nothing disturbs the others."""

from __future__ import annotations

import base64
import csv
import io
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from junitparser import JUnitXml
from PIL import Image
from playwright.sync_api import Browser

from reference.cache import Cache
from reports.grade import student as grading
from reports.grade.assignment.assignment import read_assignment
from reports.grade.assignment.times import read_times
from reports.grade.judging.judge import JudgingContext
from reports.grade.pages.class_files import grades_csv
from reports.grade.pages.class_files import write_class as write_reports
from reports.grade.pages.html import class_html, student_html
from reports.grade.record import ClassRecord, Student, folder_name, shown_name
from reports.grade.run import GradeOptions, grade_class
from reports.grade.submission.students import students_in
from tests.helpers.browser import chromium
from tests.helpers.grade_class import CLASS, PARTS, TOTAL, Submission, write_class

#: In the fast tier, `test_programs.py` grades programs by a rubric of the same form.
pytestmark = pytest.mark.full


@dataclass
class Graded:
    folder: Path
    record: ClassRecord
    context: JudgingContext

    @property
    def out(self) -> Path:
        return self.folder / "out"

    def again(self, jobs: int = 1) -> ClassRecord:
        handed = students_in(self.folder / "submissions")
        times = read_times(self.folder / "times.csv")
        return grade_class(GradeOptions(handed, self.context, self.out, jobs, times))

    def student(self, name: str) -> Student:
        return next(each for each in self.record.students if each.name == name)


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Graded:
    folder = tmp_path_factory.mktemp("class")
    handed, rubric, times = write_class(folder)
    context = JudgingContext(read_assignment(rubric), Cache(folder / "cache"), True)
    out = folder / "out"
    options = GradeOptions(students_in(handed), context, out, 2, read_times(times))
    record = grade_class(options)
    write_reports(record, out)
    return Graded(folder, record, context)


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
    assert ("identical", ("ana", "boris", "quentin", "élodie")) in found
    assert ("reference", ("tara",)) in found
    accused = {name for copy in graded.record.copies for name in copy.students}
    assert accused & {"carmen", "dan", "farid", "greta", "hugo", "rosa"} == set()
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


@pytest.mark.full
def test_a_run_goes_on_where_it_was(graded: Graded, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    really = grading.opened

    def counting(pool: grading.GradingPool, path: Path, scratch: Path) -> object:
        opened.append(path.name)
        return really(pool, path, scratch)

    monkeypatch.setattr(grading, "opened", counting)
    assert graded.again() == graded.record
    assert opened == []
    (graded.out / "staff" / "state" / "lars.json").write_text("{", encoding="ascii")
    again = graded.again()
    assert opened == ["lars"]
    assert again == graded.record  # the same submission, the same marks


def own_files(graded: Graded, student: Student) -> str:
    folder = graded.out / "students" / student.folder
    paths = sorted(folder.rglob("*"))
    assert {path.name for path in paths} == {"report.html", "report.md", "results.json"}
    return "".join(path.read_text(encoding="utf-8") for path in paths)


def test_a_page_says_what_is_wrong_and_where(graded: Graded) -> None:
    page = (graded.out / "students" / "nadia" / "report.html").read_text(encoding="utf-8")
    for words in (
        "31.94 of 36 points", "agrees with rule S16 with s on the incident side",
        "The slide, rule <b>S16</b>: refracted direction ϱ", "full marks on 0 of 2 scenes",
        "the viewing frame", "refraction<span class=\"hidden\">: wrong</span>",
    ):  # fmt: skip
        assert words in page
    assert page.count("<img ") == 3 * (8 + 1)  # three a scene, and of the one explained again
    assert "<script" not in page


def test_no_student_finds_another_in_their_files(graded: Graded) -> None:
    names = [student.name for student in graded.record.students]
    for student in graded.record.students:
        text = re.sub(r"base64,[A-Za-z0-9+/=]+", "", own_files(graded, student))
        others = [n for n in names if n != student.name and re.search(rf"\b{n}\b", text)]
        assert others == []
        assert student.name in text
        assert "copied" not in text
        assert "bit for bit" not in text


def test_no_student_finds_reference_arrays_in_their_files(graded: Graded) -> None:
    """Pictures of values are of 250 colours at most; numbers are those of two pixels."""
    for student in graded.record.students:
        text = own_files(graded, student)
        data = [base64.b64decode(each) for each in re.findall(r"base64,([A-Za-z0-9+/=]+)", text)]
        assert all(Image.open(io.BytesIO(png)).mode == "P" for png in data)
        assert len(student.closer) <= 2
        numbers = re.findall(r"-?\d+\.\d{5,}", re.sub(r"base64,[A-Za-z0-9+/=]+", "", text))
        assert len(numbers) < 2500


def test_the_class_page_names_mistakes_parts_and_copies(graded: Graded) -> None:
    page = (graded.out / "staff" / "class.html").read_text(encoding="utf-8")
    for words in ("light-not-negated", "mirrors", "katya and sven share the same numbers", "élodie",
                  "leads out of the archive", "../students/nadia/report.html"):  # fmt: skip
        assert words in page
    links = re.findall(r'href="([^"]+)"', page)
    assert len(links) == 20
    assert all((graded.out / "staff" / link).resolve().is_file() for link in links)


def test_names_that_are_markup_formulas_or_paths_do_nothing(graded: Graded) -> None:
    names = ['<img src=x onerror="alert(1)">', "=HYPERLINK(1)", "..", "a/b", "\udce9", "x" * 300]
    names += ["x" * 299 + "y", "\udce8"]  # which look like two of them
    folders = [folder_name(name) for name in names]
    assert len(set(folders)) == len(set(map(shown_name, names))) == len(names)
    assert all(re.fullmatch(r"[A-Za-z0-9_-]+", folder) for folder in folders)
    (first, *_) = graded.record.students
    students = tuple(
        first.model_copy(update={"name": shown_name(name), "folder": folder})
        for name, folder in zip(names, folders, strict=True)
    )
    record = graded.record.model_copy(update={"students": students, "copies": ()})
    assert "<img" not in class_html(record)
    rows = list(csv.reader(io.StringIO(grades_csv(record))))
    assert [row[0][:1] for row in rows[1:3]] == ["<", "'"]
    page = student_html(students[0], "t", {s.scene: graded.out for s in students[0].results})
    assert "<img src=x" not in page


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as found:
        yield found


@pytest.mark.full
@pytest.mark.parametrize("name", ["students/katya", "students/olga", "students/ana", "staff"])
def test_pages_are_for_everybody_in_light_and_dark_wide_and_narrow(
    name: str, graded: Graded, browser: Browser
) -> None:
    path = graded.out / name / ("class.html" if name == "staff" else "report.html")
    for scheme, width in (("light", 1200), ("dark", 390)):
        context = browser.new_context(viewport={"width": width, "height": 900}, bypass_csp=True)
        page = context.new_page()
        page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
        page.goto(path.as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert page.evaluate("[...document.images].every((each) => each.naturalWidth > 0)")
        found = Axe().run(page).response["violations"]
        assert [(v["id"], v["nodes"][0]["html"]) for v in found] == []
        context.close()
