"""The files of a graded class: `grades.csv`, JUnit for CI systems, and the page for staff."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

from junitparser import Failure, JUnitXml, TestCase, TestSuite

from converters.atomic import atomic_file
from reports.grade.pages.html import class_html
from reports.grade.pages.words import message_of, no_frames, part_in_words, points
from reports.grade.record import ClassRecord, Student, write_json
from reports.results.words import one_line

#: What a spreadsheet takes for the beginning of a formula.
_FORMULA = ("=", "+", "-", "@")


def grades_csv(record: ClassRecord) -> str:
    """One row a student, one column a part."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    parts = [part.name for part in record.students[0].marks.parts]
    writer.writerow(
        ["student", "points", "of", "late_days", "penalty", *map(_text, parts),
         "kind", "first_wrong_stage", "mistake", "message"]
    )  # fmt: skip
    for student in record.students:
        marks = student.marks
        writer.writerow(
            [_text(student.name), points(marks.points), points(marks.of), marks.late_days,
             points(marks.penalty), *(points(part.points) for part in marks.parts), student.kind,
             student.stage, _text(student.mistake),
             _text(one_line(student.message or no_frames(student)))]
        )  # fmt: skip
    return stream.getvalue()


def grades_junit(record: ClassRecord) -> str:
    """A suite a student, a case a part: failed where it does not earn all of its points."""
    report = JUnitXml("minirt grade")
    for student in record.students:
        report.add_testsuite(_suite(student))
    report.update_statistics()
    text: str = report.tostring().decode("utf-8")
    return text


def _suite(student: Student) -> TestSuite:
    suite = TestSuite(one_line(student.name))
    for part in student.marks.parts:
        case = TestCase(one_line(part.name), one_line(student.name))
        if part.points < part.of:
            message = f"{points(part.points)} of {points(part.of)} points: {part_in_words(part)}"
            case.result = Failure(message, "marks")
            case.result[0].text = message_of(student)
        suite.add_testcase(case)
    return suite


def _text(text: str) -> str:
    """Text that no spreadsheet takes for a formula."""
    return f"'{text}" if text.startswith(_FORMULA) else text


#: The files of a class, and what makes each.
REPORTS: dict[str, Callable[[ClassRecord], str]] = {
    "grades.csv": grades_csv,
    "staff/junit.xml": grades_junit,
    "staff/class.html": class_html,
}


def write_class(record: ClassRecord, out: Path) -> None:
    """Write every table and page of a class, each whole or not at all."""
    write_json(record, out / "staff" / "grades.json")
    for name, make in REPORTS.items():
        with atomic_file(out / name) as path:
            path.write_text(make(record), encoding="utf-8", newline="\n")
