"""`junit.xml`: one test case per scene, reference and quantity, as CI systems read them."""

from __future__ import annotations

from junitparser import Error, Failure, JUnitXml, Skipped, TestCase, TestSuite

from reference.compare.check import Check
from reference.exact import Judgement
from reference.verify.results import ReferenceResult, SceneResult
from reports.results.record import Run
from reports.results.schema import MOST_LISTED
from reports.results.words import (
    judgement_in_words,
    one_line,
    opinion_in_words,
    plain,
    worst_in_words,
)


def junit_xml(run: Run) -> str:
    """The test report of a run.

    A check that failed is a failure; a quantity not given or not supported is skipped, with the
    reason; each case of a reference that crashed, timed out or is missing is an error. A missing
    reference that is not required is skipped: it does not fail the run. What keeps a run
    from being complete is one more case, so that a run of 0 scenes cannot be taken for a pass.
    A reference's time for a scene is shared out among its cases.
    """
    report = JUnitXml("minirt")
    for result in run.results:
        report.add_testsuite(_suite(result, run.required))
    if run.verdict.troubles:
        report.add_testsuite(_troubles(run))
    report.update_statistics()
    text: str = report.tostring().decode("utf-8")
    return text


def _suite(result: SceneResult, required: tuple[str, ...]) -> TestSuite:
    suite = TestSuite(one_line(result.scene.name))
    for answer in result.references:
        must = answer.reference in required
        suite.add_testcases([_case(suite.name, answer, check, must) for check in answer.checks])
    if result.judgement is not None:
        suite.add_testcase(_judged(suite.name, result.judgement, result.seconds))
    return suite


def _case(scene: str, answer: ReferenceResult, check: Check, required: bool) -> TestCase:
    seconds = answer.seconds / len(answer.checks)
    case = TestCase(check.quantity, f"{scene}.{one_line(answer.reference)}", seconds)
    message = f"{check.state}: {one_line(check.reason)}"
    if check.state == "failed":
        case.result = Failure(message, check.state)
        lines = [message, f"worst pixel {worst_in_words(check)}"]
        lines += [f"it {each.sentence}" for each in (answer.diagnosis or ())[:1]]
        case.result[0].text = "\n".join(lines)
    elif check.state in ("crashed", "timed out") or (check.state == "missing" and required):
        case.result = Error(message, check.state)
        case.result[0].text = plain(answer.output)
    elif check.state != "passed":
        case.result = Skipped(message, check.state)
    return case


def _judged(scene: str, judgement: Judgement, seconds: float) -> TestCase:
    """minirt against exact arithmetic, with all the time that minirt took for the scene."""
    case = TestCase("exact arithmetic", f"{scene}.judge", seconds)
    if judgement.convictions:
        case.result = Failure(judgement_in_words(judgement), "convicted")
        lines = [opinion_in_words(each) for each in judgement.convictions[:MOST_LISTED]]
        case.result[0].text = "\n".join(lines)
    return case


def _troubles(run: Run) -> TestSuite:
    suite = TestSuite("minirt")
    case = TestCase("complete", "minirt")
    case.result = [Error(one_line(trouble), "incomplete") for trouble in run.verdict.troubles]
    suite.add_testcase(case)
    return suite
