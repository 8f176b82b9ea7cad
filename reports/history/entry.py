"""What a history keeps of a run: taken from its results document, and given back the same."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from minirt.quantities import QUANTITIES, STAGES
from reference.compare.check import COMPARED, UNANSWERED, Check, State
from reports.results.cells import Cell
from reports.results.json_model import Number
from reports.results.reading import read_results
from reports.results.schema import AnswerModel, CheckModel, ResultsModel, SceneModel
from reports.results.words import one_line, plain

#: Longest name of a scene or a reference in a history; longer ones are cut.
LONGEST_NAME = 255
#: The fields of a check that a history keeps.
KEPT = (
    "quantity", "state", "ratio", "pixels", "certain", "compared", "wrong", "first_wrong", "reason",
)  # fmt: skip
#: States whose reason is kept; why a reference does not give something is the same every night.
_WITH_REASON: tuple[State, ...] = ("failed", "known", *UNANSWERED)


@dataclass(frozen=True)
class AnswerEntry:
    """One scene against one reference."""

    reference: str
    program: str
    seconds: float
    checks: tuple[Check, ...]


@dataclass(frozen=True)
class SceneEntry:
    """One scene against every reference; `peak_memory` in bytes."""

    name: str
    sha256: str
    state: str
    first_wrong_stage: str
    seconds: float
    peak_memory: int
    nx: int
    ny: int
    answers: tuple[AnswerEntry, ...]

    @property
    def ratio(self) -> float | None:
        """The worst error over tolerance of all cells; None where nothing was compared."""
        found = [c.ratio for a in self.answers for c in a.checks if c.ratio is not None]
        return max(found, default=None)


@dataclass(frozen=True)
class Entry:
    """One run.

    Attributes
    ----------
    digest : str
        SHA-256 of the results document: the same run is kept once.
    judged : str
        The implementation that a gate judged, as it was named; empty for minirt itself.
    references : tuple of str
        In the order in which they were chosen.
    number : int or None
        Of the run in its history; None before it is there.

    The other fields are those of the results document.
    """

    digest: str
    judged: str
    references: tuple[str, ...]
    started: str
    outcome: str
    exit_status: int
    sentence: str
    commit: str | None
    dirty: bool | None
    system: str
    cpu: str
    cores: int
    versions: dict[str, str]
    programs: dict[str, list[str]]
    command: str
    seconds: float
    scenes: tuple[SceneEntry, ...]
    number: int | None = None

    @property
    def series(self) -> str:
        """Runs of one series asked the same question, so that their numbers can be compared."""
        return series_of(self.judged, self.references)

    def cells(self) -> Iterator[Cell]:
        """Every cell, in the order of scenes and references."""
        for scene in self.scenes:
            for answer in scene.answers:
                for check in answer.checks:
                    yield Cell(scene.name, answer.reference, check)


def series_of(judged: str, references: tuple[str, ...] | list[str]) -> str:
    """The name of a series: what was judged, or whom minirt was compared with."""
    if judged:
        return plain(f"gate: {judged}")
    return plain(f"verify: {', '.join(sorted(references))}")


def kept_name(name: str) -> str:
    """A scene's or a reference's name as a history has it: long ones stay apart by their hash."""
    text = plain(name)
    if len(text) <= LONGEST_NAME:
        return text
    mark = f"…{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    return text[: LONGEST_NAME - len(mark)] + mark


def entry_of(document: Mapping[str, Any]) -> Entry:
    """What is kept of a results document.

    Raises
    ------
    pydantic.ValidationError
        It is not one.
    """
    return _entry(ResultsModel.model_validate(document))


def _entry(model: ResultsModel) -> Entry:
    text = json.dumps(model.model_dump(mode="json"), sort_keys=True, allow_nan=False)
    stamp, verdict = model.provenance, model.verdict
    return Entry(
        digest=hashlib.sha256(text.encode()).hexdigest(),
        judged=plain(model.judged),
        references=tuple(map(kept_name, model.references)),
        started=stamp.started,
        outcome=verdict.outcome,
        exit_status=verdict.exit_status,
        sentence=plain(verdict.sentence),
        commit=stamp.commit,
        dirty=stamp.dirty,
        system=plain(stamp.system),
        cpu=plain(stamp.cpu),
        cores=stamp.cores,
        versions={plain(name): plain(version) for name, version in stamp.versions.items()},
        programs={kept_name(n): [plain(p) for p in ran] for n, ran in stamp.programs.items()},
        command=plain(stamp.command),
        seconds=stamp.seconds,
        scenes=tuple(map(_scene, model.scenes)),
    )


def read_entry(path: Path) -> Entry:
    """The run of a `results.json`, or of the folder that holds one.

    Raises
    ------
    InputError
        As for `reports.results.reading.read_results`.
    """
    return _entry(read_results(path))


def _scene(scene: SceneModel) -> SceneEntry:
    return SceneEntry(
        name=kept_name(scene.name),
        sha256=scene.sha256,
        state=scene.state,
        first_wrong_stage=scene.first_wrong_stage,
        seconds=scene.seconds,
        peak_memory=scene.peak_memory,
        nx=scene.nx,
        ny=scene.ny,
        answers=tuple(map(_answer, scene.references)),
    )


def _answer(answer: AnswerModel) -> AnswerEntry:
    checks = tuple(map(_check, answer.checks))
    return AnswerEntry(kept_name(answer.reference), plain(answer.program), answer.seconds, checks)


def _check(check: CheckModel) -> Check:
    compared = check.state in COMPARED and check.worst is not None
    return kept_check(
        quantity=check.quantity,
        state=check.state,
        ratio=_float(check.worst.ratio) if compared and check.worst else None,
        pixels=check.pixels,
        certain=check.certain,
        compared=check.compared,
        wrong=check.wrong,
        first_wrong=check.first_wrong,
        reason=one_line(check.reason) if check.state in _WITH_REASON else "",
    )


def kept_check(quantity: str, **fields: Any) -> Check:
    """A check of the fields that a history keeps: the worst pixel and similarities are not."""
    known = QUANTITIES.get(quantity)  # a newer minirt may have had others
    return Check(quantity, known.stage if known else STAGES[-1], **fields)


def kept_fields(check: Check) -> dict[str, Any]:
    """What a history keeps of a check, as its tables and `minirt report --json` name it."""
    return {name: getattr(check, name) for name in KEPT}


def _float(number: Number) -> float | None:
    value = float(number)
    return None if value != value else value
