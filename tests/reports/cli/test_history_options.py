"""`verify` and `gate` add their runs to a history: which, when, and what if it refuses."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from minirt.errors import InputError
from minirt.scene import Scene
from reference import registry
from reference.source import Reference
from reports.cli.main import run
from reports.history.previous import PreviousRun
from reports.history.store import History
from reports.results.provenance import provenance, without_passwords
from reports.results.record import Run
from reports.run import RunOptions, write_reports
from tests.helpers.fake_references import Honest, small_scene
from tests.helpers.report_runs import run_of

Command = Callable[..., int]


@pytest.fixture
def rendered(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[PreviousRun | None]:
    """What each run was told of those before it; runs are made in this process."""
    told: list[PreviousRun | None] = []

    def stand_in(
        scenes: Sequence[Scene],
        references: Sequence[Reference],
        out: Path,
        options: RunOptions,
        *_: Any,
    ) -> Run:
        told.append(options.previous)
        Path(out).mkdir(exist_ok=True)
        made = run_of(scenes, [Honest(reference.name) for reference in references])
        made = replace(
            made, folder=Path(out), previous=options.previous, judged=options.judged,
            provenance=provenance(), seconds=float(len(told)),
        )  # fmt: skip
        write_reports(made)
        return made

    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MINIRT_HISTORY", raising=False)
    monkeypatch.delenv("MINIRT_REQUIRE", raising=False)
    monkeypatch.setattr("reports.history.recording.run_verify", stand_in)
    monkeypatch.setattr(registry, "REFERENCES", {"honest": Honest()})
    (tmp_path / "ball.json").write_text(small_scene().canonical_json, encoding="utf-8")
    return told


def verify(*more: str) -> int:
    return run(["verify", "ball.json", "--reference", "honest", "--out", "out", *more])


def test_runs_add_up_beside_the_reports(
    rendered: list[PreviousRun | None], capsys: pytest.CaptureFixture[str]
) -> None:
    for _ in range(2):
        assert verify() == 0
    assert "history: run 2 in out/history.sqlite\n" in capsys.readouterr().err
    first, second = rendered
    assert first is not None
    assert second is not None
    assert first.last is None
    assert second.last is not None
    assert (second.last.run, second.last.state) == (1, "passed")
    assert len(second.trends["ball"]) == 1
    assert len(second.cells) == 20


def test_a_gate_has_a_series_of_its_own(rendered: list[PreviousRun | None]) -> None:
    assert verify() == 0
    for _ in range(2):
        gate = ["gate", "ball.json", "--python", "tracer:render", "--out", "out", "--no-cache"]
        assert run(gate) == 0
    last = [previous.last for previous in rendered if previous is not None]
    assert [point and point.run for point in last] == [None, None, 2]
    with History("out/history.sqlite", create=False) as history:
        assert history.entry(3).series == "gate: tracer:render"
    document = json.loads(Path("out/results.json").read_text(encoding="utf-8"))
    assert document["judged"] == "tracer:render"


@pytest.mark.full
def test_another_place_or_none(
    rendered: list[PreviousRun | None], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert verify("--no-history") == 0
    assert verify("--history", "mine.sqlite") == 0
    monkeypatch.setenv("MINIRT_HISTORY", "mine.sqlite")
    assert verify() == 0
    assert not Path("out/history.sqlite").exists()
    with History("mine.sqlite", create=False) as history:
        assert history.number("latest") == 2
    assert rendered[0] is None


@pytest.mark.parametrize("command", ["verify", "gate"])
def test_a_history_that_cannot_be_opened_stops_it_before_anything_is_rendered(
    command: str, rendered: list[PreviousRun | None], capsys: pytest.CaptureFixture[str]
) -> None:
    Path("notes.txt").write_text("buy milk, " * 400, encoding="utf-8")
    how = ["--reference", "honest"] if command == "verify" else ["--python", "tracer:render"]
    assert run([command, "ball.json", *how, "--history", "notes.txt"]) == 2
    assert rendered == []
    assert "file is not a database" in capsys.readouterr().err


def test_a_history_that_refuses_costs_no_run(
    rendered: list[PreviousRun | None],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def refuse(*_: object) -> int:
        raise InputError("the run cannot be recorded", where="db", got="it went away")

    with monkeypatch.context() as patch:
        patch.setattr(History, "append", refuse)
        assert verify() == 3
    out, err = capsys.readouterr()
    assert "PASS: 1 scene agrees with honest" in out
    assert "history: db: the run cannot be recorded; got it went away" in err
    assert "minirt report record out/results.json adds the run later" in err
    assert run(["report", "record", "out/results.json", "--history", "out/history.sqlite"]) == 0
    with History("out/history.sqlite", create=False) as history:
        assert history.number("latest") == 1


def test_no_report_holds_a_password(
    rendered: list[PreviousRun | None], monkeypatch: pytest.MonkeyPatch
) -> None:
    url = "postgresql://ana:hush-hush@db/minirt?sslpassword=hush-hush"
    monkeypatch.setattr(sys, "argv", ["minirt", "verify", "--history", url])
    assert verify() == 0
    texts = [path.read_text(encoding="utf-8") for path in Path("out").glob("*.*m*")]
    texts += [path.read_text(encoding="utf-8") for path in Path("out").glob("*.json")]
    assert any("ana:***@db" in text for text in texts)
    assert not any("hush" in text for text in texts)
    assert b"hush" not in Path("out/history.sqlite").read_bytes()


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a://u:p@h/d", "a://u:***@h/d"),
        ("a://u:p@q@h/d?x=1&password=s&y=2", "a://u:***@h/d?x=1&password=***&y=2"),
        ("https://example.org:80/@x", "https://example.org:80/@x"),
        ("render 10:30 a@b", "render 10:30 a@b"),
    ],
)
def test_a_password_becomes_stars(text: str, shown: str) -> None:
    assert without_passwords(text) == shown
