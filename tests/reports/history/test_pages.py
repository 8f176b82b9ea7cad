"""The pages of a history in a browser: nothing sticks out, nothing hinders anybody."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser

from reports.history.difference import difference
from reports.history.entry import Entry
from reports.history.pages import compare_html
from reports.history.previous import Point
from reports.history.store import History
from reports.history.trends import changes_of
from reports.nightly.landing import landing_html
from reports.nightly.nightly_run import NightlyRecord, NightlyRun, NightlySettings, StepResult
from reports.nightly.sparkline import HEIGHT, WIDTH, sparkline
from tests.helpers.browser import chromium
from tests.helpers.history_runs import entry, with_cell

VIEWS = [(scheme, width) for scheme in ("light", "dark") for width in (390, 1200)]
FAILING: dict[str, Any] = {
    "state": "failed", "ratio": math.inf, "wrong": 7, "reason": "7 of 1728 certain pixels wrong",
}  # fmt: skip


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as found:
        yield found


def night(folder: Path, run: int, failed: bool) -> NightlyRun:
    settings = NightlySettings(
        commit=f"{run:040x}", scenes=[], references=[], required=[], budget=60.0, mutants=[]
    )
    step = StepResult(exit_status=int(failed), sentence="FAIL: 1 of 2 scenes", seconds=61.0)
    good = StepResult(exit_status=0, sentence="82 of 82 mutants killed", seconds=1.0)
    note = NightlyRecord(
        started=f"2026-11-{run:02}T02:17:00+00:00", seed=7, settings=settings, run=run,
        steps={"verify": step, "mutants": good}, finished="2026-11-24T02:40:00+00:00",
    )  # fmt: skip
    return NightlyRun(folder / f"2026-11-{run:02}", note)


def nightly_run(k: int) -> Entry:
    made = entry(k, commit=f"{k * 7919:040x}", started=f"2026-11-{k:02}T02:17:00+00:00")
    return with_cell(made, **(FAILING if k in (8, 20) else {"ratio": 0.1 if k < 14 else 0.4}))


def pages(folder: Path) -> dict[str, str]:
    """A landing page after twenty nights, and a comparison, as text."""
    with History(str(folder / "history.sqlite")) as history:
        for k in range(1, 21):
            history.append(nightly_run(k))
        landing = landing_html([night(folder, k, k in (8, 20)) for k in range(1, 21)], history)
    return {
        "landing": landing,
        "compare": compare_html(difference(nightly_run(1), nightly_run(20))),
    }


@pytest.mark.full
def test_pages_are_for_everybody_in_light_and_dark_wide_and_narrow(
    browser: Browser, tmp_path: Path
) -> None:
    looked = 0
    for name, text in pages(tmp_path).items():
        path = tmp_path / f"{name}.html"
        path.write_text(text, encoding="utf-8")
        for scheme, width in VIEWS:
            context = browser.new_context(viewport={"width": width, "height": 900}, bypass_csp=True)
            page = context.new_page()
            page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
            page.goto(path.as_uri())
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            found = Axe().run(page).response["violations"]
            assert [(v["id"], v["nodes"][0]["html"]) for v in found] == []
            looked += 1
            context.close()
    assert looked == 8


def test_the_landing_page_marks_each_change_where_it_is(tmp_path: Path) -> None:
    text = pages(tmp_path)["landing"]
    for what in (
        "7 (2026-11-07) → 8",
        "8 (2026-11-08) → 9",
        "13 (2026-11-13) → 14",
        "19 (2026-11-19) → 20",
    ):
        assert what in text
    assert "worst ratio 0.10× → 0.40×" in text
    assert f"<code>{13 * 7919:040x}"[:16] in text


def test_local_changes_are_told_from_their_commit(tmp_path: Path) -> None:
    with History(str(tmp_path / "history.sqlite")) as history:
        for k, changes in ((1, {"ratio": 0.1}), (2, FAILING)):
            run = entry(k, commit="a" * 40, dirty=k == 2)
            history.append(with_cell(run, **changes))
        text = landing_html([night(tmp_path, 2, True)], history)
    code = f"<code>{'a' * 10}</code>"
    assert f"{code} → {code} with local changes</td>" in text


def test_a_drawing_stays_in_its_frame_and_breaks_where_nothing_was_compared() -> None:
    ratios = [0.0, 1.0, None, 0.5, math.inf, 1e9, 0.5]
    trend = [
        Point(k, "2026-11-01T00:00", None, "passed" if r else "not compared", r, "x")
        for k, r in enumerate(ratios)
    ]
    drawn = sparkline(trend, changes_of(trend))
    assert len(drawn.dots) == len(ratios)
    assert all(0 <= dot.x <= WIDTH and 0 <= dot.y <= HEIGHT for dot in drawn.dots)
    assert [line.count(",") for line in drawn.lines] == [2, 4]
    assert drawn.dots[1].y == drawn.limit
    assert drawn.dots[4].y < drawn.limit < drawn.dots[3].y
    assert drawn.dots[-1].x == WIDTH - 5
    assert [dot.state for dot in drawn.dots][:3] == ["other", "passed", "other"]
    assert sparkline([], []).words == "0 runs, 0 failed; no change"


def test_a_page_before_the_first_night_says_so(tmp_path: Path) -> None:
    with History(str(tmp_path / "history.sqlite")) as history:
        text = landing_html([], history)
        unfinished = night(tmp_path, 1, False)
        unfinished.record = unfinished.record.model_copy(update={"finished": None})
        assert "not finished" in landing_html([unfinished], history)
    assert "no night is finished yet" in text
    assert "✓" not in text.partition("<title>")[2][:3]
