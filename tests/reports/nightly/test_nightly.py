"""`minirt nightly`: what a night leaves, how it goes on after a kill, what is kept and told."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from minirt import load_scene
from minirt.errors import InputError
from minirt.quantities import STAGES
from minirt.scene import Scene
from reference import registry
from reference.fuzz.campaign import Campaign, CampaignOptions
from reference.mutants.floor import Floor
from reference.mutants.matrix import Kill
from reference.mutants.run import MutationRun
from reference.source import Reference
from reports import run as runs
from reports.cli.main import run
from reports.history.store import History
from reports.nightly import fuzz_step, steps
from reports.nightly import run as nightly_runs
from reports.nightly.landing import sentence
from reports.nightly.nightly_run import StepResult, all_runs
from reports.results import provenance as origin
from reports.results.record import Run
from tests.helpers.fake_references import HOSTILE, Faulty, Honest, small_scene
from tests.helpers.report_runs import run_of
from tests.reports.history.test_report import page_of

Night = Callable[..., int]
HERE = origin.provenance()


@cache
def compared(scenes: tuple[str, ...], references: tuple[Reference, ...]) -> Run:
    """The run of scenes, each given as its text: the same ones are compared once."""
    return run_of([load_scene(json.loads(text)) for text in scenes], references)


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What a night really does, in its order; each step in a moment, by a stand-in."""
    done: list[str] = []

    def verify(
        scenes: Sequence[Scene],
        references: Sequence[Reference],
        folder: Path,
        options: runs.RunOptions,
        *_: Any,
    ) -> None:
        done.append("verify")
        made = compared(tuple(scene.canonical_json for scene in scenes), tuple(references))
        stamp = replace(made.provenance, commit=origin.provenance().commit)
        runs.write_reports(
            replace(
                made, folder=folder, previous=options.previous, provenance=stamp, seconds=len(done)
            )
        )

    def run_campaign(seed: int, _: object, options: CampaignOptions, **more: object) -> Campaign:
        done.append(f"fuzz {options.seconds:g}")
        return Campaign(seed, 3, 3, 0, 99, 100, seconds=options.seconds)

    def mutants(names: Sequence[str], *_: object) -> MutationRun:
        done.append(f"mutants {' '.join(names) if len(names) < 9 else 'all'}")
        nothing: dict[str, int] = dict.fromkeys(STAGES, 0)
        original = Kill("none", "", "", "ray", 12, (), nothing)
        mutant = Kill("far-root", "S8", "", "t", 12, ("ball",), nothing | {"t": 7})
        return MutationRun(original, (mutant,))

    monkeypatch.setattr(steps, "run_verify", verify)
    for name in set(runs.REPORTS) - {"results.json"}:
        monkeypatch.setitem(runs.REPORTS, name, lambda _: "a report\n")
    monkeypatch.setattr(fuzz_step, "run_campaign", run_campaign)
    monkeypatch.setattr(steps, "run_mutants", mutants)
    monkeypatch.setattr("reference.mutants.floor.sensitivity_floor", lambda: Floor(1, 1, 1, 1))
    return done


@pytest.fixture
def night(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Night:
    """Run a night on one small scene against `honest`; from a commit."""
    monkeypatch.delenv("MINIRT_REQUIRE", raising=False)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MINIRT_HISTORY", raising=False)
    scene = tmp_path / "ball.json"
    scene.write_text(small_scene().canonical_json, encoding="utf-8")

    def call(*more: str, commit: str = "a", honest: Honest | None = None) -> int:
        stamp = replace(HERE, commit=commit * 40)
        monkeypatch.setattr("reports.nightly.options.provenance", lambda: stamp)
        monkeypatch.setattr(origin, "provenance", lambda: stamp)
        fakes = {"honest": honest or Honest()}
        monkeypatch.setattr(registry, "REFERENCES", fakes)
        return run(["nightly", str(scene), "--reference", "honest", "--out", "out", *more])

    return call


def names(out: Path) -> set[str]:
    return {path.name for path in out.iterdir() if path.is_dir()}


def only(out: Path) -> Path:
    (name,) = names(out)
    return out / name


def test_a_night_leaves_everything_in_its_place(
    tried: list[str], night: Night, tmp_path: Path
) -> None:
    assert night("--budget", "90s") == 0
    assert tried == ["mutants all", "verify", "fuzz 60", "fuzz 30"]
    out = tmp_path / "out"
    assert {path.name for path in out.iterdir() if path.is_file()} == {
        "index.html", "summary.md", "history.sqlite", ".lock",
    }  # fmt: skip
    folder = only(out)
    assert {path.name for path in folder.iterdir()} == {
        "report.html", "results.json", "junit.xml", "summary.md", "fuzz", "mutants.json",
        "night.json", "night.md", ".lock",
    }  # fmt: skip
    note = json.loads((folder / "night.json").read_text(encoding="utf-8"))
    assert list(note["steps"]) == ["mutants", "verify", "history", "fuzz"]
    fuzzed = json.loads((folder / "fuzz" / "fuzz.json").read_text(encoding="utf-8"))
    assert [r["seed"] for r in fuzzed["rounds"]] == [note["seed"], (note["seed"] + 1) % 2**32]
    assert (fuzzed["scenes"], fuzzed["exit_status"]) == (6, 0)
    assert (out / "summary.md").read_bytes() == (folder / "night.md").read_bytes()
    assert "PASS: mutants, verify, history, fuzz all passed" in (out / "summary.md").read_text()


@pytest.mark.full
def test_a_fault_in_the_second_night_is_a_change_with_its_two_commits(
    tried: list[str], night: Night, tmp_path: Path
) -> None:
    assert night(commit="a") == 0
    assert night(commit="b", honest=Faulty("honest")) == 1
    out = tmp_path / "out"
    with History(str(out / "history.sqlite"), create=False) as history:
        assert history.latest() == 2
    page = page_of((out / "index.html").read_text(encoding="utf-8"))
    (row,) = page.all("tr", "worse")
    for part in ("▲ worse", "ball", "passed → failed", "a" * 10, "b" * 10):
        assert part in row.text
    assert "✗ FAIL: verify: 1 of 1 scene; first wrong stage: shadow" in page.all("h1")[0].text
    (spark,) = [e for e in page.all("svg", "spark") if "aria-label" in e.attributes]
    assert spark.attributes["aria-label"] == "ball: 2 runs, 1 failed; changed last at run 2"
    assert len(page.all("line", "mark")) == 2  # in the drawing, and in the legend
    links = {e.attributes["href"] for e in page.all("a")} - {"#scenes"}
    assert len(links) > 8
    assert [href for href in links if not (out / href).is_file()] == []
    compared = (out / sorted(names(out))[1] / "compare.html").read_text(encoding="utf-8")
    assert "got worse" in page_of(compared).all("h1")[0].text
    assert "▲ ball × honest × shadow: ✓ equal" in (out / "summary.md").read_text(encoding="utf-8")


def test_a_clock_that_goes_back_hides_no_failure(
    tried: list[str], night: Night, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert night() == 0
    ahead = only(out)
    note = (ahead / "night.json").read_text(encoding="utf-8")
    (ahead / "night.json").write_text(note.replace('": "20', '": "30'), encoding="utf-8")
    ahead.rename(out / "3026-01-01")
    assert night(honest=Faulty("honest")) == 1
    page = page_of((out / "index.html").read_text(encoding="utf-8"))
    assert page.all("h1")[0].text.startswith("✗ FAIL: verify")
    assert "❌" in (out / "summary.md").read_text(encoding="utf-8")


def test_a_note_that_cannot_be_read_is_named(
    tried: list[str], night: Night, tmp_path: Path
) -> None:
    for k, text in enumerate(("{", '{"minirtNight": 2}', None, "yesterday", "2026-01-01T00:00:00")):
        folder = tmp_path / "out" / f"2026-01-0{k + 1}"
        folder.mkdir(parents=True)
        if text is not None:
            (folder / "night.json").write_text(text, encoding="utf-8")
    assert night() == 0
    (good,) = all_runs(tmp_path / "out")
    for k, started in ((4, "yesterday"), (5, "2026-01-01T00:00:00")):
        edited = good.record.model_copy(update={"started": started, "finished": None})
        path = tmp_path / "out" / f"2026-01-0{k}" / "night.json"
        path.write_text(edited.model_dump_json(), encoding="utf-8")
    assert night() == 0
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    named = ", ".join(f"2026-01-0{k}" for k in range(1, 6))
    assert f"that can be read: {named}." in text


@pytest.mark.full
def test_a_scene_that_goes_is_named(tried: list[str], night: Night, tmp_path: Path) -> None:
    other = tmp_path / "other.json"
    other.write_text(small_scene("other").canonical_json, encoding="utf-8")
    assert night(str(other), honest=Faulty("honest")) == 1
    assert night() == 0
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "From run 1 to run 2: 1 scene only in the first run: other" in text


def test_a_night_goes_on_in_another_history(tried: list[str], night: Night, tmp_path: Path) -> None:
    assert night() == 0
    folder = only(tmp_path / "out")
    note = (folder / "night.json").read_text(encoding="utf-8")
    unfinished = re.sub(r'"finished": "[^"]*"', '"finished": null', note)
    (folder / "night.json").write_text(unfinished.replace('"run": 1', '"run": 7'), encoding="utf-8")
    tried.clear()
    assert night("--history", str(tmp_path / "new.sqlite")) == 0
    assert tried == []
    (again,) = all_runs(tmp_path / "out")
    assert again.record.run == 1


def test_a_run_that_is_in_no_history_is_not_said_to_have_changed_nothing(
    tried: list[str], night: Night, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> int:
        raise InputError("the run cannot be recorded")

    monkeypatch.setattr(History, "append", refuse)
    assert night() == 3
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "Nothing: no scene" not in text
    assert "the run of the last night is not in the history" in text


def test_the_worst_step_speaks_first(tried: list[str], night: Night, tmp_path: Path) -> None:
    assert night() == 0
    (found,) = all_runs(tmp_path / "out")
    steps = {
        "mutants": StepResult(exit_status=3, sentence="no memory", seconds=1.0),
        "verify": StepResult(exit_status=1, sentence="FAIL: 1 of 3 scenes", seconds=1.0),
    }
    found.record = found.record.model_copy(update={"steps": steps})
    assert sentence(found) == "FAIL: verify: 1 of 3 scenes; also mutants"
    found.record = found.record.model_copy(update={"steps": {}})
    assert sentence(found).startswith("INCOMPLETE")


def test_a_night_of_nothing_new_says_so(tried: list[str], night: Night, tmp_path: Path) -> None:
    for commit in "abc":
        assert night(commit=commit) == 0
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "Nothing: no scene's state changed" in text
    assert page_of(text).all("tr", "worse") == []


def test_a_night_that_was_interrupted_goes_on_with_what_is_missing(
    tried: list[str], night: Night, tmp_path: Path
) -> None:
    assert night("--budget", "90s") == 0
    folder = only(tmp_path / "out")
    seed = json.loads((folder / "night.json").read_text(encoding="utf-8"))["seed"]
    fuzzed = folder / "fuzz" / "fuzz.json"
    first = json.loads(fuzzed.read_text(encoding="utf-8"))["rounds"][:1]
    fuzzed.write_text(json.dumps({"rounds": first}), encoding="utf-8")
    note = json.loads((folder / "night.json").read_text(encoding="utf-8"))
    note["finished"] = None
    for lost in ("fuzz", "history", "verify"):  # as if it had been killed before it was noted
        del note["steps"][lost]
    (folder / "night.json").write_text(json.dumps(note), encoding="utf-8")
    tried.clear()
    assert night("--budget", "90s") == 0
    assert tried == ["fuzz 30"]
    assert only(tmp_path / "out") == folder
    rounds = json.loads(fuzzed.read_text(encoding="utf-8"))["rounds"]
    assert [each["seed"] for each in rounds] == [seed, (seed + 1) % 2**32]
    with History(str(tmp_path / "out" / "history.sqlite"), create=False) as history:
        assert history.latest() == 1  # added once
    assert night("--budget", "90s") == 0
    assert len(names(tmp_path / "out")) == 2  # a finished night is over


@pytest.mark.parametrize("other", ["commit", "budget", "age"])
def test_another_question_is_another_night(
    other: str, tried: list[str], night: Night, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(fuzz_step, "run_campaign", interrupt)
        assert night() == 130
    if other == "age":
        path = only(tmp_path / "out") / "night.json"
        note = json.loads(path.read_text(encoding="utf-8"))
        note["started"] = "2020-01-01T00:00:00+00:00"
        path.write_text(json.dumps(note), encoding="utf-8")
    more = ["--budget", "5s"] if other == "budget" else []
    assert night(*more, commit="b" if other == "commit" else "a") == 0
    assert len(names(tmp_path / "out")) == 2
    assert "not finished" in (tmp_path / "out" / "index.html").read_text(encoding="utf-8")


HOLD = """
import fcntl, sys, time
file = open(sys.argv[1], "w")
fcntl.lockf(file, fcntl.LOCK_EX)
print("held", flush=True)
time.sleep(60)
"""


def test_a_night_at_work_is_left_alone_until_it_is_killed(
    tried: list[str], night: Night, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(fuzz_step, "run_campaign", interrupt)
        night()
    working = only(tmp_path / "out")
    command = [sys.executable, "-c", HOLD, str(working / ".lock")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout
        assert holder.stdout.readline() == "held\n"
        assert night("--keep", "1") == 0
        assert len(names(tmp_path / "out")) == 2  # neither taken nor removed
        holder.kill()
    tried.clear()
    assert night() == 0
    assert tried == ["fuzz 60"] * 20
    assert len(names(tmp_path / "out")) == 2


def test_old_nights_go_and_the_history_stays(
    tried: list[str], night: Night, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    for _ in range(2):
        assert night() == 0
    (out / "2026-01-01").mkdir()  # somebody's own
    (out / ".removed-2026-02-02-00").mkdir()  # of a kill
    for _ in range(2):
        assert night("--keep", "2") == 0
    kept = all_runs(out)
    assert [n.record.run for n in kept] == [3, 4]
    assert names(out) == {*(n.name for n in kept), "2026-01-01"}
    with History(str(out / "history.sqlite"), create=False) as history:
        assert history.latest() == 4
        assert len(history.entry(1).scenes) == 1
    page = page_of((out / "index.html").read_text(encoding="utf-8"))
    assert len(page.all("circle", "passed")) == 4 + 1  # the legend's


NOTE = "import os, pathlib, sys; pathlib.Path('told').write_text(os.environ['MINIRT_EXIT_STATUS'] "
NOTE += "+ os.environ['MINIRT_NIGHT'] + sys.stdin.read(), encoding='utf-8'); sys.exit(%d)"


def test_the_summary_is_told(tried: list[str], night: Night, tmp_path: Path) -> None:
    assert night("--notify", f'"{sys.executable}" -c "{NOTE % 0}"') == 0
    told = (tmp_path / "told").read_text(encoding="utf-8")
    folder = only(tmp_path / "out")
    assert told == f"0{folder}" + (folder / "night.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (f'"{sys.executable}" -c "{NOTE % 7}"', "exit status 7"),
        ("no-such-program", "No such file"),
        (f'"{sys.executable}" -c "import time; time.sleep(9)"', "no end within 0.2 s"),
    ],
)
def test_a_summary_that_nobody_took_is_no_good_night(
    command: str, said: str, tried: list[str], night: Night,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    if "sleep" in command:
        monkeypatch.setattr(nightly_runs, "NOTIFY_TIMEOUT", 0.2)
    assert night("--notify", command) == 3
    assert said in capsys.readouterr().err


def test_a_step_that_breaks_down_costs_itself(
    tried: list[str], night: Night, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> Campaign:
        raise RuntimeError("out of luck")

    monkeypatch.setattr(fuzz_step, "run_campaign", broken)
    assert night() == 3
    assert tried == ["mutants all", "verify"]
    text = (tmp_path / "out" / "summary.md").read_text(encoding="utf-8")
    assert "INCOMPLETE: fuzz: a mistake in minirt: RuntimeError: out of luck" in text


@pytest.mark.parametrize(
    ("found", "status"),
    [
        (Campaign(1, 3, 3, 0, 80, 100, seconds=99), 1),  # too vague
        (Campaign(1, 0, 0, 0, 0, 0, (("honest", "it is away"),), seconds=0), 3),
        (Campaign(1, 3, 0, 3, 0, 0, seconds=99), 3),  # nothing compared
        (Campaign(1, 3, 2, 0, 99, 100, (), ("a scene: no answer",), seconds=99), 3),
    ],
)
def test_a_campaign_that_proves_nothing_is_no_good_night(
    found: Campaign, status: int, tried: list[str], night: Night, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fuzz_step, "run_campaign", lambda *_, **__: found)
    assert night("--budget", "90s") == status


def test_the_example_in_the_help_runs(
    tried: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MINIRT_HISTORY", raising=False)
    assert run(["nightly", "--help"]) == 0
    (example,) = re.findall(r"Example: minirt (.*)", capsys.readouterr().out)
    words = [*shlex.split(example), "atlas:one-triangle", "--reference", "embree"]
    assert run(words) == 0
    assert tried == ["mutants all", "verify", *["fuzz 60"] * 20]
    assert (tmp_path / "nights" / "index.html").is_file()


def test_json_is_one_document(
    tried: list[str], night: Night, capsys: pytest.CaptureFixture[str]
) -> None:
    assert night("--json", "--mutants", "far-root") == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["exit_status"], document["run"]) == (0, 1)
    assert tried[0] == "mutants far-root"


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--budget", "soon"], "--budget: not a time; got 'soon'"),
        (["--budget", "0"], "--budget: not a time"),
        (["--keep", "0"], "--keep"),
        (["--notify", "'mail"], "--notify: not a command"),
        (["--mutants", "far-rot"], "no such mutant"),
        (["--history", "postgresql://a:hush@127.0.0.1:1/x"], "the history cannot be opened"),
        (["--out", "ball.json/out"], "cannot be written"),
        (["ball.json"], "two scenes have the same name; got ball"),
    ],
)
def test_bad_input_is_told_before_anything_is_done(
    more: list[str], said: str, tried: list[str], night: Night, capsys: pytest.CaptureFixture[str]
) -> None:
    assert night(*more) == 2
    (line, *hint) = capsys.readouterr().err.splitlines()
    assert said in line
    assert "hush" not in line
    assert len(hint) <= 1
    assert tried == []


@pytest.mark.full
def test_hostile_names_are_shown_as_text(tried: list[str], night: Night, tmp_path: Path) -> None:
    scene = tmp_path / "hostile.json"
    scene.write_text(small_scene(HOSTILE).canonical_json, encoding="utf-8")
    for honest in (Honest(), Faulty("honest")):
        night(str(scene), honest=honest)
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    page = page_of(text)
    assert page.all("img") == []
    assert page.all("script") == []
    assert "http" not in text.replace("http-equiv", "")
    assert any("${7*7} {{7*7}}" in element.text for element in page.all("th"))


@pytest.mark.full
def test_a_night_that_was_killed_goes_on(
    tried: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MINIRT_HISTORY", raising=False)
    (tmp_path / "ball.json").write_text(small_scene().canonical_json, encoding="utf-8")
    words = [
        "nightly",
        "ball.json",
        "--reference",
        "embree",
        "--budget",
        "600s",
        "--jobs",
        "1",
        "--out",
        "out",
    ]
    code = (
        "from reports.cli.main import main; from reports.nightly import steps; "
        "steps.mutants_step = "
        "lambda *_: steps.StepResult(exit_status=0, sentence='', seconds=0); main()"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, *words], start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    note, end = tmp_path / "out", time.monotonic() + 100
    while '"history"' not in "".join(p.read_text() for p in note.glob("*/night.json")):
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.05)
    process.kill()
    process.wait()
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)  # its workers
    before = (only(tmp_path / "out") / "results.json").read_bytes()
    assert run(words) == 0
    assert tried == ["fuzz 60"] * 10
    assert (only(tmp_path / "out") / "results.json").read_bytes() == before


@pytest.mark.full
def test_a_real_night_with_a_small_budget(
    night: Night, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fuzz_step, "MOST_SCENES", 2)
    monkeypatch.setattr(steps, "run_mutants", lambda *_: 1 / 0)  # has its own tests
    assert night("--budget", "1s", "--jobs", "1") == 3
    folder = only(tmp_path / "out")
    note = json.loads((folder / "night.json").read_text(encoding="utf-8"))
    assert {name: step["exit_status"] for name, step in note["steps"].items()} == {
        "verify": 0, "history": 0, "fuzz": 0, "mutants": 3,
    }  # fmt: skip
    fuzzed = json.loads((folder / "fuzz" / "fuzz.json").read_text(encoding="utf-8"))
    assert fuzzed["compared"] == fuzzed["scenes"] >= 1
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.partition("</head>")[0].count("<title>") == 1
