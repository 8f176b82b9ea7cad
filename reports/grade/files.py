"""What a graded class leaves in its folder, beside the students' own files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from converters.atomic import atomic_file
from reports.grade.pages import class_html
from reports.grade.record import ClassRecord, write_json
from reports.grade.tables import grades_csv, grades_junit

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
