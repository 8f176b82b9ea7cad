"""A `results.json`, read again: one that is whole, of this format, and consistent.

In consistent results no state is better than the numbers below it: a document that was edited by
hand, or that a broken program wrote, must not make a wrong image pass in a history.
"""

from __future__ import annotations

import json
from pathlib import Path

from pydantic import ValidationError

from minirt.errors import InputError
from reports.results.cells import SceneState
from reports.results.schema import CheckModel, ResultsModel, SceneModel
from reports.results.verdict import Outcome
from reports.results.words import one_line

_STATUS: dict[Outcome, int] = {"passed": 0, "failed": 1, "empty": 2, "incomplete": 3}


def read_results(path: Path) -> ResultsModel:
    """The results in a file, or in the `results.json` of a folder.

    Raises
    ------
    InputError
        They cannot be read, are no results document, or say of a check, a scene or the run what
        lies below does not bear out.
    """
    file = path / "results.json" if path.is_dir() else path
    try:
        model = ResultsModel.model_validate(json.loads(file.read_text(encoding="utf-8")))
        require_consistent(model)
    except InputError as error:
        where = f"{file}, {error.where}"
        raise InputError(error.what, where=where, got=error.got, expected=error.expected) from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError("cannot be read", where=str(file), got=reason) from None
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        got = one_line(f"{place}: {first['msg']}" if place else first["msg"])
        raise InputError(
            "not the results of a run", where=str(file), got=got,
            expected="a results.json of minirt verify or gate",
        ) from None  # fmt: skip
    except (ValueError, RecursionError) as error:
        raise InputError("not JSON", where=str(file), got=one_line(str(error))) from None
    return model


def require_consistent(model: ResultsModel) -> None:
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
    """As `reports.results.cells.scene_state`, of the record."""
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
