"""A graded class in the terminal: one line for each student, and what staff should know."""

from __future__ import annotations

from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from reports.grade.pages.words import about, points
from reports.grade.record import ClassRecord
from reports.results.words import count, one_line


def print_class(record: ClassRecord, out: Path, console: Console) -> None:
    """Print the marks of a class, what looks copied, and the remarks."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("student", overflow="fold")
    table.add_column("points", justify="right", no_wrap=True)
    table.add_column("first wrong stage, likely mistake", overflow="fold")
    for student in record.students:
        told = Text(one_line(about(student), 160))
        table.add_row(Text(student.name), points(student.marks.points), told)
    console.print(table)
    for each in record.copies:
        console.print(f"looks copied: {each.sentence}", soft_wrap=True)
    for remark in record.remarks:
        console.print(f"note: {remark}", soft_wrap=True)
    number = count(len(record.students), "student")
    console.print(f"{out}: {number} graded, of {points(record.of)} points", soft_wrap=True)
