"""A run, and its document `results.json`, which holds all of it but the pictures."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from reference.compare.check import Check
from reference.exact import Judgement, Opinion
from reference.source import AlongRay, Declared, NormalOffset
from reference.verify.results import ReferenceResult, SceneResult
from reports.history.previous import PreviousRun
from reports.results.findings import Findings, SceneFindings
from reports.results.mutants import KillMatrix
from reports.results.provenance import Provenance
from reports.results.schema import (
    MOST_LISTED,
    VERSION,
    AnswerModel,
    CheckModel,
    CountModel,
    DeclaredModel,
    JudgementModel,
    OpinionModel,
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
    findings : Findings
        Its results, summed up once for all reports. What `details_of` and `frame_thumbnail` of
        `reports.page` made while the arrays were there travels with them.
    references, required : tuple of str
        Names of the references that were chosen, and of those that must answer.
    verdict : Verdict
    provenance : Provenance
    seconds : float
        Of the whole run.
    folder : Path
        Where the reports lie.
    remarks : tuple of str
        Notes on the run, in sentences: on its baseline, on frames of earlier runs.
    judged : str
        The implementation that a gate judged, as it was named; empty for minirt itself.
    previous : PreviousRun or None
        What the history knows of these scenes; None without a history.
    mutants : KillMatrix or None
        Whether the checks notice known mistakes, where that was tried.
    """

    findings: Findings
    references: tuple[str, ...]
    required: tuple[str, ...]
    verdict: Verdict
    provenance: Provenance
    seconds: float
    folder: Path
    remarks: tuple[str, ...] = ()
    judged: str = ""
    previous: PreviousRun | None = None
    mutants: KillMatrix | None = None

    @property
    def results(self) -> tuple[SceneResult, ...]:
        """Of each scene, in the order in which scenes were given."""
        return self.findings.results

    @property
    def exit_status(self) -> int:
        """0 passed, 1 failed, 2 no scene, 3 incomplete."""
        return self.verdict.exit_status


def results_document(run: Run) -> dict[str, Any]:
    """The document of a run, as plain JSON data."""
    model = ResultsModel(
        minirtResults=VERSION,
        verdict=VerdictModel(**asdict(run.verdict)),
        counts=run.findings.checks,
        scene_counts=run.findings.scene_states,
        required=list(run.required),
        references=list(run.references),
        provenance=ProvenanceModel(
            **asdict(run.provenance), programs=run.findings.programs, seconds=run.seconds
        ),
        scenes=[_scene(scene) for scene in run.findings.scenes],
        remarks=list(run.remarks),
        judged=run.judged,
        mutants=run.mutants,
    )
    document: dict[str, Any] = model.model_dump(mode="json")
    return document


def results_json(run: Run) -> str:
    """`results.json` of a run; only ASCII, so that no half character can spoil it."""
    return json.dumps(results_document(run), indent=1, allow_nan=False) + "\n"


def _scene(found: SceneFindings) -> SceneModel:
    result = found.result
    scene = result.scene
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
        state=found.state,
        first_wrong_stage=found.first_wrong_stage,
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


def judgement_model(judgement: Judgement | None) -> JudgementModel | None:
    """The record of a judgement."""
    if judgement is None:
        return None
    return JudgementModel(
        pixels=judgement.pixels,
        seconds=judgement.seconds,
        counts=[CountModel(**vars(each)) for each in judgement.counts],
        convicted=len(judgement.convictions),
        convictions=[_opinion(each) for each in judgement.convictions[:MOST_LISTED]],
    )


def _opinion(opinion: Opinion) -> OpinionModel:
    return OpinionModel(
        quantity=opinion.quantity,
        column=opinion.column,
        row=opinion.row,
        ours=list(opinion.ours),
        exact=list(opinion.exact),
        ulps=opinion.ulps,
    )
