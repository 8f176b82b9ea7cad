"""Pages of a history: one file each, without script, server or network."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from reports.history.difference import KINDS, CellChange, Difference
from reports.history.text import (
    check_in_words,
    run_in_words,
    scenes_in_words,
    sentence_of,
    verdict_of,
)
from reports.page.template import rendered

#: Cells of a page; more of one kind are counted, not shown.
MOST_CELLS = 2000


def compare_html(found: Difference) -> str:
    """The page of what changed from one run to another."""
    kinds = [
        {"name": kind, "sign": sign, "about": about, "number": found.counts[kind]}
        for kind, (sign, about) in KINDS.items()
    ]
    return rendered(
        "compare.html.j2",
        found=found,
        good=found.regressions == 0,
        verdict=verdict_of(found),
        sentence=sentence_of(found),
        runs=[run_in_words(entry) for entry in (found.first, found.second)],
        scenes=scenes_in_words(found),
        kinds=kinds,
        groups=list(_groups(found)),
        left=max(0, len(found.notable) - MOST_CELLS),
    )


def _groups(found: Difference) -> Iterator[dict[str, Any]]:
    """The changed cells of each scene, scenes with the worst news first."""
    by_scene: dict[str, list[CellChange]] = {}
    for cell in found.notable[:MOST_CELLS]:
        by_scene.setdefault(cell.name[0], []).append(cell)
    for scene, cells in by_scene.items():
        yield {
            "scene": scene,
            "cells": [
                {
                    "reference": cell.name[1],
                    "quantity": cell.name[2],
                    "kind": cell.kind,
                    "sign": KINDS[cell.kind][0],
                    "before": check_in_words(cell.before),
                    "after": check_in_words(cell.after),
                    "reason": cell.after.reason if cell.after is not None else "",
                    "bad": cell.regression,
                }
                for cell in cells
            ],
        }
