"""What is known of a student, and of the class; kept on disk, so that a killed run goes on."""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError

from converters.atomic import atomic_file
from minirt.quantities import STAGES
from reports.grade.judging.explained import FailureExplanation
from reports.grade.judging.judge import MarkSheet
from reports.grade.judging.score import Marks
from reports.results.json_model import Model
from reports.results.words import one_line

#: Names that are a folder's name as they are.
_SAFE = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._-]{0,59}")


class Student(Model):
    """One submission, graded. For staff: it speaks of hidden scenes."""

    name: str
    folder: str = Field(description="of the student's own files, below students/")
    key: str = Field(description="hash of all that the marks depend on")
    kind: Literal["frames", "program", "nothing"]
    message: str = Field(default="", description="why there is nothing to grade, or what failed")
    submitted: str | None = None
    marks: Marks
    results: tuple[MarkSheet, ...] = ()
    closer: tuple[FailureExplanation, ...] = ()

    @property
    def public(self) -> tuple[MarkSheet, ...]:
        """The results that the student may see."""
        return tuple(result for result in self.results if result.number == 0)

    @property
    def stage(self) -> str:
        """The first wrong stage of all public scenes; empty where nothing is wrong."""
        wrong = {result.stage for result in self.public}
        return next((stage for stage in STAGES if stage in wrong), "")

    @property
    def mistake(self) -> str:
        """What explains the first failing scene, in a clause; empty where nothing does."""
        return next((each.mistake for each in self.closer if each.mistake), "")


class Copy(Model):
    """Something that looks copied; it costs no marks."""

    kind: Literal["identical", "reference", "unchanging"]
    students: tuple[str, ...]
    scenes: tuple[str, ...]
    sentence: str


class ClassRecord(Model):
    """All of a class. For staff."""

    minirtGrades: Literal[1] = 1  # noqa: N815
    title: str
    of: float
    students: tuple[Student, ...]
    copies: tuple[Copy, ...]
    remarks: tuple[str, ...]


def folder_name(name: str) -> str:
    """A folder's name for a student: their own where it is harmless, else with a hash of it."""
    if _SAFE.fullmatch(name):
        return name
    kept = re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-")[:40]
    return f"{kept or 'student'}-{_digest(name)}"


def shown_name(name: str) -> str:
    """A student's name for pages and tables; where it cannot be shown whole, with a hash of it."""
    text = one_line(name.encode(errors="replace").decode(), 80)
    return text if text == name else f"{one_line(text, 68)} ({_digest(name)})"


def _digest(name: str) -> str:
    return hashlib.sha256(name.encode(errors="surrogateescape")).hexdigest()[:8]


def earlier_record(path: Path, key: str) -> Student | None:
    """What an earlier run found, if it was of the same submission, rubric and program."""
    try:
        student = Student.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None
    return student if student.key == key else None


def write_json(model: Model, path: Path) -> None:
    """Write a record whole or not at all; only ASCII, so that no half character can spoil it."""
    with atomic_file(path) as temporary:
        text = json.dumps(model.model_dump(mode="json"), indent=1, allow_nan=False)
        temporary.write_text(text + "\n", encoding="ascii", newline="\n")


def frequent_mistakes(students: Sequence[Student]) -> list[tuple[str, str, int]]:
    """Diagnoses by how many students have them, most first: (rule, mistake's name, number)."""
    found = Counter(
        pair
        for student in students
        for pair in {(each.rule, each.name) for each in student.closer if each.name}
    )
    return [(rule, name, number) for (rule, name), number in found.most_common()]
