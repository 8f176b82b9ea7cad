"""A baseline: failures of an implementation that are known, each with a reason and a date.

With one, a gate can be switched on in a project that does not pass yet: what is listed is excused
until its date; what fails beyond it fails the gate.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path
from typing import Literal

from pydantic import Field

from converters.atomic import atomic_file
from reference.compare.check import Check, State
from reference.verify.results import ReferenceResult, SceneResult
from reports.results.json_model import Model, Natural, read_document

#: States that a baseline can excuse.
_EXCUSED: tuple[State, ...] = ("failed", "crashed", "timed out")


class Entry(Model):
    """One known failure."""

    scene: str
    quantity: str
    wrong: Natural | None = Field(
        default=None, description="wrong pixels that are excused, and no more; null: any number"
    )
    reason: str = Field(description="why it fails, or who is at work on it")
    until: date = Field(description="the last day on which it is excused")


class BaselineModel(Model):
    """The file: known failures of one implementation."""

    minirtBaseline: Literal[1] = Field(description="version of this format")  # noqa: N815
    known: list[Entry]


@dataclass(frozen=True)
class Baseline:
    """Known failures, as of a day.

    Attributes
    ----------
    entries : tuple of Entry
    today : date
    """

    entries: tuple[Entry, ...]
    today: date

    def applied(self, results: Sequence[SceneResult]) -> tuple[list[SceneResult], tuple[str, ...]]:
        """Results in which known failures are `known`, and what is to be said of the entries.

        An entry that is past its date excuses nothing; one that passes again is to be removed.
        """
        due = {(e.scene, e.quantity): e for e in self.entries}
        kept = [
            replace(
                result, references=tuple(self._excused(result, a, due) for a in result.references)
            )
            for result in results
        ]
        return kept, tuple(self._remarks(results))

    def _excused(
        self, result: SceneResult, answer: ReferenceResult, due: dict[tuple[str, str], Entry]
    ) -> ReferenceResult:
        checks = tuple(
            self._known(check, due.get((result.scene.name, check.quantity)))
            for check in answer.checks
        )
        return replace(answer, checks=checks)

    def _known(self, check: Check, entry: Entry | None) -> Check:
        if entry is None or check.state not in _EXCUSED:
            return check
        if entry.until < self.today:
            late = f"{check.reason} (known: {entry.reason}; excused until {entry.until})"
            return replace(check, reason=late)
        if entry.wrong is not None and check.wrong > entry.wrong:
            more = f"{check.reason}; {entry.wrong} were excused ({entry.reason})"
            return replace(check, reason=more)
        reason = f"{entry.reason} (until {entry.until}): {check.state}, {check.reason}"
        return replace(check, state="known", reason=reason)

    def _remarks(self, results: Sequence[SceneResult]) -> list[str]:
        states = {
            (result.scene.name, check.quantity): check.state
            for result in results
            for answer in result.references
            for check in answer.checks
        }
        remarks = []
        for entry in self.entries:
            state = states.get((entry.scene, entry.quantity))
            what = f"{entry.scene} × {entry.quantity}"
            if state == "passed":
                remarks.append(f"{what} passes again: take it out with --update-baseline")
            elif state in _EXCUSED and entry.until < self.today:
                remarks.append(f"{what} was excused until {entry.until} and fails still")
        return remarks


def read_baseline(path: Path, today: date) -> Baseline:
    """The baseline in a file.

    Raises
    ------
    InputError
        It cannot be read, or is no baseline.
    """
    source = "a file that minirt gate --update-baseline wrote"
    model = read_document(path, BaselineModel, "a baseline", source)
    return Baseline(tuple(model.known), today)


def write_baseline(
    path: Path, results: Sequence[SceneResult], old: Baseline, reason: str, until: date
) -> int:
    """Record every failure of a run as known; give their number.

    What was known before keeps its reason and its date while it lasts, with the number of wrong
    pixels that it has now; entries of scenes that the run did not hold stay.
    """
    before = {(entry.scene, entry.quantity): entry for entry in old.entries}
    ran = {result.scene.name for result in results}
    failing = {
        (result.scene.name, check.quantity): check.wrong
        for result in results
        for answer in result.references
        for check in answer.checks
        if check.state in (*_EXCUSED, "known")
    }
    kept = [entry for entry in old.entries if entry.scene not in ran]
    for (scene, quantity), wrong in sorted(failing.items()):
        entry = before.get((scene, quantity))
        if entry is None or entry.until < old.today:
            entry = Entry(scene=scene, quantity=quantity, reason=reason, until=until)
        kept.append(entry.model_copy(update={"wrong": wrong}))
    model = BaselineModel(minirtBaseline=1, known=kept)
    with atomic_file(path) as temporary:
        document = json.dumps(model.model_dump(mode="json"), indent=1, ensure_ascii=False)
        temporary.write_text(document + "\n", encoding="utf-8")
    return len(failing)
