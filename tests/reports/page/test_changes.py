"""What the page says against the previous run."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest

from reference.compare.check import Check, State
from reports.history.previous import Point, PreviousRun
from reports.page.changes import (
    SceneChanges,
    arrow,
    changes_in_words,
    run_changes,
    scene_changes,
    trend_of,
)
from reports.page.report import report_html
from tests.helpers.fake_references import HOSTILE, OnePixel, small_scene
from tests.helpers.report_runs import good_run, run_of

LAST = Point(4, "2026-01-02T03:04:05+00:00", "0123456789abcdef", "passed", None)


def earlier(state: State, ratio: float | None) -> Check:
    """The check of the previous run."""
    return Check("t", "t", state, ratio=ratio)


def before(**changes: object) -> PreviousRun:
    scenes = {result.scene.name: result.scene.sha256 for result in good_run().results}
    usual = PreviousRun(LAST, {}, scenes, {})
    return replace(usual, **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("state", "ratio", "was", "expected"),
    [
        ("failed", 14.0, earlier("passed", 0.3), "▲"),
        ("passed", 0.3, earlier("failed", 14.0), "▼"),
        ("passed", 0.5, earlier("passed", 0.3), "▲"),
        ("passed", 0.3, earlier("passed", 0.5), "▼"),
        ("passed", 0.31, earlier("passed", 0.3), ""),
        ("failed", math.inf, earlier("failed", math.inf), ""),
        ("failed", 2.0, earlier("known", 2.0), "▲"),
        ("passed", 0.3, None, ""),
        ("passed", 0.3, earlier("crashed", None), ""),
    ],
)
def test_an_arrow_says_worse_or_better(
    state: str, ratio: float, was: Check | None, expected: str
) -> None:
    assert arrow(Check("t", "t", state, ratio=ratio), was) == expected  # type: ignore[arg-type]


def test_scenes_that_came_went_and_changed_are_named() -> None:
    results = good_run().results
    ball, second = (result.scene for result in results)
    assert scene_changes(before(), results) == SceneChanges((), (), (), ())
    changes = scene_changes(before(scenes={"old name": ball.sha256, "second": "other"}), results)
    assert changes == SceneChanges((), (), ("second",), (("old name", "ball"),))
    changes = scene_changes(before(scenes={"gone": "x", "ball": ball.sha256}), results)
    assert changes == SceneChanges(("second",), ("gone",), (), ())
    assert second.name == "second"


def test_without_a_previous_run_nothing_is_said() -> None:
    assert changes_in_words(run_changes(before(last=None), good_run().results)) == []
    for run in (good_run(), replace(good_run(), previous=before(last=None))):
        text = report_html(run)
        assert "Against the run" not in text
        assert 'data-only="new"' not in text
        assert '<svg class="trend"' not in text


def test_the_page_shows_arrows_news_and_trends() -> None:
    run = run_of([small_scene(), small_scene(HOSTILE)], [OnePixel()])
    trend = (
        Point(1, "2026-01-01", "aaaa", "passed", 0.2),
        Point(2, "2026-01-02", "bbbb", "passed", 0.3),
    )
    cells = {
        ("ball", "one-pixel", "shadow"): earlier("passed", 0.0),
        ("ball", "one-pixel", "t"): earlier("failed", 3.0),
    }
    old = {"ball": run.results[0].scene.sha256, "<gone>": "x"}
    text = report_html(replace(run, previous=PreviousRun(LAST, cells, old, {"ball": trend})))
    assert (
        "Against the run of 2026-01-02T03:04:05+00:00, commit 0123456789: 1 cell worse, 1" in text
    )
    assert "Removed: &lt;gone&gt;." in text
    assert len(re.findall(r'class="arrow"', text)) == 2
    assert "worse: it was passed, 0×" in text
    assert "over 3 runs: from 0.20× to ∞×; failed since" in text
    assert text.count('<svg class="trend"') == 2, "in the matrix and in the scene's section"
    assert 'data-only="new"' in text
    tags = dict(
        re.findall(r'<details class="scene[^>]*data-tags="([^"]*)"[^>]*data-name="(\w*)', text)
    )
    assert {"failed changed"} <= set(tags)


def test_a_trend_without_earlier_runs_is_none() -> None:
    assert trend_of(before(), good_run().findings.scenes[0], None) is None


def test_a_lasting_step_is_marked_as_a_change() -> None:
    (found, *_) = good_run().findings.scenes
    scene = found.result.scene
    ratios = [0.9] * 4 + [0.0] * 4
    points = tuple(
        Point(k, f"2026-11-{k:02}", f"{k:040x}", "passed", ratio, scene.sha256)
        for k, ratio in enumerate(ratios, start=1)
    )
    known = PreviousRun(LAST, {}, {}, {scene.name: points})
    trend = trend_of(known, found, None)
    assert trend is not None
    assert trend.words.endswith("; worst ratio 0.90× → <0.01× since commit 0000000000")
    assert trend.changed == pytest.approx(trend.dots[4][0])
