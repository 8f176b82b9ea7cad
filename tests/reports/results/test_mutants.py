"""The kill matrix in a report."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from minirt.errors import InputError
from minirt.quantities import STAGES
from reports.cli.main import run
from reports.page.report import report_html
from reports.results.mutants import read_kill_matrix
from reports.results.record import results_document
from tests.helpers.fake_references import small_scene
from tests.helpers.places import HELPERS
from tests.helpers.report_runs import good_run

ROWS = [
    {"mutant": "far-root", "rule": "S8", "mistake": "with the far root", "stage": "t",
     "scenes": 3, "failed": ["ball"], "charged": dict.fromkeys(STAGES, 0) | {"t": 17},
     "killed": True, "right_stage": True, "found": "t"},
    {"mutant": "<b>survivor", "rule": "S9", "mistake": "with nothing", "stage": "hit",
     "scenes": 3, "failed": [], "charged": dict.fromkeys(STAGES, 0), "killed": False,
     "right_stage": False, "found": None},
]  # fmt: skip
PRINTED = {"mutants": ROWS, "killed": 1, "right_stage": 1, "false_alarms": 0, "floor": {}}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "mutants.json"
    path.write_text(json.dumps(PRINTED), encoding="utf-8")
    return path


def test_the_page_shows_the_matrix_when_it_was_run_and_nothing_otherwise(file: Path) -> None:
    kills = read_kill_matrix(file)
    text = report_html(replace(good_run(), mutants=kills))
    assert "1 of 2 mutants killed, 1 by the stage that they really break" in text
    section = text[text.index('id="mutants"') :]
    rows = re.findall(r"<tr[^>]*>(.*?)</tr>", section[: section.index("</table>")], re.DOTALL)
    assert len(rows) == 1 + 2
    assert "✓ killed" in re.sub("<[^>]*>", "", rows[1])
    assert "17" in rows[1]
    assert "&lt;b&gt;survivor" in rows[2]
    assert "✗ not noticed" in re.sub("<[^>]*>", "", rows[2])
    assert 'id="mutants"' not in report_html(good_run())


def test_results_hold_the_matrix_too(file: Path) -> None:
    shown = replace(good_run(), mutants=read_kill_matrix(file))
    assert results_document(shown)["mutants"]["killed"] == 1
    assert results_document(good_run())["mutants"] is None


def test_a_gate_shows_what_the_mutants_printed(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(HELPERS)
    scene = tmp_path / "ball.json"
    scene.write_text(json.dumps({"minirt": 1, **small_scene().to_dict()}), encoding="utf-8")
    out = tmp_path / "out"
    words = ["gate", str(scene), "--python", "gate_subjects:honest", "--out", str(out)]
    assert run([*words, "--no-cache", "--mutants", str(file)]) == 0
    assert "1 of 2 mutants killed" in (out / "report.html").read_text(encoding="utf-8")
    assert run([*words, "--mutants", str(tmp_path / "none")]) == 2


@pytest.mark.parametrize("text", ["", "[]", '{"mutants": [{"mutant": 1}]}'])
def test_another_file_is_one_clear_error(text: str, tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="expected what minirt mutants --json prints"):
        read_kill_matrix(path)
    with pytest.raises(InputError, match="cannot be read"):
        read_kill_matrix(tmp_path / "none.json")
