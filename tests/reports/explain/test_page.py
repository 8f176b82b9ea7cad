"""The page of one pixel: `minirt explain --html`."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe

from minirt.errors import InputError
from minirt.explain.pixel import explain
from reports.cli.main import run
from reports.explain.page import pixel_html, write_pixel_page
from reports.explain.second_opinion import second_opinion
from tests.helpers.browser import chromium, tab
from tests.helpers.fake_references import HOSTILE, Faulty, Honest, small_scene

BAD = ("serious", "critical")
COMMAND = ["minirt", "explain", "ball.json", "--pixel", "21", "25"]


def test_alone_it_has_every_value_every_step_and_the_rays() -> None:
    scene = small_scene()
    explanation = explain(scene, 21, 25)
    text = pixel_html(scene, explanation, None, COMMAND)
    for step in explanation.steps:
        assert f"> {step.title}</h3>" in text.replace("&#39;", "'")
    rows = dict(re.findall(r'<tr data-quantity="(\w+)">.*?<span>([^<]*)</span>', text, re.DOTALL))
    assert rows["shadow"] == "1"
    assert float(rows["t"]) == next(
        s.values["t"] for s in explanation.steps if s.title == "the first object hit"
    )
    assert "error ÷ tol." not in text
    (data,) = re.findall(r'id="data">(.*?)</script>', text)
    kinds = [line["kind"] for line in json.loads(data)["explanation"]["lines"]]
    assert kinds == ["ray", "normal", "shadow", "reflected", "refracted"]


def test_with_another_it_says_what_is_wrong_first() -> None:
    scene = small_scene()
    opinion = second_opinion(scene, 21, 25, Faulty(), 60)
    text = pixel_html(scene, explain(scene, 21, 25), opinion, COMMAND)
    assert "The first wrong stage is shadow" in text
    assert "✗ wrong" in text
    assert 'class="verdict bad"' in text
    agreeing = second_opinion(scene, 21, 25, Honest(), 60)
    text = pixel_html(scene, explain(scene, 21, 25), agreeing, COMMAND)
    assert "✗ wrong" not in text
    assert 'class="verdict good"' in text


def test_a_pixel_that_hits_nothing_and_a_hostile_name(tmp_path: Path) -> None:
    scene = small_scene(HOSTILE, about=HOSTILE)
    path = tmp_path / "pixel.html"
    write_pixel_page(path, scene, explain(scene, 0, 0), None, [*COMMAND, HOSTILE])
    with chromium() as browser, tab(browser, path) as shown:
        shown.page.wait_for_selector("#space-canvas")
        assert "Nothing is hit" in shown.page.inner_text("h1")
        assert shown.page.locator("img").count() == 0
        assert shown.page.locator("#space-table tr").count() > 5
        found = Axe().run(shown.page).response
        assert [v["id"] for v in found["violations"] if v["impact"] in BAD] == []
        assert shown.errors == []
        assert shown.requests == [path.as_uri()]


def test_the_command_writes_it_and_repeats_itself_without_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "pixel.html"
    words = ["explain", "atlas:one-sphere", "--pixel", "128", "96", "--html", str(path), "--json"]
    assert run(words) == 0
    assert json.loads(capsys.readouterr().out)["column"] == 128
    text = path.read_text(encoding="utf-8")
    assert '<pre id="command">minirt explain atlas:one-sphere --pixel 128 96</pre>' in text


def test_a_file_that_cannot_be_written_is_one_clear_error(tmp_path: Path) -> None:
    scene = small_scene()
    with pytest.raises(InputError, match="cannot be written"):
        write_pixel_page(tmp_path / "no" / "p.html", scene, explain(scene, 0, 0), None, COMMAND)
