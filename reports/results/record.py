"""A run, and the document `results.json` that holds all of it but the pictures.

The document is strict JSON. A number that JSON does not have stands as a string: "inf", "-inf"
or "nan" (a value of +inf says that nothing is hit; a ratio of "inf" is a mismatch that no
tolerance covers). `null` means that there is no such number.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from minirt.quantities import Stage
from minirt.scene import Scene
from reference.compare.check import Check, State
from reference.source import AlongRay, Declared, NormalOffset
from reference.verify.results import ReferenceResult, SceneResult
from reports.history.before import Before
from reports.results.findings import (
    SceneState,
    checks_of,
    counts,
    first_wrong_stage,
    scene_counts,
    scene_state,
)
from reports.results.json_model import Model, Natural, Number
from reports.results.judgement import JudgementModel, judgement_model
from reports.results.kills import KillMatrix
from reports.results.provenance import Provenance
from reports.results.verdict import Outcome, Verdict

#: Version of the document; it grows by adding, and changes its number when it cannot.
VERSION: Literal[1] = 1


@dataclass(frozen=True, eq=False)
class Run:
    """One run of the comparison.

    Attributes
    ----------
    results : tuple of SceneResult
        In the order in which scenes were given; digests are `reports.results.digest.digest_of`'s,
        and portraits `reports.page.portrait.portrayed`'s.
    references, required : tuple of str
        Names of the references that were chosen, and of those that must answer.
    verdict : Verdict
    provenance : Provenance
    seconds : float
        Of the whole run.
    folder : Path
        Where the reports lie.
    remarks : tuple of str
        What else is to be known of the run, in sentences: of its baseline, of what was kept.
    judged : str
        The implementation that a gate judged, as it was named; empty for minirt itself.
    before : Before or None
        What the history knows of these scenes; None without a history.
    mutants : KillMatrix or None
        Whether the checks notice known mistakes, where that was tried.
    """

    results: tuple[SceneResult, ...]
    references: tuple[str, ...]
    required: tuple[str, ...]
    verdict: Verdict
    provenance: Provenance
    seconds: float
    folder: Path
    remarks: tuple[str, ...] = ()
    judged: str = ""
    before: Before | None = None
    mutants: KillMatrix | None = None

    @property
    def exit_status(self) -> int:
        """0 passed, 1 failed, 2 no scene, 3 incomplete."""
        return self.verdict.exit_status


class WorstModel(Model):
    """The pixel where a quantity is furthest from minirt's, relative to the tolerance."""

    column: Natural = Field(description="from the left")
    row: Natural = Field(description="from the top")
    ours: list[Number]
    theirs: list[Number]
    error: Number = Field(description="Euclidean for vectors")
    tolerance: Number = Field(description="0 for a discrete quantity")
    ratio: Number = Field(description="error / tolerance; inf for a discrete mismatch")


class CheckModel(Model):
    """One quantity of one scene against one reference."""

    quantity: str
    stage: Stage
    state: State
    reason: str = Field(description="why it is not passed; empty where it is")
    pixels: Natural
    certain: Natural = Field(description="pixels whose exact answer is stable: those are judged")
    compared: Natural = Field(description="of those, where there is a value")
    floor: float = Field(description="least share of certain pixels")
    wrong: Natural
    first_wrong: Natural = Field(description="wrong pixels where no earlier stage is wrong")
    worst: WorstModel | None
    ssim: Number | None
    ssim_floor: float | None
    flip: Number | None
    flip_ceiling: float | None


class StartModel(Model):
    """Where a reference starts secondary rays: off the surface, or on it with a least length."""

    kind: Literal["normal offset", "along ray"]
    factor: float | None = None
    scale: float | None = None
    center: tuple[float, float, float] | None = None
    length: float | None = None


class DeclaredModel(Model):
    """How a reference errs on a scene; every tolerance is derived from it."""

    delta: float = Field(description="of any point of a ray or a surface, in scene units")
    vertex: float = Field(description="of a vertex or centre handed over, in scene units")
    angle: float = Field(description="of a unit vector")
    color: float = Field(description="relative, of a colour channel")
    start: StartModel | None = Field(description="of secondary rays; null: as minirt does")
    derivation: str
    slope: float = Field(description="what delta grows by per distance from the observer")
    grain: float = Field(description="further relative error of a distance from the observer")
    steps: dict[str, float] = Field(description="absolute error of the format, by quantity")
    watertight: bool = Field(description="whether no ray slips between facets that share an edge")
    near: float = Field(description="distance from the observer within which nothing is seen")


class AnswerModel(Model):
    """One scene against one reference."""

    reference: str
    program: str = Field(description="what really ran")
    seconds: float
    declared: DeclaredModel | None
    output: str = Field(description="its last output, where it gave no answer")
    checks: list[CheckModel]
    diagnosis: list[str] | None = Field(
        default=None,
        description="known mistakes that explain the failure, best first; null: none looked for",
    )


class QuorumModel(Model):
    """One quantity of one scene over all references that gave it."""

    quantity: str
    sources: list[str] = Field(description="references that gave it")
    confirmed: list[Natural] = Field(
        description="confirmed[k]: pixels at which exactly k sources judged and agree with minirt"
    )
    dissent: dict[str, Natural] = Field(description="by source: certain pixels that differ")
    alone: dict[str, Natural] = Field(
        description="of those: where all others that judged, one at least, agree with minirt"
    )


class SceneModel(Model):
    """One scene against every reference."""

    name: str
    about: str
    sha256: str = Field(description="of the scene's canonical JSON")
    rules: list[str]
    nx: int
    ny: int
    floor: float | None = Field(description="its own least share of certain pixels")
    floor_reason: str
    state: SceneState
    first_wrong_stage: str
    seconds: float = Field(description="minirt's own, stability included")
    peak_memory: Natural = Field(description="bytes, of the process that compared it")
    references: list[AnswerModel]
    quorum: list[QuorumModel] = Field(description="a quantity each")
    judgement: JudgementModel | None = Field(
        description="minirt against exact arithmetic; null where minirt itself failed"
    )


class ProvenanceModel(Model):
    """Where and from what the results came."""

    commit: str | None
    dirty: bool | None
    cpu: str
    cores: int
    system: str
    versions: dict[str, str]
    programs: dict[str, list[str]] = Field(description="what really ran, by reference")
    command: str
    started: str
    seconds: float


class VerdictModel(Model):
    """How the run ended."""

    outcome: Outcome
    exit_status: Literal[0, 1, 2, 3]
    sentence: str
    troubles: list[str]


class ResultsModel(Model):
    """Results of one run of minirt verify. Numbers that JSON does not have stand as strings."""

    minirtResults: Literal[1] = Field(description="version of this format")  # noqa: N815
    verdict: VerdictModel
    counts: dict[State, Natural] = Field(description="checks by state")
    scene_counts: dict[SceneState, Natural] = Field(description="scenes by state")
    required: list[str] = Field(description="references without which a run is incomplete")
    references: list[str]
    provenance: ProvenanceModel
    scenes: list[SceneModel]
    remarks: list[str] = Field(
        default=[], description="what else is to be known of this run, in sentences"
    )
    judged: str = Field(
        default="", description="the implementation that a gate judged; empty for minirt itself"
    )
    mutants: KillMatrix | None = Field(
        default=None,
        description="whether the checks notice known mistakes; null: not tried for this report",
    )


def results_document(run: Run) -> dict[str, Any]:
    """The document of a run, as plain JSON data."""
    model = ResultsModel(
        minirtResults=VERSION,
        verdict=VerdictModel(**asdict(run.verdict)),
        counts=counts(run.results),
        scene_counts=scene_counts(run.results),
        required=list(run.required),
        references=list(run.references),
        provenance=ProvenanceModel(
            **asdict(run.provenance), programs=programs(run), seconds=run.seconds
        ),
        scenes=[_scene(result) for result in run.results],
        remarks=list(run.remarks),
        judged=run.judged,
        mutants=run.mutants,
    )
    document: dict[str, Any] = model.model_dump(mode="json")
    return document


def results_json(run: Run) -> str:
    """`results.json` of a run; only ASCII, so that no half character can spoil it."""
    return json.dumps(results_document(run), indent=1, allow_nan=False) + "\n"


def results_schema() -> dict[str, Any]:
    """The JSON Schema of the document."""
    return ResultsModel.model_json_schema()


def programs(run: Run) -> dict[str, list[str]]:
    """What really ran, by reference: usually one program each; none where it never answered."""
    found: dict[str, list[str]] = {name: [] for name in run.references}
    for result in run.results:
        for answer in result.references:
            names = found[answer.reference]
            if answer.declared is not None and answer.program not in names:
                names.append(answer.program)
    return found


def _scene(result: SceneResult) -> SceneModel:
    scene: Scene = result.scene
    share, reason = scene.floor or (None, "")
    return SceneModel(
        name=scene.name,
        about=scene.about,
        sha256=scene.sha256,
        rules=list(scene.rules),
        nx=scene.screen.nx,
        ny=scene.screen.ny,
        floor=share,
        floor_reason=reason,
        state=scene_state(result),
        first_wrong_stage=first_wrong_stage(checks_of([result])),
        seconds=result.seconds,
        peak_memory=result.peak_memory,
        references=[_answer(answer) for answer in result.references],
        quorum=[
            QuorumModel(
                quantity=q.quantity,
                sources=list(q.sources),
                confirmed=list(q.confirmed),
                dissent=q.dissent,
                alone=q.alone,
            )
            for q in result.quorum
        ],
        judgement=judgement_model(result.judgement),
    )


def _answer(answer: ReferenceResult) -> AnswerModel:
    return AnswerModel(
        reference=answer.reference,
        program=answer.program,
        seconds=answer.seconds,
        declared=None if answer.declared is None else _declared(answer.declared),
        output=answer.output,
        checks=[_check(check) for check in answer.checks],
        diagnosis=_diagnosis(answer),
    )


def _diagnosis(answer: ReferenceResult) -> list[str] | None:
    return None if answer.diagnosis is None else [each.sentence for each in answer.diagnosis]


def _check(check: Check) -> CheckModel:
    fields = {**vars(check), "worst": _worst(check)}
    del fields["ratio"]
    return CheckModel(**fields)


def _worst(check: Check) -> WorstModel | None:
    if check.worst is None or check.ratio is None:
        return None
    return WorstModel(**vars(check.worst), ratio=check.ratio)


def _declared(declared: Declared) -> DeclaredModel:
    given = {"start": _start(declared.start), "steps": dict(declared.steps)}
    return DeclaredModel(**{**vars(declared), **given})


def _start(start: NormalOffset | AlongRay | None) -> StartModel | None:
    if start is None:
        return None
    kind: Literal["normal offset", "along ray"] = (
        "along ray" if isinstance(start, AlongRay) else "normal offset"
    )
    return StartModel(kind=kind, **vars(start))
