"""The history in SQLite and in PostgreSQL: what goes in comes out, and what is refused, and how."""

from __future__ import annotations

import json
import math
import os
import sqlite3
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from minirt.errors import InputError
from reports.history.entry import LONGEST_NAME, entry_of, kept_name, read_entry
from reports.history.previous import Point
from reports.history.recording import previous_run
from reports.history.store import History
from reports.results.record import results_document, results_json
from reports.results.words import plain
from tests.helpers.fake_references import HOSTILE
from tests.helpers.history_runs import document, entry, sorted_cells, whole, with_cell
from tests.helpers.history_writers import READY, append_many
from tests.helpers.postgres_server import PASSWORD, Server
from tests.helpers.report_runs import empty_run, good_run, troubled_run


@pytest.mark.parametrize("made", [good_run, troubled_run, empty_run])
def test_a_run_comes_back_as_it_went_in(made: object, target: str) -> None:
    assert callable(made)
    given = entry_of(results_document(made()))
    with History(target) as history:
        number = history.append(given)
        found = history.entry(number)
    assert found.number == number
    assert sorted(found.cells(), key=lambda cell: cell.name) == sorted(
        given.cells(), key=lambda cell: cell.name
    )
    assert replace(found, scenes=(), number=None) == replace(given, scenes=())
    for back, there in zip(found.scenes, given.scenes, strict=True):
        assert replace(back, answers=()) == replace(there, answers=())
        names = [answer.reference for answer in back.answers]
        assert names == [answer.reference for answer in there.answers]


def test_what_is_kept_is_what_the_run_said() -> None:
    run = troubled_run()
    kept = {cell.name: cell.check for cell in entry_of(results_document(run)).cells()}
    seen = 0
    for result in run.results:
        for answer in result.references:
            for check in answer.checks:
                cell = kept[plain(result.scene.name), answer.reference, check.quantity]
                assert (cell.state, cell.wrong) == (check.state, check.wrong)
                assert (cell.certain, cell.pixels) == (check.certain, check.pixels)
                if check.state in ("passed", "failed"):
                    assert cell.ratio == check.ratio
                seen += 1
    assert seen == len(kept) == 360
    assert any(cell.ratio == math.inf for cell in kept.values())
    scene = entry_of(results_document(run)).scenes[0]
    assert (scene.ratio, scene.name) == (math.inf, plain(HOSTILE))
    assert scene.sha256 == run.results[0].scene.sha256
    assert scene.peak_memory == 100 * 2**20


def test_a_run_is_kept_once(target: str) -> None:
    with History(target) as history:
        first = history.append(entry(1))
        assert history.append(entry(2)) != first
        assert history.append(entry(1)) == first


def test_runs_are_named_by_number_latest_and_previous(target: str) -> None:
    with History(target) as history:
        with pytest.raises(InputError, match="holds no run yet"):
            history.number("latest")
        first = history.append(entry(1))
        with pytest.raises(InputError, match="no run before the latest"):
            history.number("previous")
        other = history.append(entry(2, judged="./tracer {scene} {out}"))
        third = history.append(entry(3))
        assert history.number("latest") == third
        assert history.number("previous") == first  # the other one asked another question
        assert history.number(str(other)) == other
        for word in ("0", str(third + 1), "-1", "yesterday", "", "9" * 30, "²"):
            with pytest.raises(InputError, match="no such run"):
                history.number(word)


def test_what_came_before_is_of_the_same_series(target: str) -> None:
    failing = {"state": "failed", "ratio": math.inf, "wrong": 7}
    with History(target) as history:
        wanted = [(scene.name, scene.sha256) for scene in entry().scenes]
        nothing = previous_run(history, wanted, "", ["honest"])
        assert (nothing.last, nothing.cells, nothing.trends) == (None, {}, {})
        first = history.append(entry(1, started="2026-11-20T02:00:00+00:00", commit="a" * 40))
        second = history.append(with_cell(entry(2, commit="b" * 40), **failing))
        history.append(entry(3, judged="another"))
        history.append(entry(4, references=("honest", "more")))
        before = previous_run(history, [*wanted, ("new", "0" * 64)], "", ["honest"])
    assert before.last is not None
    assert (before.last.run, before.last.commit, before.last.ratio) == (second, "b" * 40, None)
    cell = sorted_cells(entry())[0].check.quantity
    broken = entry().scenes[0].answers[0].checks[0].quantity
    found = before.cells["ball", "honest", broken]
    assert (found.state, found.ratio) == ("failed", math.inf)
    assert before.cells["second", "honest", cell].state == "passed"
    assert dict(before.scenes) == dict(wanted)
    assert set(before.trends) == {"ball", "second"}
    ball = before.trends["ball"]
    assert [point.run for point in ball] == [first, second]
    worst = entry().scenes[0].ratio
    assert ball[0] == Point(
        first, "2026-11-20T02:00:00+00:00", "a" * 40, "passed", worst, dict(wanted)["ball"],
        entry().dirty,
    )  # fmt: skip
    assert ball[1].ratio == math.inf


def test_a_hostile_name_is_found_again_under_its_own(target: str) -> None:
    run = troubled_run()
    with History(target) as history:
        history.append(entry_of(results_document(run)))
        before = previous_run(history, [(HOSTILE, "")], "", run.references)
    assert set(before.scenes) == {HOSTILE, "ball"}
    assert set(before.trends) == {HOSTILE}
    assert (HOSTILE, "honest", "hit") in before.cells


def test_two_that_begin_and_write_at_once_lose_nothing(target: str) -> None:
    digests = [[f"{k}-{mark}" for mark in range(25)] for k in range(2)]
    gate = READY.Barrier(2)
    writers = [READY.Process(target=append_many, args=(target, entry(), d, gate)) for d in digests]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join(60)
    assert [writer.exitcode for writer in writers] == [0, 0]
    cells = sum(1 for _ in entry().cells())
    with History(target, create=False) as history:
        numbers = range(1, history.number("latest") + 1)
        kept = [whole(history, n, cells).digest for n in numbers]
    assert sorted(kept) == sorted(digests[0] + digests[1])


def test_a_reader_reads_while_somebody_writes(tmp_path: Path) -> None:
    target = tmp_path / "history.sqlite"
    with History(str(target)) as history:
        history.append(entry(1))
        with sqlite3.connect(target, isolation_level=None) as writer:
            writer.execute("BEGIN IMMEDIATE")
            writer.execute("DELETE FROM minirt_runs")
            assert history.number("latest") == 1
            writer.execute("ROLLBACK")
        writer.close()


def test_who_may_only_read_reads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "100 % #1?"
    folder.mkdir()
    file = folder / "history.sqlite"
    with History(str(file)) as history:
        history.append(entry(1))
    monkeypatch.setattr("os.access", lambda _, mode: mode != os.W_OK)
    with History(str(file), create=False) as history:
        assert whole(history, 1, 40).digest == entry(1).digest
        assert [path.name for path in folder.iterdir()] == [file.name]
        with pytest.raises(InputError, match="cannot be recorded; got attempt to write a readonly"):
            history.append(entry(2))
    with History(str(file)) as writer, writer._writing() as _:
        assert len(list(folder.iterdir())) == 3
        with History(str(file), create=False) as history:
            assert history.latest() == 1


def test_without_its_wal_a_closed_history_is_whole(tmp_path: Path) -> None:
    with History(str(tmp_path / "history.sqlite")) as history:
        history.append(entry(1))
    assert [path.name for path in tmp_path.iterdir()] == ["history.sqlite"]


def test_a_server_that_is_gone_costs_one_sentence(server: Server) -> None:
    import psycopg

    target = server.fresh()
    with History(target) as history:
        history.append(entry(1))
        name = target.rpartition("/")[2]
        with psycopg.connect(server.url("postgres"), autocommit=True) as connection:
            connection.execute(f"DROP DATABASE {name}".encode())
        with pytest.raises(InputError, match="the run cannot be recorded; got") as caught:
            history.append(entry(2))
    assert PASSWORD not in str(caught.value)


def test_a_reader_begins_no_history(server: Server, tmp_path: Path) -> None:
    for target in (str(tmp_path / "none.sqlite"), server.fresh()):
        with pytest.raises(InputError, match="no history here"):
            History(target, create=False)
    assert list(tmp_path.iterdir()) == []


BAD = {
    "not a database": ("notes.txt", "file is not a database"),
    "another program's": ("other.sqlite", "a database of another program; got the table 'books'"),
    "a newer minirt's": ("newer.sqlite", "a history of a newer minirt; got version '9999'"),
    "a folder": ("folder", "got a folder"),
    "no such folder": ("no/such/history.sqlite", "got no such folder"),
    "empty name": ("", "not a place"),
    "in memory": ("sqlite://", "not a file"),
    "unknown kind": ("klingon://owner:hush-hush@host/x", "no such kind of database"),
    "no driver": ("mysql://owner:hush-hush@host/x", "driver is not installed"),
    "no server": ("postgresql://owner:hush-hush@127.0.0.1:1/x", "Connection refused"),
    "no URL": ("post gres://owner:hush-hush@host:port/x", "not a URL"),
    "no port": ("postgresql://owner:hush-hush@host:port/x", "not a URL"),
    "bad option": ("postgresql://owner:hush-hush@127.0.0.1:1/x?nosuch=hush-hush", "nosuch"),
}


@pytest.mark.parametrize("bad", BAD)
def test_what_cannot_be_opened_is_one_clear_error(
    bad: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("notes.txt").write_text("buy milk, " * 400, encoding="utf-8")
    Path("folder").mkdir()
    with History("newer.sqlite") as history:
        history.append(entry(1))
    for file, statement in (
        ("other.sqlite", "CREATE TABLE books (id INTEGER)"),
        ("newer.sqlite", "UPDATE minirt_version SET version_num = '9999'"),
    ):
        connection = sqlite3.connect(file)
        connection.execute(statement)
        connection.commit()
        connection.close()
    kept = {path.name: path.stat().st_size for path in tmp_path.iterdir()}
    target, said = BAD[bad]
    with pytest.raises(InputError) as caught:
        History(target)
    assert said in str(caught.value)
    assert "hush" not in str(caught.value)
    assert caught.value.where
    assert caught.value.expected
    assert {path.name: path.stat().st_size for path in tmp_path.iterdir()} == kept


def test_a_wrong_password_is_not_repeated(server: Server) -> None:
    with pytest.raises(InputError, match="password authentication failed") as caught:
        History(server.url("postgres", "wr0ng-secret"))
    assert "wr0ng-secret" not in str(caught.value)
    assert f"owner@127.0.0.1:{server.port}/postgres" in str(caught.value)


def test_results_are_read_from_a_file_or_its_folder(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    path.write_text(results_json(good_run()), encoding="utf-8")
    assert read_entry(path) == read_entry(tmp_path) == entry_of(results_document(good_run()))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ("[]", "not the results of a run"),
        ('{"minirtResults": 1}', "not the results of a run; got verdict: Field required"),
        (None, "No such file"),
    ],
)
def test_a_file_that_is_none_is_one_clear_error(
    text: str | None, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "results.json"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=said):
        read_entry(path)


def test_a_document_of_version_1_without_what_was_added_is_still_one() -> None:
    old = document()
    del old["judged"], old["remarks"]
    assert entry_of(old) == entry_of(document())


def test_long_names_that_begin_alike_stay_apart() -> None:
    alike = "A" * 10_000
    names = [kept_name(alike + last) for last in "xy"]
    assert len(set(names)) == 2
    assert {len(name) for name in names} == {LONGEST_NAME}
    assert kept_name("A" * LONGEST_NAME) == "A" * LONGEST_NAME


def test_a_number_that_no_database_holds_is_one_clear_error(tmp_path: Path) -> None:
    huge = document()
    huge["scenes"][0]["peak_memory"] = 10**30
    with (
        History(str(tmp_path / "history.sqlite")) as history,
        pytest.raises(InputError, match="the run cannot be recorded"),
    ):
        history.append(entry_of(huge))


def _wrong(results: dict[str, Any], **changes: object) -> None:
    results["scenes"][0]["references"][0]["checks"][1] |= changes


CONVICTED = {"pixels": 9, "seconds": 1.0, "counts": [], "convicted": 1, "convictions": []}
CONTRADICTIONS: dict[str, tuple[Callable[[dict[str, Any]], None], str]] = {
    "wrong pixels": (lambda d: _wrong(d, wrong=7), "ball × honest × hit: .*got passed.* failed"),
    "vague": (lambda d: _wrong(d, certain=1), "ball × honest × hit: .*got passed.* failed"),
    "a scene": (lambda d: _wrong(d, state="failed", wrong=7), "ball: .*got passed.* failed"),
    "a crash": (lambda d: _wrong(d, state="crashed"), "ball: .*got passed.* incomplete"),
    "convicted": (lambda d: d["scenes"][0].update(judgement=CONVICTED), "ball: .*failed"),
    "the outcome": (lambda d: d["verdict"].update(outcome="failed"), "verdict.outcome"),
    "no scenes": (lambda d: d.update(scenes=[]), "verdict.outcome: .* expected empty"),
    "the status": (lambda d: d["verdict"].update(exit_status=1), "verdict.exit_status: .*got 1"),
}


@pytest.mark.parametrize("what", CONTRADICTIONS)
def test_results_that_contradict_themselves_are_no_run(what: str, tmp_path: Path) -> None:
    change, said = CONTRADICTIONS[what]
    edited = document()
    change(edited)
    path = tmp_path / "results.json"
    path.write_text(json.dumps(edited), encoding="utf-8")
    with pytest.raises(InputError, match=said) as caught:
        read_entry(path)
    assert str(path) in caught.value.where
