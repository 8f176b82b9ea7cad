"""One cell of a comparison, and how the cells of a scene or of a reference ended."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

from minirt.quantities import STAGES
from reference.compare.check import Check, State
from reference.verify.results import ReferenceResult, SceneResult
from reports.results.words import STATES

#: Names of a scene, a reference and a quantity.
CellName = tuple[str, str, str]
#: How a scene can end over all its references.
SceneState = Literal["failed", "incomplete", "passed", "not compared"]


@dataclass(frozen=True)
class Cell:
    """A check with the names of its scene and its reference: in a run, a report or a history.

    Attributes
    ----------
    scene, reference : str
    check : Check
    """

    scene: str
    reference: str
    check: Check

    @property
    def name(self) -> CellName:
        """Scene, reference and quantity, which no other cell of a run shares."""
        return self.scene, self.reference, self.check.quantity


def cells_of(results: Iterable[SceneResult]) -> Iterator[Cell]:
    """Every cell of every scene and reference, in their order."""
    for result in results:
        for answer in result.references:
            for check in answer.checks:
                yield Cell(result.scene.name, answer.reference, check)


def scene_state(result: SceneResult) -> SceneState:
    """How one scene ended against all its references and exact arithmetic."""
    states = {check.state for answer in result.references for check in answer.checks}
    if "failed" in states or (result.judgement is not None and result.judgement.convictions):
        return "failed"
    if states & {"crashed", "timed out"}:
        return "incomplete"
    return "passed" if states & {"passed", "known"} else "not compared"


def answer_state(answer: ReferenceResult) -> State:
    """How one reference did on one scene: the worst of its checks' states."""
    found = {check.state for check in answer.checks}
    return next((state for state in STATES if state in found), "not given")


def first_wrong_stage(checks: Iterable[Check]) -> str:
    """The earliest stage at which any pixel is wrong; empty where none is."""
    wrong = {check.stage for check in checks if check.first_wrong}
    return next((stage for stage in STAGES if stage in wrong), "")


def worst_check(checks: Iterable[Check]) -> Check | None:
    """The check with the largest error over tolerance; None where nothing was compared."""
    return max(
        (c for c in checks if c.ratio is not None), key=lambda c: c.ratio or 0.0, default=None
    )


def least_certain(checks: Iterable[Check]) -> Check | None:
    """The compared check with the smallest share of certain pixels."""
    compared = [check for check in checks if check.pixels]
    return min(compared, key=lambda c: c.certain / c.pixels, default=None)
