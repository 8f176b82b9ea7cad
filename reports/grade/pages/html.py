"""The pages of a graded class: one a student, and one for staff."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from minirt.quantities import QUANTITIES
from reports.grade.judging.explained import FailureExplanation
from reports.grade.judging.judge import MarkSheet
from reports.grade.judging.thumbnails import QUANTITY_FILE, THUMBNAILS
from reports.grade.pages.words import (
    about,
    all_right,
    headline,
    lateness,
    message_of,
    mistake_of,
    part_in_words,
    points,
    scene_in_words,
)
from reports.grade.record import ClassRecord, Student, frequent_mistakes
from reports.page.colors import HATCH, RING, band_legend, css
from reports.page.template import template
from reports.results.words import RULE_NAMES, count

_CAPTIONS = {"ours": "right", "theirs": "yours", "difference": "difference"}
#: Columns of the histogram.
_COLUMNS = 10
#: Mistakes that the class page lists.
_MOST_MISTAKES = 15


@dataclass(frozen=True)
class Thumbnails:
    """The pictures of one scene, as data addresses."""

    quantity: str
    images: tuple[tuple[str, str, str], ...]


def student_html(student: Student, title: str, folders: Mapping[str, Path]) -> str:
    """A student's page, everything in one file.

    Parameters
    ----------
    student : Student
    title : str
        The assignment's.
    folders : mapping of str to Path
        By public scene, the folder of its pictures.
    """
    scenes = [_scene(result, folders[result.scene]) for result in student.public]
    return template("student.html.j2").render(
        student=student, marks=student.marks, title=title, headline=headline(student),
        late=lateness(student), message=message_of(student), points=points, count=count,
        parts=[(part, part_in_words(part)) for part in student.marks.parts],
        closers=[_closer(closer, folders[closer.scene]) for closer in student.closer],
        wrong=[scene for scene in scenes if not scene["good"]],
        right=[scene for scene in scenes if scene["good"]],
        bands=band_legend(), hatch=[css(color) for color in HATCH], ring=css(RING[0]),
    )  # fmt: skip


def class_html(record: ClassRecord) -> str:
    """The page for staff."""
    students = sorted(record.students, key=lambda each: (-each.marks.points, each.name))
    return template("class.html.j2").render(
        record=record, points=points, count=count, rule_names=RULE_NAMES,
        median=median(each.marks.points for each in students),
        histogram=list(_histogram(record)),
        hardest=sorted(_parts(record), key=lambda part: float(part["share"])),
        mistakes=frequent_mistakes(students)[:_MOST_MISTAKES],
        students=[(each, about(each)) for each in students],
    )  # fmt: skip


def _scene(result: MarkSheet, folder: Path) -> dict[str, Any]:
    return {
        "name": result.scene, "words": scene_in_words(result), "good": all_right(result),
        "pictures": _thumbnails(folder), "output": result.output.strip(),
    }  # fmt: skip


def _closer(closer: FailureExplanation, folder: Path) -> dict[str, Any]:
    return {
        "closer": closer, "pictures": _thumbnails(folder), "slide": RULE_NAMES[closer.rule],
        "about": QUANTITIES[closer.quantity].about, "said": mistake_of(closer),
    }  # fmt: skip


def _thumbnails(folder: Path) -> Thumbnails | None:
    if not (folder / QUANTITY_FILE).is_file():
        return None
    images = tuple((name, _CAPTIONS[name], _uri(folder / f"{name}.png")) for name in THUMBNAILS)
    return Thumbnails((folder / QUANTITY_FILE).read_text(encoding="ascii"), images)


def _uri(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")


def _histogram(record: ClassRecord) -> Iterator[tuple[str, int, float]]:
    """Columns of a tenth of all points each: (label, students, share of the largest)."""
    numbers = [0] * _COLUMNS
    for student in record.students:
        share = student.marks.points / record.of
        numbers[min(_COLUMNS - 1, int(share * _COLUMNS))] += 1
    for k, number in enumerate(numbers):
        ends = [points(record.of * end / _COLUMNS) for end in (k, k + 1)]
        yield f"{ends[0]}–{ends[1]}", number, number / max(numbers)


def _parts(record: ClassRecord) -> Iterator[dict[str, Any]]:
    for k, part in enumerate(record.students[0].marks.parts):
        earned = [student.marks.parts[k] for student in record.students]
        share = sum(each.points for each in earned) / (part.of * len(earned))
        full = sum(each.points == each.of for each in earned)
        yield {"name": part.name, "of": part.of, "share": share, "full": full}
