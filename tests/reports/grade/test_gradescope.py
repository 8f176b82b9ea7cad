"""The scripts for Gradescope: run as its container runs them, in a folder in its place."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from converters.frames.io import write_frame
from reports.cli.main import run
from tests.helpers.grade_class import honest, small

BASH = shutil.which("bash") or "/bin/bash"
RUBRIC = """
scenes = ["ball-on-quad.json", "deep/alpha.json"]
[late]
deadline = 2027-02-01T12:00:00+00:00
per_day = 0.5
[[part]]
name = "everything"
points = 10
scenes = ["ball-on-quad.json"]
"""


@pytest.fixture
def autograder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What `minirt grade` leaves for Gradescope, where its container has it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "rubric.toml").write_text(RUBRIC, encoding="utf-8")
    (tmp_path / "deep").mkdir()
    for place, name in (("", "ball-on-quad"), ("deep/", "alpha")):
        text = json.dumps(small(name).to_dict())
        (tmp_path / f"{place}{name}.json").write_text(text, encoding="utf-8")
    shutil.copy(small("alpha").folder / "octahedron.obj", tmp_path / "deep")
    (tmp_path / "in" / "ana").mkdir(parents=True)
    write_frame(honest("ball-on-quad"), tmp_path / "in" / "ana" / "ball-on-quad.npz")
    command = ["grade", "in", "--rubric", "rubric.toml", "-o", "out", "-j", "1"]
    monkeypatch.chdir(tmp_path)
    assert run(command) == 0
    root = tmp_path / "autograder"
    shutil.copytree(tmp_path / "out" / "staff" / "gradescope", root / "source")
    assert (root / "source" / "deep" / "octahedron.obj").is_file()
    (root / "venv").mkdir()
    (root / "venv" / "bin").symlink_to(Path(sys.executable).parent)
    shutil.copytree(tmp_path / "in" / "ana", root / "submission")
    return root


def grade(root: Path) -> dict[str, object]:
    script = (root / "source" / "run_autograder").read_text(encoding="utf-8")
    script = script.replace("/autograder", str(root))
    done = subprocess.run([BASH, "-c", script], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "submission" in done.stdout or "rubric.toml" in done.stdout  # for the staff
    document = json.loads((root / "results" / "results.json").read_text(encoding="utf-8"))
    assert isinstance(document, dict)
    return document


def test_a_submission_is_graded_with_its_time(autograder: Path) -> None:
    told = {"created_at": "2027-02-01T23:00:00.123456-07:00"}
    (autograder / "submission_metadata.json").write_text(json.dumps(told), encoding="utf-8")
    document = grade(autograder)
    assert document["score"] == 5
    assert "1 begun day late" in str(document["output"])
    (autograder / "source" / "rubric.toml").write_text("scenes = 3", encoding="utf-8")
    refused = grade(autograder)
    assert (refused["score"], refused["stdout_visibility"]) == (0, "hidden")
    assert "staff can see why" in str(refused["output"])


@pytest.mark.parametrize("name", ["setup.sh", "run_autograder"])
def test_the_scripts_can_be_run_and_have_no_fault_that_bash_sees(
    name: str, autograder: Path
) -> None:
    path = autograder / "source" / name
    assert path.stat().st_mode & 0o111
    assert path.read_text(encoding="utf-8").startswith("#!/usr/bin/env bash\n")
    done = subprocess.run([BASH, "-n", str(path)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
