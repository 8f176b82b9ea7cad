"""Runs for the tests of the history, in a moment: documents with known numbers, no renderer."""

from __future__ import annotations

import copy
from dataclasses import replace
from functools import cache
from typing import Any

from reports.history.entry import Entry, entry_of
from reports.history.store import History
from reports.results.cells import Cell
from reports.results.record import results_document
from tests.helpers.report_runs import good_run


@cache
def _document() -> dict[str, Any]:
    return results_document(good_run())


def document() -> dict[str, Any]:
    """The results of two scenes that pass."""
    return copy.deepcopy(_document())


def entry(mark: int = 0, **changes: Any) -> Entry:
    """A run of two scenes that pass, with other facts in it; another run for each mark."""
    return replace(entry_of(document()), **{"digest": f"{mark:064}", **changes})


def with_cell(run: Entry, **changes: Any) -> Entry:
    """A run with another first cell (its scene `ball`, its reference `honest`)."""
    scene, *scenes = run.scenes
    answer, *answers = scene.answers
    check, *checks = answer.checks
    answer = replace(answer, checks=(replace(check, **changes), *checks))
    state = "failed" if changes.get("state") == "failed" else scene.state
    scene = replace(scene, answers=(answer, *answers), state=state)
    return replace(run, scenes=(scene, *scenes), digest=run.digest[::-1])


def sorted_cells(run: Entry) -> list[Cell]:
    """Every cell, in an order of their own; there must be some."""
    found = sorted(run.cells(), key=lambda cell: cell.name)
    assert found
    return found


def whole(history: History, number: int, cells: int) -> Entry:
    """A run of which nothing is missing."""
    run = history.entry(number)
    assert len(run.scenes) == 2
    assert sum(1 for _ in run.cells()) == cells
    return run
