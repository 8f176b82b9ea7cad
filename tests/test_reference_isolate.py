from __future__ import annotations

import os
import signal
import sys
import time

import pytest

from reference.isolate import Outcome, Workers


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
    ],
)
def test_a_death_is_named(job: object, reason: str) -> None:
    outcome = run(job)
    assert (outcome.state, outcome.value, outcome.reason) == ("crashed", None, reason)


def test_last_output_of_the_dead_is_kept_and_cut() -> None:
    outcome = run(abort)
    assert outcome.output.endswith("LLVM ERROR: Cannot select: fmaximum\n")
    assert len(outcome.output) == 4000


def test_who_hangs_is_ended_in_time() -> None:
    start = time.monotonic()
    outcome = run(hang, timeout=1.0)
    assert outcome.state == "timed out"
    assert outcome.reason == "no answer within 1 s"
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
