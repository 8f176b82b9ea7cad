"""Jobs in child processes: one that aborts, hangs or fails costs its own answer only."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import TimeoutError as JobTimeout
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from itertools import count
from multiprocessing import forkserver
from multiprocessing.context import BaseContext
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir
from typing import Any, Literal, NoReturn

from pebble import ProcessExpired, ProcessFuture, ProcessPool

from minirt.errors import MinirtError
from minirt.memory import keep_freed_memory
from reference.jobs.processes import SET_PDEATHSIG, prctl

#: The exit status of a process whose job tried to end it with status 0.
_SILENT = 240
#: Bytes of a folder's name that leave room for a socket's in it: 108 less `pymp-…/listener-…`.
_LONGEST = 108 - 36
#: Packages whose modules a new process imports if the starting one has.
_OURS = frozenset(("minirt", "converters", "reference", "reports"))
#: Bytes of a job's last output that are kept for the report.
_TAIL = 4000


#: Called with the number of jobs that are done, and of all.
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Outcome:
    """How a job ended.

    Attributes
    ----------
    state : str
        done, raised, crashed or timed out.
    value : object
        What the job returned, or the exception that it raised; None otherwise.
    reason : str
        Why there is no answer, in a sentence; empty when done.
    output : str
        The last lines that it, or a library in it, wrote to standard output and error.
    """

    state: Literal["done", "raised", "crashed", "timed out"]
    value: Any
    reason: str = ""
    output: str = ""


class Workers:
    """A pool of child processes. Use as a context manager; leaving it ends every child.

    Parameters
    ----------
    processes : int
        Their number.
    """

    def __init__(self, processes: int) -> None:
        self._processes = processes
        self._numbers = count()

    def __enter__(self) -> Workers:
        self._logs = TemporaryDirectory(prefix="minirt-")
        self._pool = ProcessPool(max_workers=self._processes, context=_context())
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.stop()
        self._pool.join()
        self._logs.cleanup()

    def submit(self, timeout: float | None, job: Callable[..., Any], *args: Any) -> Job:
        """Run ``job(*args)`` in a child, for at most `timeout` seconds."""
        log = Path(self._logs.name) / f"{next(self._numbers)}.log"
        # Pickle now: the pool would do it in another thread, while this one may change things.
        arguments = [str(log), dict(os.environ), pickle.dumps((job, args))]
        future = self._pool.schedule(_run, args=arguments, timeout=timeout)
        return Job(future, log, timeout)


@dataclass(frozen=True)
class Job:
    """A job that runs, or waits to run, in a child process."""

    future: ProcessFuture[Any]
    log: Path
    timeout: float | None

    def outcome(self) -> Outcome:
        """Wait for the job and return how it ended. Never raises what happened in the child."""
        try:
            return Outcome("done", self.future.result())
        except JobTimeout:
            reason = f"no answer within {self.timeout:g} s"
            return Outcome("timed out", None, reason, self._tail())
        except ProcessExpired as error:
            return Outcome("crashed", None, death(error.exitcode), self._tail())
        except Exception as error:  # what the job raised is its outcome
            reason = f"{type(error).__name__}: {error}"
            return Outcome("raised", error, reason, self._tail())

    def _tail(self) -> str:
        try:
            return self.log.read_bytes()[-_TAIL:].decode(errors="replace")
        except OSError:
            return ""


def death(exitcode: int | None) -> str:
    """How a process ended that should have answered, in words."""
    if exitcode is not None and exitcode < 0:
        return f"the process was ended by {signal.Signals(-exitcode).name}"
    return f"the process ended with status {0 if exitcode == _SILENT else exitcode}"


def get_ready(*modules: str) -> None:
    """Start the process that jobs are forked from, which imports modules while this one goes on."""
    context = _context(modules)
    if context.get_start_method() == "forkserver":
        forkserver.ensure_running()


@cache
def _context(beside: tuple[str, ...] = ()) -> BaseContext:
    """Fork jobs from a process that has imported those of our modules that this one has.

    That process has run no job, holds no renderer's library and has no threads: its forks start as
    clean as new interpreters, in a twentieth of their time. It listens on a socket in the folder
    for temporary files; if the folder's name is too long for a socket, jobs run in new
    interpreters.
    """
    if len(os.fsencode(gettempdir())) > _LONGEST:
        return multiprocessing.get_context("spawn")
    ours = [name for name in sys.modules if name.partition(".")[0] in _OURS]
    multiprocessing.set_forkserver_preload([*beside, *ours, "reference.jobs.fork_server"])
    return multiprocessing.get_context("forkserver")


def _run(log: str, environment: dict[str, str], pickled: bytes) -> Any:
    os.environ.clear()
    os.environ.update(environment)
    prctl(SET_PDEATHSIG, signal.SIGKILL)  # nobody waits for the answer any more
    keep_freed_memory()
    with _output_into(log), _no_silent_exit():
        try:
            job, args = pickle.loads(pickled)  # noqa: S301 - this run's own
            return job(*args)
        except MinirtError:  # its message says everything
            raise
        except Exception:
            traceback.print_exc()
            raise
        except BaseException as error:  # SystemExit would end the process that receives it
            traceback.print_exc()
            raise RuntimeError(f"{type(error).__name__} raised: {error}") from None


@contextmanager
def _no_silent_exit() -> Iterator[None]:
    """Replace exit status 0 of a job by another: the pool would wait for its answer for ever."""
    real, here = os._exit, os.getpid()

    def leave(status: int) -> NoReturn:
        real(status or _SILENT if os.getpid() == here else status)

    os._exit = leave
    try:
        yield
    finally:
        os._exit = real


@contextmanager
def _output_into(log: str) -> Iterator[None]:
    """Redirect standard output and error of this process, C libraries included, into a file."""
    kept = [os.dup(1), os.dup(2)]
    target = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    try:
        os.dup2(target, 1)
        os.dup2(target, 2)
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            with suppress(Exception):  # the job may have replaced it by anything
                stream.flush()
        for number, descriptor in zip((1, 2), kept, strict=True):
            os.dup2(descriptor, number)
            os.close(descriptor)
        os.close(target)
