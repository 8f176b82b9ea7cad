"""Runs as rows of the tables, and rows as runs again."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby
from typing import Any

from sqlalchemy import Connection, Row, select

from reference.compare.check import Check
from reports.history.entry import KEPT, AnswerEntry, Entry, SceneEntry, kept_check, kept_fields
from reports.history.tables import answers, cells, runs, scenes


def run_row(entry: Entry) -> dict[str, Any]:
    """The row of a run without what lies below it."""
    kept = {name: value for name, value in vars(entry).items() if name not in ("scenes", "number")}
    return kept | {"series": entry.series, "references": list(entry.references)}


def scene_row(scene: SceneEntry, run: int) -> dict[str, Any]:
    """The row of a scene."""
    kept = {name: value for name, value in vars(scene).items() if name != "answers"}
    return kept | {"run_id": run, "ratio": scene.ratio}


def answer_row(answer: AnswerEntry, scene: int) -> dict[str, Any]:
    """The row of what a reference answered."""
    return {
        "scene_id": scene, "reference": answer.reference,
        "program": answer.program, "seconds": answer.seconds,
    }  # fmt: skip


def cell_row(check: Check, answer: int) -> dict[str, Any]:
    """The row of a cell."""
    return {"answer_id": answer, **kept_fields(check)}


def entry_from(connection: Connection, number: int) -> Entry:
    """A run by its number, which exists."""
    run = connection.execute(select(runs).where(runs.c.id == number)).one()._asdict()
    del run["id"], run["series"]
    run["references"] = tuple(run["references"])
    found = connection.execute(
        select(scenes).where(scenes.c.run_id == number).order_by(scenes.c.id)
    )
    below = _answers(connection, number)
    return Entry(**run, scenes=tuple(_scene(row, below) for row in found), number=number)


def _answers(connection: Connection, number: int) -> dict[int, list[AnswerEntry]]:
    """What was answered, by the scene's key."""
    asked = (
        select(answers, cells)
        .join(scenes, scenes.c.id == answers.c.scene_id)
        .outerjoin(cells, cells.c.answer_id == answers.c.id)
        .where(scenes.c.run_id == number)
        .order_by(answers.c.id)
    )
    found: dict[int, list[AnswerEntry]] = {}
    rows = connection.execute(asked)
    for _, group in groupby(rows, key=lambda row: row.id):
        lines = list(group)
        first = lines[0]
        answer = AnswerEntry(first.reference, first.program, first.seconds, tuple(_checks(lines)))
        found.setdefault(first.scene_id, []).append(answer)
    return found


def _checks(rows: Iterable[Row[Any]]) -> list[Check]:
    return [
        kept_check(**{name: getattr(row, name) for name in KEPT})
        for row in rows
        if row.quantity is not None
    ]


def _scene(row: Row[Any], below: dict[int, list[AnswerEntry]]) -> SceneEntry:
    kept = row._asdict()
    key = kept.pop("id")
    del kept["run_id"], kept["ratio"]
    return SceneEntry(**kept, answers=tuple(below.get(key, ())))
