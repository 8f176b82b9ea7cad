"""Exact arithmetic in the reports: a contradiction fails the run, in words that say where."""

from __future__ import annotations

import dataclasses
import io
import json
from functools import cache
from pathlib import Path

import numpy as np
from rich.console import Console

import minirt
from minirt.frame import Frame
from reference.exact import JUDGED, judge_pixels
from reference.verify.options import Options
from reference.verify.results import SceneResult
from reference.verify.scene import compare_scene
from reports.page.report import report_html
from reports.results.cells import scene_state
from reports.results.findings import findings_of
from reports.results.junit import junit_xml
from reports.results.provenance import provenance
from reports.results.record import Run, results_json
from reports.results.summary import summary_markdown
from reports.results.verdict import decide
from reports.results.words import judgement_in_words
from reports.terminal.results import print_run
from tests.helpers.fake_references import Honest, small_scene
from tests.helpers.report_runs import result_of


@cache
def result(wrong: bool) -> SceneResult:
    """A scene on which every reference agrees, judged with one wrong t or with none."""
    scene = small_scene()
    arrays = dict(minirt.render(scene, quantities=JUDGED).arrays)
    row, column = map(int, np.argwhere(arrays["hit"])[0])
    if wrong:
        arrays["t"] = arrays["t"].copy()
        arrays["t"][row, column] *= 1 + 1e-12
    judgement = judge_pixels(scene, Frame(arrays), [(row, column), (0, 0)])
    return dataclasses.replace(result_of(scene, [Honest()]), judgement=judgement)


@cache
def run(wrong: bool) -> Run:
    findings = findings_of([result(wrong)], ["honest"])
    verdict = decide(findings, ["honest"], ["honest"])
    return Run(findings, ("honest",), ("honest",), verdict, provenance(), 1.0, Path("report"))


def terminal(of: Run) -> str:
    console = Console(file=io.StringIO(), width=400)
    print_run(of, console)
    text: str = console.file.getvalue()  # type: ignore[attr-defined]
    return text


def test_a_contradiction_fails_a_run_that_every_reference_passes() -> None:
    assert scene_state(result(True)) == "failed"
    assert run(True).exit_status == 1
    assert "exact arithmetic contradicts minirt on 1 of 1 scene" in run(True).verdict.sentence
    assert scene_state(result(False)) == "passed"
    assert run(False).exit_status == 0
    assert "exact arithmetic confirms" in run(False).verdict.sentence


def test_every_report_says_where() -> None:
    judgement = result(True).judgement
    assert judgement is not None
    (opinion,) = judgement.convictions
    place = f"t at ({opinion.column}, {opinion.row}): ours {opinion.ours[0]:.9g}"
    for text in (terminal(run(True)), report_html(run(True)), junit_xml(run(True))):
        assert "contradicts minirt" in text
        assert place in text
    assert "Against exact arithmetic" in summary_markdown(run(True))
    assert "contradicts minirt" in summary_markdown(run(True))


def test_no_report_mentions_contradictions_where_there_are_none() -> None:
    for text in (terminal(run(False)), junit_xml(run(False)), summary_markdown(run(False))):
        assert "contradicts" not in text
    assert "Exact arithmetic confirms minirt" in report_html(run(False))


def test_the_record_holds_the_contradiction() -> None:
    (scene,) = json.loads(results_json(run(True)))["scenes"]
    assert scene["state"] == "failed"
    assert scene["judgement"]["convicted"] == 1
    (conviction,) = scene["judgement"]["convictions"]
    assert conviction["quantity"] == "t"
    assert conviction["ours"][0] / conviction["exact"][0] - 1 > 5e-13
    assert conviction["ulps"] > 100


def test_the_words_count_what_is_open() -> None:
    judgement = result(False).judgement
    assert judgement is not None
    words = judgement_in_words(judgement)
    decided, judged = (sum(getattr(c, k) for c in judgement.counts) for k in ("decided", "judged"))
    assert words.startswith(f"confirms minirt: {decided} of {judged} answers at 2 pixels")


def test_verify_judges_without_a_reference() -> None:
    """And only the quantities that were asked for."""
    verdict = compare_scene(small_scene(), (), Options(("hit", "t", "color")))
    assert [count.quantity for count in verdict.judgement.counts] == ["hit", "t"]
    assert verdict.judgement.pixels > 0
    assert verdict.judgement.convictions == ()
