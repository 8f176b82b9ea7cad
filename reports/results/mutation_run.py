"""A run of the mutants in a sentence, as an exit status and as a document."""

from __future__ import annotations

from typing import Any

from reference.mutants.floor import Floor
from reference.mutants.run import MutationRun
from reports.results.json_model import spelled


def mutants_status(run: MutationRun) -> int:
    """1 where one is not noticed or the right one is accused; else 3 where one crashed; else 0."""
    if run.false_alarms or run.survivors:
        return 1
    return 3 if run.crashed else 0


def mutants_sentence(run: MutationRun) -> str:
    """How many were killed, by which stage, and how many could not be run."""
    return (
        f"{run.killed} of {len(run.mutants)} mutants killed, {run.right_stage} by the stage that "
        "they really break; false alarms on the lecture's own rules: "
        f"{run.false_alarms} of {run.original.scenes} scenes"
        + (f"; {len(run.crashed)} crashed" if run.crashed else "")
    )


def mutants_document(run: MutationRun, floor: Floor) -> dict[str, Any]:
    """The kill matrix as JSON data."""
    rows = [
        vars(row) | {"failed": list(row.failed), "killed": row.killed, "found": row.found}
        for row in run.mutants
    ]
    return {
        "mutants": rows,
        "killed": run.killed,
        "right_stage": run.right_stage,
        "false_alarms": run.false_alarms,
        "floor": {name: spelled(value) for name, value in vars(floor).items()},
        **({"crashed": dict(run.crashed)} if run.crashed else {}),
    }
