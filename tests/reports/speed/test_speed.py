"""What `make bench` measured is the same in its document, drawing, README and report."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET  # our own drawing
from dataclasses import replace
from itertools import combinations, pairwise

import jsonschema
import numpy as np
import pytest
from pydantic import ValidationError

from reports.page.report import report_html
from reports.speed import table
from reports.speed.plot import BOTTOM, TOP, plot_of, plot_svg, spread
from reports.speed.results import Case, Speed, fitted, measured, speed_json, speed_schema
from tests.helpers.browser import chromium
from tests.helpers.places import ROOT
from tests.helpers.report_runs import good_run

FILE = ROOT / "reports" / "speed" / "speed.json"
DRAWING = FILE.with_suffix(".svg")
SPEED = measured()


def faster(speed: Speed) -> Speed:
    """Another run, in which minirt did better on the first case."""
    first = speed.cases[0]
    case = first.model_copy(update={"rates": {**first.rates, "minirt": 1e9}})
    return speed.model_copy(update={"cases": [case, *speed.cases[1:]]})


def test_the_document_is_of_its_schema_and_in_its_spelling() -> None:
    text = FILE.read_text(encoding="utf-8")
    jsonschema.validate(json.loads(text), speed_schema())
    assert speed_json(SPEED) == text
    assert all("description" in speed_schema()["properties"][key] for key in ("memory", "tracers"))


def test_a_document_with_another_key_or_an_impossible_rate_is_refused() -> None:
    document = json.loads(FILE.read_bytes())
    with pytest.raises(ValidationError):
        Speed.model_validate({**document, "slower": True})
    document["cases"][0]["rates"]["minirt"] = 0
    with pytest.raises(ValidationError):
        Speed.model_validate(document)


def test_the_document_has_every_case_and_all_that_time_grows_with() -> None:
    names = {case.name for case in SPEED.cases}
    assert names >= {"1 sphere", "10k spheres", "mesh, 5k", "mesh, 1.3M", "gyroid, 201k"}
    assert {case.kind for case in SPEED.cases} == {
        "spheres", "triangles", "mesh", "incoherent", "image",
    }  # fmt: skip
    assert {growth.over for growth in SPEED.growth} == {
        "spheres", "triangles", "rays without order", "recursion depth", "pixels", "scenes",
        table.TREE,
    }  # fmt: skip
    assert all("minirt" in case.rates for case in SPEED.cases)
    assert all(set(case.rates) <= set(SPEED.tracers) for case in SPEED.cases)
    assert SPEED.memory is not None


def test_exponents_are_those_of_their_points() -> None:
    for growth in SPEED.growth:
        assert fitted(growth.over, growth.sizes, growth.seconds) == growth
        assert len(growth.sizes) > 2


@pytest.mark.parametrize("k", [0.0, 0.25, 1.0, 2.0])
def test_a_power_is_found_again(k: float) -> None:
    sizes = [10, 100, 1_000]
    assert fitted("rays", sizes, [3 * n**k for n in sizes]).exponent == pytest.approx(k, abs=1e-3)


def test_the_readme_has_the_documents_table() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    block = readme.partition("<!-- speed -->\n")[2].partition("<!-- /speed -->\n")[0]
    assert block == table.markdown(SPEED)
    assert block != table.markdown(faster(SPEED))
    assert f"({DRAWING.relative_to(ROOT).as_posix()})" in readme


def test_a_row_has_as_many_cells_as_the_heading() -> None:
    assert {len(row) for row in table.rows(SPEED)} == {len(table.heading(SPEED))}
    assert [row[0] for row in table.rows(SPEED)] == [case.name for case in SPEED.cases]


def test_ratios_are_minirts_rate_over_the_peers() -> None:
    case = Case(
        name="one", kind="spheres", primitives=1, rates={"minirt": 6e6, "raysect": 3e5, "Embree": 9}
    )
    speed = SPEED.model_copy(update={"cases": [case], "tracers": ["minirt", "raysect", "Embree"]})
    assert table.rows(speed) == [["one", "6,000", "300", "0.009", "–", "20"]]


def test_the_drawing_is_drawn_from_the_document() -> None:
    assert DRAWING.read_text(encoding="utf-8") == plot_svg(SPEED)
    assert plot_svg(faster(SPEED)) != plot_svg(SPEED)


def test_the_drawing_is_one_file_in_light_and_dark() -> None:
    text = DRAWING.read_text(encoding="utf-8")
    root = ET.fromstring(text)  # noqa: S314 - our own drawing
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert "prefers-color-scheme: dark" in text
    assert "url(" not in text
    assert "href" not in text
    named = {element.text for element in root.iter() if element.tag.endswith("}text")}
    assert named >= set(SPEED.tracers)


def test_a_line_is_higher_where_rays_are_faster() -> None:
    for panel in plot_of(SPEED).panels:
        cases = sorted(
            (case for case in SPEED.cases if case.kind == panel.kind), key=lambda c: c.primitives
        )
        assert len(cases) > 3
        for line in panel.lines:
            rates = [case.rates[line.tracer] for case in cases if line.tracer in case.rates]
            heights = [y for _, y, _ in line.points]
            assert len(rates) == len(heights)
            assert np.argmax(rates) == np.argmin(heights)
            assert all(TOP <= y <= BOTTOM for y in heights)
            assert all(a < b for (a, _, _), (b, _, _) in pairwise(line.points))


def test_labels_are_moved_apart_and_no_further_than_needed() -> None:
    assert spread([100.0, 200.0]) == [100.0, 200.0]
    moved = spread([100.0, 100.0, 104.0, 300.0])
    assert sum(moved[:3]) == pytest.approx(304, abs=0.2)
    assert moved[3] == 300.0
    assert all(abs(a - b) > 16 for a, b in combinations(moved, 2))


def test_no_text_of_the_drawing_covers_another_or_is_cut() -> None:
    with chromium() as browser:
        page = browser.new_page(viewport={"width": 1000, "height": 560})
        page.set_content(f'<body style="margin:0">{plot_svg(SPEED)}')
        view, *boxes = page.evaluate(
            "[...document.querySelectorAll('svg, svg text')].map((e) => {"
            "const r = e.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]})"
        )
    assert len(boxes) > 2 * len(SPEED.tracers)
    inside = [b for b in boxes if b[0] >= view[0] and b[1] >= view[1] and b[2] <= view[2]]
    assert inside == boxes
    for a, b in combinations(boxes, 2):
        across, down = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
        assert across <= 0 or down <= 2, (a, b)


def test_the_report_shows_it_closed_and_says_that_it_is_not_of_this_run() -> None:
    run = good_run()
    page = report_html(run)
    section = page.partition('<h2 id="speed">')[2].partition("<h2 ")[0]
    assert section.startswith("Speed</h2>\n<details><summary>")
    assert f"measured it on {table.origin(SPEED)}: not in this run" in section
    figures = [cell for row in table.rows(SPEED) for cell in row]
    assert [figure for figure in figures if f">{figure}<" not in section] == []
    assert len(section.encode()) < 30_000
    assert 'id="speed"' not in report_html(replace(run, judged="their tracer"))
