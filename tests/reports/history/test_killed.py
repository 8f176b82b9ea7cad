"""`kill -9` at random moments: the history and the reports stay readable, earlier runs whole."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import pytest

from minirt.errors import InputError
from reports.history.entry import read_entry
from reports.history.store import History
from reports.run import REPORTS
from tests.helpers import history_writers
from tests.helpers.fake_references import small_scene
from tests.helpers.history_runs import entry, sorted_cells, whole
from tests.helpers.places import ROOT
from tests.helpers.postgres_server import running

CELLS = sum(1 for _ in entry().cells())


@contextlib.contextmanager
def writers(folder: Path, seed: int) -> Iterator[subprocess.Popen[str]]:
    """A process that starts writers and kills them."""
    with subprocess.Popen(
        [sys.executable, "-m", history_writers.__name__, str(folder), str(seed)], cwd=ROOT,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        yield process
        assert process.stdin
        process.stdin.close()
        assert process.wait(20) == 0


def killed(process: subprocess.Popen[str], target: str, when: str = "write") -> list[int]:
    """Have one writer killed; the numbers of the runs that it had added for certain."""
    assert process.stdin
    assert process.stdout
    process.stdin.write(f"{when} {target}\n")
    process.stdin.flush()
    word, *numbers = process.stdout.readline().split()
    assert word == "killed"
    return [int(number) for number in numbers]


def kept(target: str, since: int = 1) -> int:
    """The number of the newest run, after a look at each one from `since` on."""
    with History(target) as history:
        newest = history.latest() or 0
        for number in range(since, newest + 1):
            whole(history, number, CELLS)
    return newest


def readable(folder: Path) -> set[str]:
    """The reports that are there, each of which can be read to its end."""
    found = {path.name for path in folder.iterdir()} & set(REPORTS)
    if "results.json" in found:
        assert len(read_entry(folder).scenes) == 2
    if "junit.xml" in found:
        ET.parse(folder / "junit.xml")  # noqa: S314 - our own file
    if "report.html" in found:
        assert (folder / "report.html").read_text(encoding="utf-8").rstrip().endswith("</html>")
    if "summary.md" in found:
        assert "results.json" in (folder / "summary.md").read_text(encoding="utf-8")
    return found


@pytest.mark.parametrize(
    ("beginnings", "rounds"), [(2, 4), pytest.param(12, 38, marks=pytest.mark.full)]
)
def test_kills_of_a_sqlite_history_cost_no_earlier_run(
    beginnings: int, rounds: int, tmp_path: Path
) -> None:
    """Killed in its first moments, or while it writes: six times, or fifty."""
    seed = time.time_ns()  # shown where the test fails
    folder, newest = tmp_path / "report", 0
    folder.mkdir()
    with writers(folder, seed) as process:
        for k in range(beginnings):
            target = str(tmp_path / f"{k}.sqlite")
            added = killed(process, target, "begin")
            assert kept(target) >= max(added, default=0), seed
        target = str(tmp_path / "history.sqlite")
        for _ in range(rounds):
            added = killed(process, target)
            now = kept(target, newest + 1)
            assert now >= max([newest, *added]), seed
            assert set(added) <= set(range(newest + 1, now + 1)), seed
            newest = now
            readable(folder)
    assert readable(folder) == set(REPORTS)
    assert newest >= rounds
    connection = sqlite3.connect(tmp_path / "history.sqlite")
    assert connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
    connection.close()
    assert kept(str(tmp_path / "history.sqlite")) == newest


@pytest.mark.full
def test_kills_of_a_team_s_history_cost_no_earlier_run(tmp_path: Path) -> None:
    newest = 0
    with running() as server, writers(tmp_path, 5) as process:
        target = server.fresh()
        for _ in range(12):
            added = killed(process, target)
            now = kept_with_gaps(target, added)
            assert now >= newest
            newest = now
    assert newest >= 12


def kept_with_gaps(target: str, added: list[int]) -> int:
    """As `kept`; PostgreSQL leaves out the number of a run that was not finished."""
    with History(target) as history:
        for number in added:
            whole(history, number, CELLS)
        newest = history.latest() or 0
        if newest:
            whole(history, newest, CELLS)
    return newest


def test_a_torn_run_would_be_noticed(tmp_path: Path) -> None:
    target = tmp_path / "history.sqlite"
    with History(str(target)) as history:
        history.append(entry(1))
    assert kept(str(target)) == 1
    connection = sqlite3.connect(target)
    connection.execute("DELETE FROM minirt_cells WHERE quantity = 'normal'")
    connection.commit()
    connection.close()
    with pytest.raises(AssertionError):
        kept(str(target))


def test_a_torn_report_would_be_noticed(tmp_path: Path) -> None:
    (tmp_path / "results.json").write_text('{"minirtResults": 1,', encoding="utf-8")
    with pytest.raises(InputError):
        readable(tmp_path)


@pytest.mark.full
def test_kills_of_a_real_run_leave_what_was_there(tmp_path: Path) -> None:
    scene = tmp_path / "ball.json"
    scene.write_text(small_scene().canonical_json, encoding="utf-8")
    out = tmp_path / "report"
    command = [
        sys.executable, "-c", "from reports.cli.main import main; main()",
        "verify", str(scene), "--reference", "embree", "--out", str(out), "--jobs", "1",
    ]  # fmt: skip
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True)
    seconds = time.perf_counter() - start
    assert done.returncode == 0, done.stderr
    first = read_entry(out)
    for share in (0.5, 0.8, 0.97):
        process = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
        )
        time.sleep(share * seconds)
        process.kill()
        process.wait()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # its workers
        with History(str(out / "history.sqlite"), create=False) as history:
            assert sorted_cells(history.entry(1)) == sorted_cells(first)
            assert 1 <= history.number("latest") <= 4
        assert len(read_entry(out).scenes) == 1
        assert json.loads((out / "results.json").read_text(encoding="utf-8"))
        assert (out / "report.html").read_text(encoding="utf-8").rstrip().endswith("</html>")
