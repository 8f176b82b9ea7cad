"""The supervisor process, parent of another author's program.

It runs in an interpreter of its own (see `reference.jobs.program`), sets the limits, starts the
program and reports how it ended. It goes on running as the subreaper (`prctl(2)`): processes that
the program leaves behind become its children, so that they can be found and ended. A program that
kills its parent kills the supervisor and not us.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
from contextlib import suppress
from types import FrameType

from reference.jobs.processes import SET_CHILD_SUBREAPER, SET_PDEATHSIG, end_descendants, prctl

#: The kernel's limits by the names that the command line gives them.
_LIMITED = {
    "cpu": resource.RLIMIT_CPU,
    "address": resource.RLIMIT_AS,
    "file": resource.RLIMIT_FSIZE,
    "processes": resource.RLIMIT_NPROC,
}


def main() -> None:
    """Arguments: the starting process's id, a descriptor for the status, NAME=NUMBER,…, command."""
    parent, descriptor, limits, *command = sys.argv[1:]
    os.set_inheritable(int(descriptor), False)  # the program must not write its own exit status
    signal.signal(signal.SIGTERM, _end)
    prctl(SET_CHILD_SUBREAPER, 1)
    prctl(SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):  # the starting process has already ended
        return
    child = os.fork()
    if child == 0:
        _exec(command, dict(word.split("=") for word in limits.split(",")))
    with suppress(ChildProcessError):  # nothing is left
        while True:
            pid, status = os.waitpid(-1, 0)
            if pid == child:
                os.write(int(descriptor), str(status).encode())


def _end(number: int, frame: FrameType | None) -> None:
    """End the program, since the process that started us has ended."""
    end_descendants(os.getpid())
    os._exit(1)


def _exec(command: list[str], limits: dict[str, str]) -> None:
    """Turn this process into the program, with its limits; never returns."""
    try:
        os.setsid()
        prctl(SET_PDEATHSIG, signal.SIGKILL)
        for number in (signal.SIGTERM, signal.SIGPIPE, signal.SIGXFSZ):
            signal.signal(number, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for name, text in limits.items():
            _limit(_LIMITED[name], int(text))
        os.execvp(command[0], command)  # noqa: S606
    except OSError as error:
        os.write(2, f"{command[0]} cannot be started: {error.strerror}\n".encode())
    finally:
        os._exit(127)


def _limit(what: int, most: int) -> None:
    """Set a soft limit, which shows as a signal or an error, and the hard one."""
    _, hard = resource.getrlimit(what)
    wanted = most + 1 if what == resource.RLIMIT_CPU else most
    if hard != resource.RLIM_INFINITY:
        wanted = min(wanted, hard)
    resource.setrlimit(what, (min(most, wanted), wanted))
