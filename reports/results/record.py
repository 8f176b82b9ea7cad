"""A run, and its document `results.json`, which holds all of it but the pictures."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from minirt.scene import Scene
from reference.compare.check import Check
from reference.source import AlongRay, Declared, NormalOffset
from reference.verify.results import ReferenceResult, SceneResult
from reports.history.previous import PreviousRun
from reports.results.cells import first_wrong_stage
from reports.results.findings import (
    checks_of,
    counts,
    scene_counts,
    scene_state,
)
from reports.results.judgement import judgement_model
from reports.results.mutant_matrix import MutantMatrix
from reports.results.provenance import Provenance
from reports.results.schema import (
    VERSION,
    AnswerModel,
    CheckModel,
    DeclaredModel,
    ProvenanceModel,
    QuorumModel,
    ResultsModel,
    SceneModel,
    StartModel,
    VerdictModel,
    WorstModel,
)
from reports.results.verdict import Verdict


@dataclass(frozen=True, eq=False)
class Run:
    """One run of the comparison.

    Attributes
    ----------
    results : tuple of SceneResult
        In the order in which scenes were given; what `details_of` and `frame_thumbnail` of
        `reports.page` made while their arrays were there travels with them.
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
    previous : PreviousRun or None
        What the history knows of these scenes; None without a history.
    mutants : MutantMatrix or None
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
    previous: PreviousRun | None = None
    mutants: MutantMatrix | None = None

    @property
    def exit_status(self) -> int:
        """0 passed, 1 failed, 2 no scene, 3 incomplete."""
        return self.verdict.exit_status


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
