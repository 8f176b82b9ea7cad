"""`minirt explain` with another implementation beside it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from converters.scene_folder import plain_document
from reports.cli.main import run
from tests.helpers.fake_references import small_scene
from tests.helpers.places import HELPERS


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(HELPERS)
    path = tmp_path / "ball.json"
    path.write_text(json.dumps(plain_document(small_scene())), encoding="utf-8")
    return str(path)


def explained(capsys: pytest.CaptureFixture[str], *options: str) -> tuple[int, dict[str, Any]]:
    status = run(["explain", *options, "--json"])
    document: dict[str, Any] = json.loads(capsys.readouterr().out)
    return status, document


def test_both_are_shown_with_the_tolerance_and_the_first_wrong_stage(
    scene: str, capsys: pytest.CaptureFixture[str]
) -> None:
    options = scene, "--pixel", "24", "18", "--python", "gate_subjects:no_half_pixel"
    status, document = explained(capsys, *options)
    assert status == 1
    other = document["other"]
    assert other["quantities"][0]["quantity"] == "ray"
    assert other["quantities"][0]["state"] == "wrong"
    assert "first wrong stage is ray" in other["sentence"]
    assert "S1" in other["sentence"]
    assert "agrees with rule S2 without the half pixel" in other["sentence"]
    frame = minirt.render(small_scene())
    rows = {row["quantity"]: row for row in other["quantities"]}
    assert rows["depth"]["ours"] == [frame["depth"][18, 24]]
    assert rows["depth"]["error"] == pytest.approx(
        abs(rows["depth"]["ours"][0] - rows["depth"]["theirs"][0])
    )
    assert rows["depth"]["tolerance"] > 0
    assert np.allclose(rows["normal"]["ours"], frame["normal"][18, 24], rtol=0, atol=0)


def test_agreement_and_the_lack_of_a_frame_are_said(
    scene: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pixel = scene, "--pixel", "24", "18"
    status, document = explained(capsys, *pixel, "--python", "gate_subjects:honest")
    assert status == 0
    assert "agrees here in all 20 quantities" in document["other"]["sentence"]
    status, document = explained(capsys, *pixel, "--python", "gate_subjects:raising")
    assert status == 3
    assert "ZeroDivisionError" in document["other"]["sentence"]
    assert run(["explain", *pixel, "--python", "gate_subjects:no_half_pixel"]) == 1
    shown = capsys.readouterr().out
    assert "✗" in shown
    assert "The first wrong stage is ray" in shown
