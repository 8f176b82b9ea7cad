"""`minirt grade` as it is typed: its streams, its exit status, and a run that is killed."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from converters.frames.io import write_frame
from reports.cli.main import run
from tests.helpers.grade_class import honest, mutant, small

SCENE = "ball-on-quad"
RUBRIC = f"""
scenes = ["{SCENE}.json"]
limits = {{ seconds = 300 }}
[[part]]
name = "shadows"
points = 3
rules = ["S12"]
"""
COMMAND = ["grade", "in", "--rubric", "rubric.toml", "-o", "out", "-j", "1"]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rubric.toml").write_text(RUBRIC, encoding="utf-8")
    (tmp_path / f"{SCENE}.json").write_text(json.dumps(small(SCENE).to_dict()), encoding="utf-8")
    for name, frame in (("ana", honest(SCENE)), ("ben", mutant("light-not-negated", SCENE))):
        (tmp_path / "in" / name).mkdir(parents=True)
        write_frame(frame, tmp_path / "in" / name / f"{SCENE}.npz")
    return tmp_path


def test_grading_is_told_and_is_no_failure(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(COMMAND) == 0
    said = capsys.readouterr()
    assert "2 students graded, of 3 points" in said.out
    assert "agrees with rule S12 with l in the place of −l" in " ".join(said.out.split())
    assert run([*COMMAND, "--json"]) == 0
    said = capsys.readouterr()
    document = json.loads(said.out)
    assert [each["name"] for each in document["students"]] == ["ana", "ben"]
    assert document["students"][0]["marks"]["points"] == 3
    assert document["students"][1]["marks"]["points"] < 3
    assert "2 students graded" in said.err
    kept = json.loads((place / "out" / "staff" / "grades.json").read_text(encoding="utf-8"))
    assert kept == document


@contextmanager
def started(place: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A run of its own, which is killed in the end with all its processes."""
    command = [sys.executable, "-c", "from reports.cli.main import main; main()", *COMMAND]
    (place / "tmp").mkdir()
    environment = {**os.environ, "TMPDIR": str(place / "tmp")}
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, start_new_session=True, env=environment
    ) as grading:
        try:
            yield grading
        finally:
            os.killpg(grading.pid, signal.SIGKILL)


def wait(grading: subprocess.Popen[bytes], until: Callable[[], bool]) -> None:
    """Until something is so, while the run goes on."""
    end = time.monotonic() + 120
    while not until() and time.monotonic() < end:
        assert grading.poll() is None
        time.sleep(0.005)


@pytest.mark.full
def test_a_run_that_is_killed_while_it_unpacks_leaves_nothing_half(place: Path) -> None:
    shutil.rmtree(place / "in" / "ben")
    members = 400
    with zipfile.ZipFile(place / "in" / "zoe.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(place / "in" / "ana" / f"{SCENE}.npz", f"{SCENE}.npz")
        for k in range(members):
            archive.writestr(f"{k}.bin", bytes(2**20), compresslevel=1)
    room = place / "tmp"
    with started(place) as grading:
        wait(grading, lambda: len(list(room.glob("minirt-*/submission/*.bin"))) > 2)
    assert 2 < len(list(room.glob("minirt-*/submission/*.bin"))) < members
    assert not (place / "out" / "students" / "zoe").exists()
    shutil.rmtree(room)
    assert run(COMMAND) == 0
    grades = (place / "out" / "grades.csv").read_text(encoding="utf-8").splitlines()
    assert [row.split(",")[:2] for row in grades[1:]] == [["ana", "3"], ["zoe", "3"]]


@pytest.mark.full
def test_a_killed_run_goes_on_where_it_was(place: Path) -> None:
    """The second student's program never ends; the run is killed while it is at it."""
    zoe = place / "in" / "zoe"
    zoe.mkdir()
    command = f"{sys.executable} wait.py {{scene}} {{out}}"
    (zoe / "minirt.toml").write_text(f'run = "{command}"\n', encoding="utf-8")
    (zoe / "wait.py").write_text("import time; time.sleep(600)\n", encoding="utf-8")
    state = place / "out" / "staff" / "state"
    with started(place) as grading:
        wait(grading, (state / "ben.json").exists)
    assert {path.name for path in state.iterdir()} >= {"ana.json", "ben.json"}
    assert not (state / "zoe.json").exists()
    before = (state / "ana.json").stat().st_mtime_ns
    shutil.rmtree(zoe)
    assert run(COMMAND) == 0
    assert (state / "ana.json").stat().st_mtime_ns == before
    grades = (place / "out" / "grades.csv").read_text(encoding="utf-8").splitlines()
    assert [row.split(",")[:2] for row in grades[1:2]] == [["ana", "3"]]


def test_names_of_all_kinds_are_graded_and_other_files_named(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = ["\udce9", "=1+1", "<b>bold", "x\ny", "-rf", "a b", "$(id)"]
    for name in names:
        shutil.copytree(place / "in" / "ana", place / "in" / name)
    (place / "in" / "late.rar").write_bytes(b"Rar!")
    assert run([*COMMAND, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert len(document["students"]) == len(names) + 2
    marks = [each["marks"]["points"] for each in document["students"] if each["name"] != "ben"]
    assert marks == [3] * 8
    folders = {path.name for path in (place / "out" / "students").iterdir()}
    assert folders == {each["folder"] for each in document["students"]}
    assert len(folders) == len(names) + 2
    assert "neither folders nor known archives: late.rar" in document["remarks"][0]


def test_another_rubric_makes_other_marks(place: Path) -> None:
    assert run(COMMAND) == 0
    (place / "rubric.toml").write_text(RUBRIC.replace("points = 3", "points = 7"), encoding="utf-8")
    assert run(COMMAND) == 0
    grades = (place / "out" / "grades.csv").read_text(encoding="utf-8").splitlines()
    assert grades[1].startswith("ana,7,7,")


def test_a_time_of_nobody_is_told(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    late = "late = {deadline = 2027-01-31T12:00:00Z, per_day = 0.5}\n"
    (place / "rubric.toml").write_text(late + RUBRIC, encoding="utf-8")
    rows = "student,submitted\nana,2027-01-30T12:00:00Z\nBen,2027-01-30T12:00:00Z\n"
    (place / "times.csv").write_text(rows, encoding="utf-8")
    assert run(COMMAND) == 0
    assert "no time is known of any submission, so none is late" in capsys.readouterr().out
    assert run([*COMMAND, "--times", "times.csv"]) == 0
    said = capsys.readouterr().out
    assert "no time is known of 1 of 2 submissions, on time therefore: ben" in said
    assert "times of students without a submission: Ben" in said
