"""What runs on a worker of an executor: each job in a process that may start its own processes.

A worker may be a daemon, which multiprocessing does not allow to start processes; it may have
threads and libraries of its scheduler. So every thread of a worker keeps one new interpreter for
its jobs (`_JobProcess`), and renderers run in child processes of that one.
"""

from __future__ import annotations

import json
import os
import platform
import signal
import socket
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from minirt.errors import InputError
from minirt.memory import keep_freed_memory
from reference.jobs.identity import identity
from reference.jobs.isolate import Outcome, death
from reference.jobs.payload import from_payload, to_payload
from reference.jobs.processes import SET_PDEATHSIG, prctl

#: What a job process runs; it searches for modules in the same places as its worker.
_SERVE = """
import json, sys
sys.path[:] = json.loads(sys.argv[2])
from reference.jobs.remote_worker import serve
serve(int(sys.argv[1]))
"""
#: Dask makes its workers return freed memory to the system at once. That would more than double
#: the time of a rendering: see `minirt.memory.keep_freed_memory`.
_NOT_INHERITED = "MALLOC_TRIM_THRESHOLD_"
#: Seconds in which a job process must end after its connection is closed.
_PATIENCE = 10.0
_thread = threading.local()

#: Called on a worker when it starts a job; returns the worker's name. Picklable.
OnStart = Callable[[], str]


class IncompatibleWorker(InputError):
    """A worker cannot run our jobs, or would answer them with another version of minirt."""


class TooManyDeaths(Exception):
    """Several workers died, one after another, of the same job; the message names them."""


def this_machine() -> str:
    """The name of this machine. An `OnStart` that records nothing."""
    return platform.node()


def perform(program: str, job: bytes, on_start: OnStart) -> bytes:
    """Run a job on a worker; return the payload of its `Outcome`.

    Parameters
    ----------
    program : str
        The `identity` of the minirt that sends the job.
    job : bytes
        The payload of (function, arguments).
    on_start : callable
    """
    try:
        worker = on_start()
    except TooManyDeaths as error:
        return to_payload(Outcome("crashed", None, str(error)))
    process: _JobProcess | None = getattr(_thread, "process", None)
    if process is None:
        process = _thread.process = _JobProcess()
    answer = process.run((program, worker, job))
    if answer is not None:
        return answer
    del _thread.process
    return to_payload(Outcome("crashed", None, process.death()))


class _JobProcess:
    """One interpreter that runs jobs, and the connection to it.

    It ends when this object is no longer used, or with the process that started it.
    """

    def __init__(self) -> None:
        here, there = socket.socketpair()
        where = [place for place in sys.path if place]
        command = [sys.executable, "-P", "-c", _SERVE, str(there.fileno()), json.dumps(where)]
        env = {name: value for name, value in os.environ.items() if name != _NOT_INHERITED}
        with there:
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, pass_fds=[there.fileno()],
                start_new_session=True, env=env,
            )  # fmt: skip
        self._connection: Connection[Any, Any] = Connection(here.detach())
        self._end = weakref.finalize(self, _close, self._connection, self._process)
        self._end.atexit = False  # at exit it is killed, and its job is not waited for

    def run(self, task: tuple[str, str, bytes]) -> bytes | None:
        """Have a job run; the payload of its outcome, or None if the process died."""
        try:
            self._connection.send(task)
            return self._connection.recv_bytes()
        except (OSError, EOFError):
            return None

    def death(self) -> str:
        """How the process died."""
        self._end()
        return death(self._process.returncode)


def _close(connection: Connection[Any, Any], process: subprocess.Popen[bytes]) -> None:
    """Close the connection to a job process, and wait for it to end."""
    connection.close()
    try:
        process.wait(_PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def serve(descriptor: int) -> None:
    """Run the jobs that arrive on a connection until it is closed: what a job process does."""
    prctl(SET_PDEATHSIG, signal.SIGKILL)  # in the middle of a job too: another worker runs it again
    keep_freed_memory()
    with Connection(descriptor) as connection:
        while True:
            try:
                task = connection.recv()
            except EOFError:
                return
            connection.send_bytes(_outcome(*task))


def _outcome(program: str, worker: str, job: bytes) -> bytes:
    with TemporaryDirectory(prefix="minirt-") as folder:
        try:
            return to_payload(_run(program, worker, job, Path(folder)))
        except Exception as error:  # also of one that cannot be pickled
            return to_payload(Outcome("raised", None, f"{type(error).__name__}: {error}"))


def _run(program: str, worker: str, job: bytes, folder: Path) -> Outcome:
    if identity() != program:
        fault = IncompatibleWorker(
            "a worker runs another minirt, whose answers may differ", where=f"worker {worker}",
            got=identity(), expected=f"{program}, as here; restart workers after an upgrade",
        )  # fmt: skip
        return Outcome("raised", fault, str(fault))
    try:
        function, arguments = from_payload(job, folder)
        return Outcome("done", function(*arguments))
    except Exception as error:  # what the job raised is its outcome
        return Outcome("raised", error, f"{type(error).__name__}: {error}")
