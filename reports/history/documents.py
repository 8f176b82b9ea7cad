"""What `minirt report --json` prints, as plain JSON data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from reference.compare.check import Check
from reports.history.difference import Difference
from reports.history.entry import Entry, kept_fields
from reports.history.previous import Point
from reports.history.trends import changes_of
from reports.results.json_model import spelled


def difference_document(found: Difference) -> dict[str, Any]:
    """What changed from one run to another."""
    return {
        "first": _run(found.first),
        "second": _run(found.second),
        "counts": found.counts,
        "same": found.same,
        "regressions": found.regressions,
        "scenes": {
            "new": found.new, "gone": found.gone, "altered": found.altered,
            "renamed": found.renamed,
        },
        "origin": found.origin,
        "cells": [
            {
                "scene": cell.name[0], "reference": cell.name[1], "quantity": cell.name[2],
                "kind": cell.kind, "before": _check(cell.before), "after": _check(cell.after),
            }
            for cell in found.cells
        ],
    }  # fmt: skip


def trend_document(series: str, trend: Sequence[Point]) -> dict[str, Any]:
    """The runs of a scene in one series, and where it changed."""
    return {
        "series": series,
        "runs": [{key: spelled(value) for key, value in asdict(p).items()} for p in trend],
        "changes": [
            {"before": c.before.run, "after": c.after.run, "better": c.better, "what": c.what}
            for c in changes_of(trend)
        ],
    }


def _run(entry: Entry) -> dict[str, Any]:
    kept = ("number", "started", "commit", "dirty", "outcome", "exit_status", "sentence")
    return {name: getattr(entry, name) for name in kept}


def _check(check: Check | None) -> dict[str, Any] | None:
    return None if check is None else {k: spelled(v) for k, v in kept_fields(check).items()}
