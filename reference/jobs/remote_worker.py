"""Jobs on a worker of somebody else's executor: each in a process that may start its own.

A worker may be a daemon, which multiprocessing lets start nothing; it may hold threads and
libraries of its scheduler. So every thread of a worker keeps one new interpreter beside itself,
a foreman, to which the jobs go; renderers run in children of that one.
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
from reference.identity import identity
from reference.jobs.isolate import Outcome, death
from reference.jobs.parcel import packed, unpacked
from reference.jobs.processes import SET_PDEATHSIG, prctl

#: What a foreman runs: it finds modules where its worker does.
_SERVE = """
import json, sys
sys.path[:] = json.loads(sys.argv[2])
from reference.jobs.remote_worker import serve
serve(int(sys.argv[1]))
"""
#: Dask has its workers give freed memory back to the system at once. Of what renders, that would
#: more than double the time: see `minirt.memory.keep_freed_memory`.
_NOT_HANDED_ON = "MALLOC_TRIM_THRESHOLD_"
#: Seconds for a foreman whose line is closed to end.
_PATIENCE = 10.0
_ours = threading.local()

#: Notes on a worker that a job begins there, and names the worker. Picklable.
Begin = Callable[[], str]


class Refused(InputError):
    """A worker cannot do our jobs, so that none of its answers would be what they should be."""


class TooManyDeaths(Exception):
    """Workers died, one after another, when a job ran there; the message names them."""


def this_machine() -> str:
    """The name of the machine that a job begins on. A `Begin` that notes nothing."""
    return platform.node()


def perform(program: str, job: bytes, begin: Begin) -> bytes:
    """Do a job for somebody who runs `program`, on a worker; the packed `Outcome`.

    Parameters
    ----------
    program : str
        Their `identity`.
    job : bytes
        A packed (function, arguments).
    begin : callable
    """
    try:
        worker = begin()
    except TooManyDeaths as error:
        return packed(Outcome("crashed", None, str(error)))
    foreman: _Foreman | None = getattr(_ours, "foreman", None)
    if foreman is None:
        foreman = _ours.foreman = _Foreman()
    answer = foreman.ask((program, worker, job))
    if answer is not None:
        return answer
    del _ours.foreman
    return packed(Outcome("crashed", None, foreman.death()))


class _Foreman:
    """One interpreter, and the line to it. It ends when nobody holds it, or its starter ends."""

    def __init__(self) -> None:
        here, there = socket.socketpair()
        where = [place for place in sys.path if place]
        command = [sys.executable, "-P", "-c", _SERVE, str(there.fileno()), json.dumps(where)]
        env = {name: value for name, value in os.environ.items() if name != _NOT_HANDED_ON}
        with there:
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, pass_fds=[there.fileno()],
                start_new_session=True, env=env,
            )  # fmt: skip
        self._line: Connection[Any, Any] = Connection(here.detach())
        self._end = weakref.finalize(self, _ended, self._line, self._process)
        self._end.atexit = False  # it is killed then, and nobody waits for the job that it does

    def ask(self, order: tuple[str, str, bytes]) -> bytes | None:
        """What it answers; None where it has died instead."""
        try:
            self._line.send(order)
            return self._line.recv_bytes()
        except (OSError, EOFError):
            return None

    def death(self) -> str:
        """How it has died."""
        self._end()
        return death(self._process.returncode)


def _ended(line: Connection[Any, Any], process: subprocess.Popen[bytes]) -> None:
    """Close a foreman's line, and wait for it to end."""
    line.close()
    try:
        process.wait(_PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def serve(descriptor: int) -> None:
    """Do the jobs that come in on a line until it is closed. What a foreman does."""
    prctl(SET_PDEATHSIG, signal.SIGKILL)  # in the midst of a job too: somebody else does it again
    with Connection(descriptor) as line:
        while True:
            try:
                order = line.recv()
            except EOFError:
                return
            line.send_bytes(_answer(*order))


def _answer(program: str, worker: str, job: bytes) -> bytes:
    with TemporaryDirectory(prefix="minirt-") as room:
        try:
            return packed(_done(program, worker, job, Path(room)))
        except Exception as error:  # what cannot be packed, either
            return packed(Outcome("raised", None, f"{type(error).__name__}: {error}"))


def _done(program: str, worker: str, job: bytes, room: Path) -> Outcome:
    if identity() != program:
        fault = Refused(
            "a worker runs another minirt, whose answers may differ", where=f"worker {worker}",
            got=identity(), expected=f"{program}, as here; restart workers after an upgrade",
        )  # fmt: skip
        return Outcome("raised", fault, str(fault))
    try:
        function, arguments = unpacked(job, room)
        return Outcome("done", function(*arguments))
    except Exception as error:  # whatever the job raised is its answer
        return Outcome("raised", error, f"{type(error).__name__}: {error}")
