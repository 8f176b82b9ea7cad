"""Marks from what was judged: points of each part, what lateness costs, the sum."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from datetime import datetime

from pydantic import Field

from reports.grade.assignment.assignment import Assignment
from reports.grade.assignment.rubric import LatePolicy
from reports.grade.judging.judge import MarkSheet
from reports.grade.judging.tally import credit
from reports.results.json_model import Model, Natural

#: By scene and number: for which parts of the rubric it is relevant, by minirt's own answer.
RelevantParts = Mapping[tuple[str, int], tuple[bool, ...]]

_SECONDS_A_DAY = 86_400


class PartMarks(Model):
    """One row of a student's marks."""

    name: str
    points: float
    of: float
    scenes: Natural = Field(description="public scenes that it was judged on")
    full: Natural = Field(description="of those, the ones that earn everything")
    hidden_earned: float | None = Field(
        default=None, description="points from hidden scenes; null: none"
    )
    hidden_of: float = Field(default=0.0, description="of those that hidden scenes decide")
    weakest: str = Field(default="", description="the public scene that earns least")


class Marks(Model):
    """A student's marks.

    The same results make the same marks: each part is rounded to hundredths, and the sum is of
    the rounded ones.
    """

    parts: tuple[PartMarks, ...]
    earned: float = Field(description="before lateness")
    late_days: Natural = 0
    penalty: float = Field(default=0.0, description="points that lateness costs")
    points: float
    of: float


def marks_of(
    assignment: Assignment,
    relevant: RelevantParts,
    results: Sequence[MarkSheet],
    late_days: int = 0,
) -> Marks:
    """The marks that results earn; no result of a scene earns nothing on it.

    Parameters
    ----------
    assignment : Assignment
    speaking : mapping
        For which parts each scene is relevant.
    results : sequence of SheetResult
    late_days : int
        Begun days after the deadline.
    """
    found = {(result.scene, result.number): result for result in results}
    parts = tuple(_part(assignment, relevant, found, k) for k in range(len(assignment.rubric.part)))
    earned = round(sum(part.points for part in parts), 2)
    penalty = round(_penalty(earned, assignment.rubric.late, late_days), 2)
    return Marks(
        parts=parts, earned=earned, late_days=late_days, penalty=penalty,
        points=round(earned - penalty, 2), of=round(assignment.rubric.points, 2),
    )  # fmt: skip


def days_late(late: LatePolicy | None, submitted: datetime | None) -> int:
    """Begun days after the deadline; none where either is unknown."""
    if late is None or submitted is None:
        return 0
    seconds = (submitted - late.deadline).total_seconds()
    return max(0, math.ceil(seconds / _SECONDS_A_DAY))


def _penalty(earned: float, late: LatePolicy | None, days: int) -> float:
    if late is None or days == 0:
        return 0.0
    return earned if days > late.most_days else earned * min(1.0, days * late.per_day)


def _part(
    assignment: Assignment, relevant: RelevantParts,
    found: Mapping[tuple[str, int], MarkSheet], k: int,
) -> PartMarks:  # fmt: skip
    rubric = assignment.rubric
    part = rubric.part[k]
    ends = rubric.ends(part)
    earned: dict[bool, list[tuple[float, str]]] = {True: [], False: []}
    for assigned in assignment.scenes:
        key = assigned.scene.name, assigned.number
        if relevant[key][k]:
            share = _credit(found.get(key), k, ends)
            earned[assigned.public].append((share, assigned.scene.name))
    public, hidden = (_mean([share for share, _ in earned[kind]]) for kind in (True, False))
    weight = rubric.hidden.share if rubric.hidden is not None and earned[False] else 0.0
    points = round(part.points * ((1 - weight) * public + weight * hidden), 2)
    least = min(earned[True], default=(1.0, ""))
    return PartMarks(
        name=part.name, points=points, of=part.points, scenes=len(earned[True]),
        full=sum(share == 1 for share, _ in earned[True]),
        hidden_earned=round(part.points * weight * hidden, 2) if weight else None,
        hidden_of=round(part.points * weight, 2),
        weakest=least[1] if least[0] < 1 else "",
    )  # fmt: skip


def _credit(result: MarkSheet | None, k: int, ends: tuple[float, float]) -> float:
    counted = None if result is None else result.tally(k)
    if counted is None:
        return 0.0
    return credit(counted.share, *ends) * counted.given / counted.asked


def _mean(shares: Sequence[float]) -> float:
    return sum(shares) / len(shares) if shares else 0.0
