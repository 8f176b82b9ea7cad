"""What a student gets: a page, the same as Markdown, and Gradescope's `results.json`.

None of it holds hidden scenes, reference arrays or another student's name.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from reports.grade.pages.gradescope import results_json
from reports.grade.pages.html import student_html
from reports.grade.pages.words import (
    explanation_in_words,
    headline,
    lateness,
    message_of,
    part_in_words,
    points,
    scene_in_words,
)
from reports.grade.record import Student
from reports.results.words import plain


def write_student(student: Student, title: str, folders: Mapping[str, Path], folder: Path) -> None:
    """Write a student's files into a new folder.

    Parameters
    ----------
    student : Student
    title : str
        The assignment's.
    folders : mapping of str to Path
        By public scene, the folder of its pictures.
    folder : Path
    """
    texts = {
        "results.json": json.dumps(results_json(student), indent=1) + "\n",
        "report.md": markdown(student, title),
        "report.html": student_html(student, title, folders),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")


def markdown(student: Student, title: str) -> str:
    """A student's page as Markdown."""
    lines = [f"# {_cell(student.name)}: {headline(student)}", ""]
    lines += [_cell(title), ""] if title else []
    lines += [f"- {lateness(student)}", ""] if student.marks.late_days else []
    if student.message:
        lines += ["Nothing could be graded:", "", *_code(message_of(student))]
    lines += ["| part | points | of | |", "|---|---:|---:|---|"]
    lines += [
        f"| {_cell(part.name)} | {points(part.points)} | {points(part.of)} "
        f"| {_cell(part_in_words(part))} |"
        for part in student.marks.parts
    ]
    if student.public:
        lines += ["", "| scene | |", "|---|---|"]
        lines += [f"| {_cell(r.scene)} | {_cell(scene_in_words(r))} |" for r in student.public]
    for result in student.public:
        if words := plain(result.output).strip():
            lines += ["", f"The program's last output on {_cell(result.scene)}:", "", *_code(words)]
    for closer in student.closer:
        column, row = closer.pixel
        lines += ["", f"## {_cell(closer.scene)}", "", explanation_in_words(closer), ""]
        lines += [f"Column {column} from the left, row {row} from the top:", ""]
        lines += ["| quantity | right | yours | |", "|---|---|---|---|"]
        lines += [f"| {x.quantity} | {x.ours} | {x.theirs} | {x.state} |" for x in closer.lines]
        lines += ["", "How the right answer comes about:", "", *_code(closer.explanation.strip())]
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    """Text in which no character means anything to Markdown."""
    return "".join("\\" + c if c in "\\`*_[]<>|#" else c for c in text)


def _code(text: str) -> list[str]:
    fence = "```"
    while fence in text:
        fence += "`"
    return [fence, text, fence, ""]
