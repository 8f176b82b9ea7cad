"""Programs that are handed in: built and run in the sandbox, judged on scenes nobody has seen."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

from converters.frames.io import write_frame
from minirt.errors import InputError, ReferenceError
from minirt.explain.pixel import explain
from reference.cache import Cache
from reports.cli.main import run as minirt
from reports.explain.text import explanation_text
from reports.grade import student as grading
from reports.grade.assignment.assignment import read_assignment
from reports.grade.assignment.hidden import variant
from reports.grade.judging.judge import JudgingContext
from reports.grade.pages.class_files import grades_csv
from reports.grade.record import ClassRecord, Student
from reports.grade.run import GradeOptions, grade_class
from reports.grade.submission.students import digest_of, students_in
from reports.grade.submission.submission import open_submission
from tests.helpers.grade_class import SUBJECTS, honest, small

SCENE = "ball-on-quad"
RUBRIC = f"""
scenes = ["{SCENE}.json"]
zero = 0.5
may_claim = ["float32"]
hidden = {{ seed = 7, share = 0.5 }}
limits = {{ seconds = 10, build_seconds = 30 }}
[[part]]
name = "everything"
points = 10
"""
RUN = f'run = "{sys.executable} tracer.py {{scene}} {{out}}"\nout_as = "npz"\n'
COPIER = "import shutil, sys; shutil.copy(sys.path[0] + '/stored.npz', sys.argv[2])\n"
HANGING = "import time; time.sleep(600)\n"
CRASHING = "import os; print('my last words', flush=True); os.abort()\n"
LINK = "import os, sys; os.symlink('/etc/passwd', sys.argv[2])\n"


def program(folder: Path, name: str, code: str, extra: str = "") -> Path:
    place = folder / name
    place.mkdir(parents=True)
    (place / "minirt.toml").write_text(RUN + extra, encoding="utf-8")
    (place / "tracer.py").write_text(code, encoding="utf-8")
    return place


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("programs")


@pytest.fixture(scope="module")
def record(folder: Path) -> ClassRecord:
    """A class of programs, graded: 12 seconds in each process, so one fast test asks for it."""
    (folder / "rubric.toml").write_text(RUBRIC, encoding="utf-8")
    text = json.dumps(small(SCENE).to_dict())
    (folder / f"{SCENE}.json").write_text(text, encoding="utf-8")
    handed = folder / "in"
    tracer = (SUBJECTS / "tracer.py").read_text(encoding="utf-8")
    program(handed, "honest", tracer, 'build = "mv tracer.py t && mv t tracer.py"\n')
    write_frame(honest(SCENE), program(handed, "copier", COPIER) / "stored.npz")
    program(handed, "hanging", HANGING)
    program(handed, "crashing", CRASHING)
    program(handed, "linking", LINK)
    program(handed, "unbuilt", tracer, 'build = "echo no such thing; exit 3"\n')
    (handed / "frames").mkdir()
    write_frame(honest(SCENE), handed / "frames" / f"{SCENE}.npz")
    assignment = read_assignment(folder / "rubric.toml")
    context = JudgingContext(assignment, Cache(folder / "cache"), True)
    return grade_class(GradeOptions(students_in(handed), context, folder / "out", 2))


def student(record: ClassRecord, name: str) -> Student:
    return next(each for each in record.students if each.name == name)


def test_an_honest_program_earns_everything_on_hidden_scenes_too(record: ClassRecord) -> None:
    found = student(record, "honest")
    assert [result.state for result in found.results] == ["judged", "judged"]
    assert [result.number for result in found.results] == [0, 1]
    assert found.marks.points == 10


@pytest.mark.full
def test_an_answer_copied_from_the_public_scene_fails_the_hidden_one(record: ClassRecord) -> None:
    found = student(record, "copier")
    assert [bool(result.wrong) for result in found.results] == [False, True]
    assert found.marks.points == 5
    (part,) = found.marks.parts
    assert part.hidden_earned == 0
    said = [copy for copy in record.copies if copy.students == ("copier",)]
    assert any(copy.kind == "unchanging" for copy in said)
    assert "does not read its scene" in said[0].sentence


def digits(text: str) -> set[str]:
    """The first digits of every long number."""
    return {number[:9] for number in re.findall(r"\d\.\d{7,}", text)}


@pytest.mark.full
def test_no_page_of_a_student_holds_a_hidden_scene(record: ClassRecord, folder: Path) -> None:
    public = small(SCENE)
    hidden = variant(public, 7, 1)
    told = explanation_text(explain(hidden, 24, 18)) + hidden.canonical_json
    secret = digits(told) - digits(explanation_text(explain(public, 24, 18)))
    assert len(secret) > 20
    files = [path for path in (folder / "out" / "students").rglob("*") if path.is_file()]
    assert len(files) == 3 * len(record.students)
    for path in files:
        text = path.read_text(encoding="utf-8")
        assert digits(text) & secret == set(), path
        assert "seed" not in text
        assert hidden.sha256 not in text
    copier = (folder / "out" / "students" / "copier" / "report.md").read_text(encoding="utf-8")
    assert "0 of 5 points come from hidden scenes, which only programs render" in copier
    assert copier.count(SCENE) == 1  # of the public one


@pytest.mark.full
@pytest.mark.parametrize(
    ("name", "words"),
    [("hanging", "no answer within 10 s"), ("crashing", "SIGABRT"), ("linking", "symbolic link")],
)
def test_a_hostile_program_costs_its_own_marks(name: str, words: str, record: ClassRecord) -> None:
    found = student(record, name)
    assert found.marks.points == 0
    assert all(words in result.reason for result in found.results)
    assert len(found.results) == 2
    assert all("minirt-" not in result.reason for result in found.results)  # our folders' names


@pytest.mark.full
def test_a_crash_is_shown_with_its_last_words_of_public_scenes(
    record: ClassRecord, folder: Path
) -> None:
    public, hidden = student(record, "crashing").results
    assert "my last words" in public.output
    assert hidden.output == ""
    files = [*(folder / "out" / "students" / "crashing").iterdir()]
    assert len(files) == 3
    for path in files:  # Gradescope's too: there it is all that a student sees
        text = path.read_text(encoding="utf-8")
        assert "my last words" in text, path
        assert "crashed: the program was ended by SIGABRT" in text, path
    assert "no frame of 2 scenes: the program was ended by SIGABRT" in grades_csv(record)


def test_a_program_that_may_be_run_now_is_another_submission(tmp_path: Path) -> None:
    tracer = tmp_path / "tracer"
    tracer.write_bytes(b"")
    before = digest_of(tmp_path)
    tracer.chmod(0o755)
    assert digest_of(tmp_path) != before


@pytest.mark.full
def test_a_build_that_fails_is_shown_with_its_last_output(record: ClassRecord) -> None:
    found = student(record, "unbuilt")
    assert found.marks.points == 0
    assert "the build ended with status 3" in found.message
    assert "no such thing" in found.message


@pytest.mark.full
def test_frames_earn_nothing_on_hidden_scenes_and_that_is_said(record: ClassRecord) -> None:
    assert student(record, "frames").marks.points == 5
    assert "1 submission holds frames, which earn nothing on hidden scenes" in record.remarks


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("run = 'x {out}'", "does not say what to read"),
        ("run = '\"'", "not a command"),
        ("run = '../../bin/sh {scene} {out}'", "outside the submission"),
        ("run = 'cat /etc/passwd {scene} {out}'", "outside the submission; got /etc/passwd"),
        ("run = 'cat /usr/../etc/passwd {scene} {out}'", "outside the submission"),
        ("run = 'cat {tmp}/rubric.toml {scene} {out}'", "outside the submission"),
        ("precision = 'half'", "a precision that this assignment does not take; got half"),
        ("precision = 'float32'", "neither a program nor a frame"),
        ("runs = 1", "there is no such key"),
        ("run = 3", "not what the key takes; got 3"),
        ("run = [", "not TOML"),
        ("x = " + "[" * 5000, "not TOML"),
        ("out_as = 'gif'", "out_as"),
        ("#" * 70_000, "too long"),
    ],
)
def test_a_bad_manifest_is_one_sentence(text: str, words: str, tmp_path: Path) -> None:
    for name in ("in", "out"):
        (tmp_path / name).mkdir()
    text = text.replace("{tmp}", str(tmp_path))
    (tmp_path / "in" / "minirt.toml").write_text(text, encoding="utf-8")
    (tmp_path / "rubric.toml").write_text(RUBRIC, encoding="utf-8")
    (tmp_path / f"{SCENE}.json").write_text(json.dumps(small(SCENE).to_dict()), encoding="utf-8")
    rubric = read_assignment(tmp_path / "rubric.toml").rubric
    with pytest.raises(InputError) as caught:
        open_submission(tmp_path / "in", tmp_path / "out", [SCENE], rubric)
    assert words in str(caught.value)


def test_without_a_sandbox_no_program_is_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rubric.toml").write_text(RUBRIC, encoding="utf-8")
    (tmp_path / f"{SCENE}.json").write_text(json.dumps(small(SCENE).to_dict()), encoding="utf-8")
    program(tmp_path / "in", "ana", "print(1)\n")
    monkeypatch.setattr(grading, "sandbox_missing", lambda: "bubblewrap is not installed")
    assignment = read_assignment(tmp_path / "rubric.toml")
    context = JudgingContext(assignment, Cache(tmp_path / "cache"), True)
    options = GradeOptions(students_in(tmp_path / "in"), context, tmp_path / "out", 1)
    with pytest.raises(ReferenceError, match="bubblewrap is not installed") as caught:
        grade_class(options)
    assert caught.value.exit_status == 3


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["absent", "--rubric", "rubric.toml", "-o", "out"], "no such folder of submissions"),
        (["in", "--rubric", "absent.toml", "-o", "out"], "cannot be read"),
        (["in", "--rubric", "rubric.toml", "-o", "in/out"], "among the submissions"),
        (["empty", "--rubric", "rubric.toml", "-o", "out"], "no submission in the folder"),
        (["twice", "--rubric", "rubric.toml", "-o", "out"], "two submissions of one student"),
        (["in", "--rubric", "rubric.toml", "-o", "out", "--times", "bad.csv"], "line 2"),
        (["in", "--rubric", "rubric.toml", "-o", "out", "--times", "none.csv"], "a column"),
    ],
)
def test_bad_input_is_one_error(
    arguments: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rubric.toml").write_text(RUBRIC, encoding="utf-8")
    (tmp_path / f"{SCENE}.json").write_text(json.dumps(small(SCENE).to_dict()), encoding="utf-8")
    for name in ("in/ana", "empty", "twice/ana"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "twice" / "ana.zip").write_bytes(b"")
    (tmp_path / "bad.csv").write_text("student,submitted\nana,yesterday\n", encoding="utf-8")
    (tmp_path / "none.csv").write_text("who,when\n", encoding="utf-8")
    assert minirt(["grade", *arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("error: ")
    assert words in said.err
    assert not (tmp_path / "out").exists()
