"""The gate from the command line: how each way of being wrong, or right, ends."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from converters.frames.io import write_frame
from converters.scene_folder import plain_document
from minirt.frame import Frame
from minirt.render import render
from reports.cli.main import run
from reports.gate.subject import Subject, claim_of
from tests.helpers.fake_references import small_scene
from tests.helpers.places import HELPERS
from tests.helpers.tiers import tiered

PROGRAM = f"{sys.executable} {HELPERS / 'gate_subjects.py'} {{scene}} {{out}}"

Gate = Callable[..., tuple[int, dict[str, Any]]]


@pytest.fixture
def gate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Gate:
    """Runs the gate on a small scene of its own; exit status and results."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(HELPERS)
    scene = tmp_path / "ball.json"
    scene.write_text(json.dumps(plain_document(small_scene())), encoding="utf-8")

    def judged(*options: str) -> tuple[int, dict[str, Any]]:
        out = str(tmp_path / "report")
        status = run(["gate", str(scene), "-o", out, "-j", "1", "--json", *options])
        document: dict[str, Any] = json.loads(capsys.readouterr().out)
        return status, document

    return judged


def states(document: dict[str, Any]) -> dict[str, str]:
    """The state of each quantity of the only scene."""
    ((answer,),) = [scene["references"] for scene in document["scenes"]]
    return {check["quantity"]: check["state"] for check in answer["checks"]}


def reasons(document: dict[str, Any]) -> set[str]:
    """All that is said of what did not pass."""
    ((answer,),) = [scene["references"] for scene in document["scenes"]]
    return {check["reason"] for check in answer["checks"] if check["state"] != "passed"}


def test_an_honest_function_passes_in_every_quantity(gate: Gate) -> None:
    status, document = gate("--python", "gate_subjects:honest")
    assert status == 0
    assert set(states(document).values()) == {"passed"}
    assert len(states(document)) == 20


@pytest.mark.parametrize("out_as", tiered(["npz", "exr", "folder"], lambda out_as: out_as == "npz"))
def test_an_honest_program_passes_through_every_format(gate: Gate, out_as: str) -> None:
    status, document = gate("--cmd", PROGRAM, "--out-as", out_as)
    assert status == 0, document["verdict"]
    found = states(document)
    assert {name for name, state in found.items() if state != "passed"} == set()
    assert document["provenance"]["programs"]["subject"] == [Path(sys.executable).name]


def test_frames_rendered_earlier_are_judged_and_a_lacking_one_fails(
    gate: Gate, tmp_path: Path
) -> None:
    frames = tmp_path / "frames"
    frames.mkdir()
    status, document = gate("--frames", str(frames))
    assert status == 1
    assert "no frame of the scene" in next(iter(reasons(document)))
    arrays = render(small_scene()).arrays
    write_frame(Frame(arrays), frames / "ball.npz")
    status, document = gate("--frames", str(frames))
    assert status == 0
    arrays["shadow"][30, 10] = 1 - arrays["shadow"][30, 10]
    write_frame(Frame(arrays), frames / "ball.npz")
    status, document = gate("--frames", str(frames))
    assert status == 1
    assert states(document)["shadow"] == "failed"
    assert document["scenes"][0]["first_wrong_stage"] == "shadow"


def test_the_command_that_shows_the_first_wrong_pixel_is_named(
    gate: Gate, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    subject = ["--python", "gate_subjects:no_half_pixel", "--precision", "float32"]
    assert run(["gate", str(tmp_path / "ball.json"), "-o", str(tmp_path / "out"), *subject]) == 1
    said = capsys.readouterr().err
    (line,) = (line for line in said.splitlines() if line.startswith("look closer: minirt "))
    arguments = shlex.split(line)[3:]
    assert run(arguments) == 1
    assert "The first wrong stage is ray" in capsys.readouterr().out


def test_of_two_frames_of_a_scene_none_is_chosen(gate: Gate, tmp_path: Path) -> None:
    frames = tmp_path / "frames"
    frames.mkdir()
    frame = render(small_scene(), quantities=["hit"])
    write_frame(frame, frames / "ball.npz")
    write_frame(frame, frames / "ball.exr")
    status, document = gate("--frames", str(frames))
    assert status == 1
    assert "more than one frame" in next(iter(reasons(document)))


def test_a_file_beside_frames_in_float64_does_not_make_them_coarse(tmp_path: Path) -> None:
    write_frame(render(small_scene(), quantities=["hit"]), tmp_path / "ball.npz")
    (tmp_path / "README.txt").write_text("how it was rendered")
    assert claim_of(Subject(frames=tmp_path)).handed == "float64"
    (tmp_path / "ball").mkdir()
    assert claim_of(Subject(frames=tmp_path)).handed == "float32"


def test_a_mistake_fails_and_names_its_stage(gate: Gate, tmp_path: Path) -> None:
    status, document = gate("--python", "gate_subjects:no_half_pixel")
    assert status == 1
    assert document["scenes"][0]["first_wrong_stage"] == "ray"
    assert "agrees with rule S2 without the half pixel" in document["verdict"]["sentence"]
    named = document["scenes"][0]["references"][0]["diagnosis"]
    assert named[0].startswith("agrees with rule S2 without the half pixel")
    junit = (tmp_path / "report" / "junit.xml").read_text(encoding="utf-8")
    assert "it agrees with rule S2 without the half pixel" in junit


def test_float32_passes_as_float32_and_not_as_float64(gate: Gate) -> None:
    status, _ = gate("--python", "gate_subjects:single", "--precision", "float32")
    assert status == 0
    status, document = gate("--python", "gate_subjects:single")
    assert status == 1
    assert "depth" in {name for name, state in states(document).items() if state == "failed"}


def test_a_function_cannot_widen_its_claim(gate: Gate) -> None:
    status, document = gate("--python", "gate_subjects:widening")
    assert status == 1
    assert {n for n, state in states(document).items() if state == "failed"} == {"position"}


@pytest.mark.parametrize(
    ("function", "status", "words"),
    [
        ("one_nan", 1, "1 of"),
        ("wrong_size", 1, "wrong size"),
        ("unknown_name", 1, "unknown quantity"),
        ("no_mapping", 1, "not a mapping"),
        ("raising", 3, "ZeroDivisionError: the light is off"),
        ("leaving", 3, "SystemExit: 0"),
        ("nowhere", 1, "there is no such function"),
    ],
)
def test_a_function_that_answers_badly_is_told_why(
    gate: Gate, function: str, status: int, words: str
) -> None:
    ended, document = gate("--python", f"gate_subjects:{function}")
    assert ended == status
    assert any(words in reason for reason in reasons(document)), reasons(document)


@pytest.mark.parametrize(
    ("code", "status", "words"),
    [
        ("raise SystemExit(3)", 3, "ended with status 3"),
        ("pass", 1, "no such file"),
        ("open(out, 'w').write('P5')", 1, "cannot be read"),
        ("import time; time.sleep(60)", 3, "no answer within 5 s"),
        ("import os; os.abort()", 3, "SIGABRT"),
    ],
)
def test_a_program_that_ends_badly_costs_its_scene_and_shows_its_output(
    gate: Gate, tmp_path: Path, code: str, status: int, words: str
) -> None:
    program = tmp_path / "program.py"
    program.write_text(f"import sys; out = sys.argv[1]; print('hello from it', flush=True); {code}")
    command = f"{sys.executable} {program} {{out}}"
    ended, document = gate("--cmd", command, "--timeout", "5" if "sleep" in code else "60")
    assert ended == status
    assert any(words in reason for reason in reasons(document)), reasons(document)
    if status == 3:
        assert "hello from it" in document["scenes"][0]["references"][0]["output"]


def test_what_is_required_must_be_given(gate: Gate) -> None:
    status, document = gate("--python", "gate_subjects:few")
    assert status == 0
    assert states(document)["normal"] == "not given"
    status, document = gate("--python", "gate_subjects:few", "--require", "hit,normal")
    assert status == 1
    assert states(document)["normal"] == "failed"
    status, document = gate("--python", "gate_subjects:few", "--quantities", "hit,depth")
    assert status == 0
    assert states(document) == {"hit": "passed", "depth": "passed"}


def test_nobody_may_declare_more_than_is_allowed(gate: Gate) -> None:
    subject = "--python", "gate_subjects:honest"
    status, document = gate(*subject, "--delta", "0.01", "--max-delta", "0.001")
    assert status == 2
    assert "wider than allowed" in document["error"]["what"]
    status, _ = gate(*subject, "--delta", "1e-9", "--max-delta", "0.001")
    assert status == 0


def test_nothing_passes_by_being_vague(gate: Gate) -> None:
    status, document = gate("--python", "gate_subjects:honest", "--delta", "0.2")
    assert status == 1
    assert any("certain" in reason for reason in reasons(document))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), "one implementation at a time"),
        (("--cmd", "a {scene} {out}", "--python", "a:b"), "one implementation at a time"),
        (("--cmd", "tracer {scene}"), "where to write"),
        (("--cmd", "'"), "not a command"),
        (("--python", "module"), "not a function"),
        (("--python", "a:b", "--sandbox"), "only a program"),
        (("--python", "a:b", "--update-baseline"), "no baseline"),
        (("--python", "a:b", "--until", "soon"), "not a date"),
        (("--python", "a:b", "--quantities", "dept"), "unknown quantity"),
        (("--python", "a:b", "--quantities", "hit", "--require", "hit,normal"), "not judged"),
    ],
)
def test_misuse_is_one_clear_error(gate: Gate, options: tuple[str, ...], words: str) -> None:
    status, document = gate(*options)
    assert status == 2
    assert words in document["error"]["what"]


def test_a_baseline_lets_known_failures_pass_until_their_day(gate: Gate, tmp_path: Path) -> None:
    known = tmp_path / "known.json"
    subject = "--python", "gate_subjects:no_half_pixel", "--baseline", str(known)
    status, _ = gate(*subject, "--update-baseline", "--reason", "issue 12", "--until", "2999-01-01")
    assert status == 0
    status, document = gate(*subject)
    assert status == 0
    assert "known" in states(document).values()
    assert "failed" not in states(document).values()
    assert document["verdict"]["sentence"].startswith("PASS, with ")
    assert "no other wrong pixel" in document["verdict"]["sentence"]
    # What is not listed fails still.
    listed = json.loads(known.read_text(encoding="utf-8"))
    listed["known"] = [entry for entry in listed["known"] if entry["quantity"] != "ray"]
    known.write_text(json.dumps(listed), encoding="utf-8")
    status, document = gate(*subject)
    assert status == 1
    assert states(document)["ray"] == "failed"
    # What passes again is said; what is past its day fails.
    status, document = gate("--python", "gate_subjects:honest", "--baseline", str(known))
    assert status == 0
    assert any("passes again" in remark for remark in document["remarks"])
    for entry in listed["known"]:
        entry["until"] = "2001-01-01"
    known.write_text(json.dumps(listed), encoding="utf-8")
    status, document = gate(*subject)
    assert status == 1
    assert any("was excused until 2001-01-01" in remark for remark in document["remarks"])


def test_a_pipe_in_the_place_of_a_frame_is_said_to_be_one(gate: Gate, tmp_path: Path) -> None:
    program = tmp_path / "pipe.py"
    program.write_text("import os, sys; os.mkfifo(sys.argv[2])", encoding="utf-8")
    status, document = gate("--cmd", f"{sys.executable} {program} {{scene}} {{out}}")
    assert status == 1
    (reason,) = reasons(document)
    assert reason.startswith("the program left something else than files: a pipe among the files")
    assert "room" not in reason


@pytest.mark.full
def test_a_known_failure_that_grows_is_not_excused(gate: Gate, tmp_path: Path) -> None:
    known = tmp_path / "known.json"
    subject = "--python", "gate_subjects:no_half_pixel", "--baseline", str(known)
    gate(*subject, "--update-baseline")
    listed = json.loads(known.read_text(encoding="utf-8"))
    (depth,) = (entry for entry in listed["known"] if entry["quantity"] == "depth")
    assert depth["wrong"] > 10
    depth["wrong"] -= 1
    known.write_text(json.dumps(listed), encoding="utf-8")
    status, document = gate(*subject)
    assert status == 1
    assert states(document)["depth"] == "failed"
    assert any(f"{depth['wrong']} were excused" in reason for reason in reasons(document))
    depth["wrong"] = None
    known.write_text(json.dumps(listed), encoding="utf-8")
    assert gate(*subject)[0] == 0


def test_a_broken_baseline_is_refused(gate: Gate, tmp_path: Path) -> None:
    known = tmp_path / "known.json"
    for text in ("", "[]", '{"minirtBaseline": 1, "known": [{"scene": "a"}]}'):
        known.write_text(text, encoding="utf-8")
        status, document = gate("--python", "a:b", "--baseline", str(known))
        assert status == 2
        assert "not a baseline" in document["error"]["what"]
