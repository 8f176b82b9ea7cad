from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable
from typing import Any

import jsonschema
import pytest

from reference.compare.check import Check, WorstPixel
from reference.source import AlongRay, Declared, NormalOffset
from reference.verify.results import ReferenceResult, SceneResult
from reports.results.findings import findings_of
from reports.results.record import Run, results_document, results_json
from reports.results.schema import results_schema
from reports.results.words import STATES
from tests.helpers.fake_references import HOSTILE, small_scene
from tests.helpers.report_runs import NAMES, empty_run, good_run, troubled_run


def strictly(text: str) -> Any:
    """JSON as the standard has it: no NaN, no Infinity."""

    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is not JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.mark.parametrize("make_run", [good_run, troubled_run, empty_run])
def test_document_is_strict_json_and_fits_its_schema(make_run: Callable[[], Run]) -> None:
    run = make_run()
    document = strictly(results_json(run))
    jsonschema.validate(document, results_schema(), jsonschema.Draft202012Validator)
    assert document["minirtResults"] == 1
    assert document["verdict"]["exit_status"] == run.exit_status
    assert sum(document["counts"].values()) == len(run.results) * len(run.references) * 20


@pytest.mark.parametrize(
    ("path", "wrong"),
    [
        (["minirtResults"], 2),
        (["counts", "passed"], -1),
        (["scenes", 0, "references", 0, "checks", 0, "state"], "fine"),
        (["scenes", 0, "references", 0, "checks", 0, "ssim"], "NaN"),
        (["unheard"], 1),
    ],
)
def test_schema_refuses_what_is_wrong(path: list[Any], wrong: Any) -> None:
    document = copy.deepcopy(results_document(good_run()))
    place = document
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = wrong
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, results_schema(), jsonschema.Draft202012Validator)


def test_schema_itself_is_valid() -> None:
    jsonschema.Draft202012Validator.check_schema(results_schema())
    assert results_schema()["properties"]["minirtResults"]["const"] == 1


def test_document_holds_every_cell_with_its_reason() -> None:
    document = results_document(troubled_run())
    scene = document["scenes"][0]
    assert scene["name"] == HOSTILE
    assert len(scene["sha256"]) == 64
    seen = set()
    for answer in scene["references"]:
        assert [check["quantity"] for check in answer["checks"]] == list(NAMES)
        for check in answer["checks"]:
            seen.add(check["state"])
            assert bool(check["reason"]) == (check["state"] != "passed")
    assert seen == set(STATES) - {"known"}  # there is no baseline
    by_name = {answer["reference"]: answer for answer in scene["references"]}
    assert by_name["honest"]["declared"]["derivation"] == "256 roundings of 2⁻⁵²"
    assert "LLVM ERROR" in by_name["aborting"]["output"]
    assert by_name["aborting"]["declared"] is None
    assert document["provenance"]["programs"]["one-pixel"] == ["minirt as one-pixel"]
    assert document["provenance"]["programs"]["missing"] == []


def test_worst_pixel_travels_with_both_values() -> None:
    answer = results_document(troubled_run())["scenes"][0]["references"][1]
    depth = next(check for check in answer["checks"] if check["quantity"] == "depth")
    assert (depth["wrong"], depth["worst"]["column"], depth["worst"]["row"]) == (1, 20, 31)
    assert depth["worst"]["theirs"][0] == pytest.approx(1.001 * depth["worst"]["ours"][0])
    shadow = next(check for check in answer["checks"] if check["quantity"] == "shadow")
    assert shadow["worst"]["ratio"] == "inf"


def test_numbers_that_json_does_not_have_are_strings() -> None:
    worst = WorstPixel(0, 0, (math.nan, -math.inf), (math.inf, 1.0), math.inf, 0.0)
    check = Check(
        "barycentric",
        "t",
        "failed",
        "wrong",
        1,
        1,
        1,
        wrong=1,
        ratio=math.inf,
        worst=worst,
        ssim=math.nan,
    )
    start: tuple[NormalOffset | AlongRay | None, ...] = (NormalOffset(0.1), AlongRay(0.2), None)
    answers = tuple(
        ReferenceResult("r", "r", (check,), Declared(1.0, 0.0, 0.0, 0.0, s, "why")) for s in start
    )
    known = good_run()
    run = Run(
        findings_of([SceneResult(small_scene(), answers)], ["r"]), ("r",), (), known.verdict,
        known.provenance, 1.0, known.folder,
    )  # fmt: skip
    document = strictly(results_json(run))
    jsonschema.validate(document, results_schema(), jsonschema.Draft202012Validator)
    first = document["scenes"][0]["references"][0]["checks"][0]
    assert first["worst"]["ours"] == ["nan", "-inf"]
    assert (first["worst"]["theirs"], first["worst"]["error"]) == (["inf", 1.0], "inf")
    assert first["ssim"] == "nan"
    starts = [a["declared"]["start"] for a in document["scenes"][0]["references"]]
    assert starts[0]["kind"] == "normal offset"
    assert (starts[1]["kind"], starts[1]["length"]) == ("along ray", 0.2)
    assert starts[2] is None


def test_provenance_says_where_the_numbers_come_from() -> None:
    origin = results_document(good_run())["provenance"]
    assert set(origin["versions"]) == {"minirt", "Python", "NumPy"}
    assert all(origin[key] for key in ("cpu", "cores", "system", "command", "started"))
    assert (origin["commit"] is None) == (origin["dirty"] is None)
