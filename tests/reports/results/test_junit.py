from __future__ import annotations

import io
from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import pytest
from junitparser import JUnitXml, TestCase

from reports.results.junit import junit_xml
from reports.results.record import Run
from reports.results.verdict import decide
from tests.helpers.report_runs import NAMES, empty_run, good_run, troubled_run


def cases(run: Run) -> list[TestCase]:
    report = JUnitXml.fromfile(io.BytesIO(junit_xml(run).encode()))
    return [case for suite in report for case in suite]


def outcome(case: TestCase) -> str:
    return ",".join(sorted({type(result).__name__ for result in case.result})) or "Passed"


def test_one_case_for_each_scene_reference_and_quantity() -> None:
    run = good_run()
    found = cases(run)
    assert len(found) == len(run.results) * len(run.references) * len(NAMES)
    assert {outcome(case) for case in found} == {"Passed"}
    assert [case.name for case in found[:20]] == list(NAMES)
    assert {case.classname for case in found} == {"ball.honest", "second.honest"}


def test_a_references_time_is_shared_out_among_its_cases() -> None:
    run = good_run()
    for suite, result in zip(JUnitXml.fromfile(io.BytesIO(junit_xml(run).encode())), run.results,
                             strict=True):  # fmt: skip
        total = result.seconds * (result.judgement is not None)
        total += sum(answer.seconds for answer in result.references)
        assert suite.time == pytest.approx(total, abs=1e-3)
        assert all(case.time > 0 for case in suite)


def test_states_become_failures_skips_and_errors() -> None:
    run = troubled_run()
    by_state = run.findings.checks
    troubles = 1
    assert Counter(map(outcome, cases(run))) == {
        "Passed": by_state["passed"],
        "Failure": by_state["failed"],
        "Skipped": by_state["not given"] + by_state["not supported"],
        "Error": by_state["crashed"] + by_state["timed out"] + by_state["missing"] + troubles,
    }


def test_a_failure_names_the_worst_pixel_with_both_values() -> None:
    case = next(
        c for c in cases(troubled_run()) if "one-pixel" in c.classname and c.name == "depth"
    )
    assert "1 of 1728 certain pixels wrong" in case.result[0].message
    assert "(20, 31): ours 4.3" in case.result[0].text


def test_an_error_holds_the_last_output() -> None:
    case = next(c for c in cases(troubled_run()) if c.classname == "ball.aborting")
    assert case.result[0].message == "crashed: the process was ended by SIGABRT"
    assert "LLVM ERROR: cannot" not in case.result[0].message
    assert "LLVM ERROR: <img src=x" in case.result[0].text


def test_a_missing_reference_that_is_not_required_is_skipped_with_its_reason() -> None:
    run = replace(troubled_run(), required=())
    found = [case for case in cases(run) if case.classname == "ball.missing"]
    assert {outcome(case) for case in found} == {"Skipped"}
    assert found[0].result[0].message == "missing: not installed: pip install <nothing>"


@pytest.mark.parametrize("make_run", [empty_run, troubled_run])
def test_what_keeps_a_run_from_being_complete_is_an_error(make_run: Callable[[], Run]) -> None:
    run = make_run()
    last = cases(run)[-1]
    assert last.name == "complete"
    assert [result.message for result in last.result] == list(run.verdict.troubles)
    assert last.is_error


def test_required_but_not_chosen_is_an_error() -> None:
    run = good_run()
    verdict = decide(run.findings, run.references, ["elsewhere"])
    last = cases(replace(run, verdict=verdict))[-1]
    assert last.result[0].message == "elsewhere is required and was not chosen"
