"""A failing scene explained to the student: the likely mistake, and one pixel in numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydantic import Field

from minirt.explain.pixel import explain
from minirt.quantities import QUANTITIES
from reference.diagnose.by_mutant import Diagnosis, diagnose
from reports.explain.second_opinion import Row, rows_at
from reports.explain.text import explanation_text
from reports.grade.assignment.assignment import AssignedScene
from reports.grade.judging.judge import JudgingContext, MarkSheet, judge_again
from reports.grade.submission.submission import Submission
from reports.results.json_model import Model, Natural
from reports.results.words import number, values


class PixelValue(Model):
    """One quantity of a pixel, in words."""

    quantity: str
    stage: str
    ours: str
    theirs: str
    error: str
    tolerance: str
    state: str = Field(description="agrees, wrong, or uncertain: not judged")


class FailureExplanation(Model):
    """A failing public scene, explained."""

    scene: str
    stage: str
    quantity: str
    rule: str = Field(description="of the lecture: the mistake's, or the quantity's first")
    mistake: str = Field(description="what explains the failure, in a clause; empty: unknown")
    name: str = Field(description="of the mistake; empty: unknown")
    pixel: tuple[Natural, Natural] = Field(description="column from the left, row from the top")
    lines: tuple[PixelValue, ...]
    explanation: str


def explain_failure(
    context: JudgingContext,
    assigned: AssignedScene,
    submission: Submission,
    folder: Path,
    result: MarkSheet,
) -> FailureExplanation:
    """Explain a failing scene. Runs in a child process."""
    scene = assigned.scene
    evidence = judge_again(context, assigned, submission, folder)
    found = diagnose(evidence)[:1]
    column, row = result.pixel or (0, 0)
    rule = QUANTITIES[result.quantity].rules[0]
    return FailureExplanation(
        scene=scene.name, stage=result.stage, quantity=result.quantity,
        rule=next((each.rule for each in found if isinstance(each, Diagnosis)), rule),
        mistake="".join(each.sentence for each in found),
        name="".join(each.name for each in found),
        pixel=(column, row),
        lines=tuple(_pixel_value(each) for each in rows_at(row, column, evidence)),
        explanation=explanation_text(explain(scene, column, row)),
    )  # fmt: skip


def _pixel_value(row: Row) -> PixelValue:
    discrete = QUANTITIES[row.quantity].discrete
    shown = discrete or not np.isfinite(row.error)
    state = "uncertain" if np.isnan(row.ratio) else "wrong" if row.wrong else "agrees"
    return PixelValue(
        quantity=row.quantity, stage=row.stage, ours=values(row.quantity, list(row.ours)),
        theirs=values(row.quantity, list(row.theirs)), error="" if shown else number(row.error),
        tolerance="" if discrete else number(row.tolerance), state=state,
    )  # fmt: skip
