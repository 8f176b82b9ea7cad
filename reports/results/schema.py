"""The document `results.json`: its records, as JSON Schema describes them.

The document is strict JSON. A number that JSON does not have stands as a string: "inf", "-inf"
or "nan" (a value of +inf says that nothing is hit; a ratio of "inf" is a mismatch that no
tolerance covers). `null` means that there is no such number.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from minirt.quantities import Stage
from reference.compare.check import State
from reports.results.cells import SceneState
from reports.results.json_model import Model, Natural, Number
from reports.results.mutants import KillMatrix
from reports.results.verdict import Outcome

#: Version of the document; it grows by adding, and changes its number when it cannot.
VERSION: Literal[1] = 1
#: Contradictions with exact arithmetic that are listed of a scene; their number is always given.
MOST_LISTED = 20


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


class OpinionModel(Model):
    """One quantity of one pixel where minirt does not have the exact answer."""

    quantity: str
    column: Natural = Field(description="from the left")
    row: Natural = Field(description="from the top")
    ours: list[Number]
    exact: list[Number]
    ulps: Number | None = Field(description="error in ulp of the bound; null for a discrete one")


class CountModel(Model):
    """One quantity over the pixels that were judged."""

    quantity: str
    judged: Natural = Field(description="pixels where it applies")
    decided: Natural = Field(description="of those, where the exact answer is certain")
    agreed: Natural = Field(description="of those, where minirt has it")
    ulps: Number | None = Field(description="largest error in ulp of the bound; 4 are allowed")


class JudgementModel(Model):
    """minirt against exact arithmetic on one scene."""

    pixels: Natural
    seconds: float
    counts: list[CountModel]
    convicted: Natural = Field(description="certain exact answers that minirt does not give")
    convictions: list[OpinionModel] = Field(description=f"the first {MOST_LISTED}")


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
    remarks: list[str] = Field(default=[], description="notes on this run, in sentences")
    judged: str = Field(
        default="", description="the implementation that a gate judged; empty for minirt itself"
    )
    mutants: KillMatrix | None = Field(
        default=None,
        description="whether the checks notice known mistakes; null: not tried for this report",
    )


def results_schema() -> dict[str, Any]:
    """The JSON Schema of the document."""
    return ResultsModel.model_json_schema()
