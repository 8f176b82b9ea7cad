from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from reference.jobs.isolate import Outcome, Workers
from reference.jobs.processes import marked_processes
from tests.helpers.places import ROOT


def fine(value: int) -> int:
    os.write(2, b"chatter of a library\n")
    return 2 * value


def raise_error() -> None:
    raise ValueError("no such variant")


def abort() -> None:
    sys.stderr.write("from Python\n")
    os.write(2, b"x" * 10_000 + b"\nLLVM ERROR: Cannot select: fmaximum\n")
    os.abort()


def kill_itself() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def leave() -> None:
    os._exit(7)


def leave_well() -> None:
    os._exit(0)


def child_leaves_well() -> int:
    child = os.fork()
    if child == 0:
        os._exit(0)
    return os.waitpid(child, 0)[1]


def hang() -> None:
    os.write(1, b"compiling \xff\n")
    time.sleep(600)


def run(job: object, *args: object, timeout: float | None = None) -> Outcome:
    with Workers(1) as workers:
        return workers.submit(timeout, job, *args).outcome()  # type: ignore[arg-type]


def test_an_answer_comes_back_and_its_chatter_does_not(capfd: pytest.CaptureFixture[str]) -> None:
    outcome = run(fine, 21)
    assert (outcome.state, outcome.value, outcome.reason) == ("done", 42, "")
    assert capfd.readouterr() == ("", "")


def test_an_exception_is_an_answer_with_its_traceback() -> None:
    outcome = run(raise_error)
    assert outcome.state == "raised"
    assert isinstance(outcome.value, ValueError)
    assert outcome.reason == "ValueError: no such variant"
    assert "in raise_error" in outcome.output


def exit_well() -> None:
    sys.exit(0)


def interrupt() -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("job", "reason"),
    [
        (exit_well, "RuntimeError: SystemExit raised: 0"),
        (interrupt, "RuntimeError: KeyboardInterrupt raised: "),
    ],
)
def test_what_would_end_the_program_ends_the_job_alone(job: object, reason: str) -> None:
    outcome = run(job)
    assert (outcome.state, outcome.reason) == ("raised", reason)


def lose_its_streams(value: int) -> int:
    sys.stdout = sys.stderr = None
    return value


def test_a_job_may_lose_its_streams() -> None:
    assert run(lose_its_streams, 1) == Outcome("done", 1)


@pytest.mark.parametrize(
    ("job", "reason"),
    [
        (abort, "the process was ended by SIGABRT"),
        (kill_itself, "the process was ended by SIGKILL"),
        (leave, "the process ended with status 7"),
        (leave_well, "the process ended with status 0"),
    ],
)
def test_a_death_is_named(job: object, reason: str) -> None:
    outcome = run(job)
    assert (outcome.state, outcome.value, outcome.reason) == ("crashed", None, reason)


def test_a_job_may_have_children_that_end_well() -> None:
    assert run(child_leaves_well) == Outcome("done", 0)


ORPHANED = """
import sys
from reference.jobs.isolate import Workers
from tests.reference.jobs.test_isolate import hang
if __name__ == "__main__":
    with Workers(1) as workers:
        workers.submit(60.0, hang).outcome()
"""


def test_a_job_ends_with_whoever_waits_for_it(tmp_path: Path) -> None:
    script = tmp_path / "orphaned.py"
    script.write_text(ORPHANED, encoding="utf-8")
    mark = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(tmp_path)}
    waiting = subprocess.Popen([sys.executable, str(script)], env=mark, start_new_session=True)
    end = time.monotonic() + 60
    while not [log for log in tmp_path.rglob("*.log") if b"compiling" in log.read_bytes()]:
        assert time.monotonic() < end
        time.sleep(0.05)
    assert len(marked_processes(f"TMPDIR={tmp_path}")) >= 2
    waiting.kill()
    waiting.wait()
    while marked_processes(f"TMPDIR={tmp_path}"):
        assert time.monotonic() < end, "a worker lives on"
        time.sleep(0.05)


def test_a_long_name_of_the_temporary_folder_is_no_obstacle(tmp_path: Path) -> None:
    long = tmp_path / ("x" * 120)
    long.mkdir()
    code = (
        "from reference.jobs.isolate import Workers\n"
        "from tests.reference.jobs.test_isolate import fine, run\n"
        "if __name__ == '__main__': print(run(fine, 21).value)"
    )
    script = tmp_path / "long.py"
    script.write_text(code, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(long)}
    done = subprocess.run(
        [sys.executable, str(script)], env=environment, capture_output=True, text=True, timeout=120
    )
    assert done.stdout == "42\n", done.stderr


def test_last_output_of_the_dead_is_kept_and_cut() -> None:
    outcome = run(abort)
    assert outcome.output.endswith("LLVM ERROR: Cannot select: fmaximum\n")
    assert len(outcome.output) == 4000


def test_who_hangs_is_ended_in_time() -> None:
    start = time.monotonic()
    outcome = run(hang, timeout=4.0)
    assert outcome.state == "timed out"
    assert outcome.reason == "no answer within 4 s"
    assert outcome.output == "compiling �\n"
    assert time.monotonic() - start < 60


def test_one_death_costs_one_answer() -> None:
    jobs = [(fine, 1), (abort,), (fine, 2), (hang,), (raise_error,), (fine, 3), (leave,), (fine, 4)]
    with Workers(2) as workers:
        submitted = [workers.submit(3.0, job, *args) for job, *args in jobs]  # type: ignore[arg-type]
        states = [job.outcome() for job in submitted]
    assert [outcome.value for outcome in states if outcome.state == "done"] == [2, 4, 6, 8]
    assert [outcome.state for outcome in states if outcome.state != "done"] == [
        "crashed", "timed out", "raised", "crashed"
    ]  # fmt: skip
