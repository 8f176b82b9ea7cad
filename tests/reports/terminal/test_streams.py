"""The command in a process whose streams are closed, full, or that is asked to end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import minirt

START = [sys.executable, "-c", "from reports.cli.main import main; main()"]
ROOT = Path(minirt.__file__).parents[1]


def shell(redirection: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["/bin/sh", "-c", f'exec "$@" {redirection}', "sh", *START, *arguments],
        capture_output=True, text=True, timeout=120, cwd=ROOT, check=False,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("redirection", "arguments", "status"),
    [
        (">&-", ["scenes"], 0),
        (">&-", ["scenes", "--json"], 0),
        ("2>&-", ["scenes", "nope"], 2),
        ("<&- >&- 2>&-", ["scenes"], 0),
        ("<&-", ["explain", "-", "--pixel", "0", "0"], 2),
        (">/dev/full", ["scenes"], 2),
        (">/dev/full", ["scenes", "--json"], 2),
        ("2>/dev/full", ["scenes", "nope"], 2),
        ("2>/dev/full", ["scenes", "one-sphere"], 0),
    ],
)
def test_a_stream_that_is_closed_or_full_is_no_mistake_of_minirts(
    redirection: str, arguments: list[str], status: int
) -> None:
    done = shell(redirection, *arguments)
    assert done.returncode == status, done.stderr
    assert "Traceback" not in done.stderr
    assert "mistake in minirt" not in done.stderr
    if "/dev/full" in redirection and status == 2 and redirection.startswith(">/"):
        assert "No space left" in done.stderr


def test_a_run_that_is_terminated_leaves_nothing_behind(tmp_path: Path) -> None:
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    run = subprocess.Popen(
        [*START, "verify", "--reference", "mitsuba-scalar", "--out", str(tmp_path / "report")],
        cwd=ROOT, env=os.environ | {"TMPDIR": str(temporary)},
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    deadline = time.monotonic() + 60
    while not (begun := list(temporary.glob("minirt-*/*.log"))) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert begun
    run.send_signal(signal.SIGTERM)
    assert run.wait(60) == 128 + signal.SIGTERM
    assert list(temporary.iterdir()) == []
    assert [path.name for path in (tmp_path / "report").iterdir()] == ["history.sqlite"]
