"""The kill matrix: what a run of the mutants prints as JSON, and what a report shows of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from minirt.quantities import Stage
from reference.mutants.floor import Floor
from reference.mutants.run import MutationRun
from reports.results.json_model import Natural, read_document, spelled


class MutantRow(BaseModel):
    """One wrong version of a rule, and what the checks say of it."""

    model_config = ConfigDict(frozen=True)

    mutant: str
    rule: str
    mistake: str
    stage: Stage = Field(description="the first stage that it really breaks")
    scenes: Natural
    failed: list[str] = Field(description="scenes on which a check failed")
    charged: dict[Stage, Natural] = Field(description="by stage: pixels that are wrong there first")
    killed: bool
    found: Stage | None = Field(description="the first stage that wrong pixels are charged to")


class KillMatrix(BaseModel):
    """Every mutant that was run."""

    model_config = ConfigDict(frozen=True)

    mutants: list[MutantRow]
    killed: Natural
    right_stage: Natural
    false_alarms: Natural = Field(description="scenes on which the lecture's own rules fail")

    @property
    def sentence(self) -> str:
        """How many were noticed."""
        return (
            f"{self.killed} of {len(self.mutants)} mutants killed, {self.right_stage} by the stage "
            f"that they really break; false alarms on the lecture's own rules: {self.false_alarms}"
        )


def read_kill_matrix(path: Path) -> KillMatrix:
    """What `minirt mutants --json` printed into a file.

    Raises
    ------
    InputError
        It cannot be read, or is something else.
    """
    source = "what minirt mutants --json prints"
    return read_document(path, KillMatrix, "a matrix of mutants", source)


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
