"""Whether results agree with themselves: no state is better than what lies below it.

A document that was edited by hand, or that a broken program wrote, must not make a wrong image
pass in a history.
"""

from __future__ import annotations

from minirt.errors import InputError
from reports.results.findings import SceneState
from reports.results.record import CheckModel, ResultsModel, SceneModel
from reports.results.verdict import Outcome
from reports.results.words import one_line

_STATUS: dict[Outcome, int] = {"passed": 0, "failed": 1, "empty": 2, "incomplete": 3}


def require_borne_out(model: ResultsModel) -> None:
    """Let only results pass whose states are those of what lies below them.

    Raises
    ------
    InputError
        The first state that is not: where it stands, and what it should be.
    """
    for scene in model.scenes:
        for answer in scene.references:
            for check in answer.checks:
                if check.state == "passed" and _fails(check):
                    place = f"{scene.name} × {answer.reference} × {check.quantity}"
                    raise _contradiction(place, check.state, "failed")
        state = _state_of(scene)
        if scene.state != state:
            raise _contradiction(scene.name, scene.state, state)
    verdict, outcomes = model.verdict, _outcomes_of(model)
    if verdict.outcome not in outcomes:
        raise _contradiction("verdict.outcome", verdict.outcome, " or ".join(outcomes))
    if verdict.exit_status != _STATUS[verdict.outcome]:
        status = str(_STATUS[verdict.outcome])
        raise _contradiction("verdict.exit_status", str(verdict.exit_status), status)


def _contradiction(place: str, got: str, expected: str) -> InputError:
    return InputError(
        "the results contradict themselves", where=one_line(place), got=got, expected=expected
    )


def _fails(check: CheckModel) -> bool:
    """Whether the numbers of a check are those of a failure."""
    beyond = check.worst is not None and float(check.worst.ratio) > 1
    return check.wrong > 0 or beyond or check.certain < check.floor * check.pixels


def _state_of(scene: SceneModel) -> SceneState:
    """As `reports.results.findings.scene_state`, of the record."""
    states = {check.state for answer in scene.references for check in answer.checks}
    if "failed" in states or (scene.judgement is not None and scene.judgement.convicted):
        return "failed"
    if states & {"crashed", "timed out"}:
        return "incomplete"
    return "passed" if states & {"passed", "known"} else "not compared"


def _outcomes_of(model: ResultsModel) -> tuple[Outcome, ...]:
    """How a run of these scenes can have ended: what was required may have been missing besides."""
    states = {scene.state for scene in model.scenes}
    if not states:
        return ("empty",)
    if "failed" in states:
        return ("failed",)
    if "incomplete" in states or "passed" not in states:
        return ("incomplete",)
    return "passed", "incomplete"
