"""The process between us and another author's program: it inherits all that the program leaves.

It runs in an interpreter of its own (see `reference.jobs.program`), sets the limits, starts the
program, tells how it ended and lives on to take in what the program started and left behind, so
that none of it is lost from sight. A program that kills its parent kills this one, and not us.
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
    """Arguments: the starter's id, a descriptor for the status, NAME=NUMBER,…, the command."""
    parent, descriptor, limits, *command = sys.argv[1:]
    os.set_inheritable(int(descriptor), False)  # what ended how is not the program's to tell
    signal.signal(signal.SIGTERM, _end)
    prctl(SET_CHILD_SUBREAPER, 1)
    prctl(SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):  # it ended before it could be watched
        return
    child = os.fork()
    if child == 0:
        _become(command, dict(word.split("=") for word in limits.split(",")))
    with suppress(ChildProcessError):  # nothing is left
        while True:
            pid, status = os.waitpid(-1, 0)
            if pid == child:
                os.write(int(descriptor), str(status).encode())


def _end(number: int, frame: FrameType | None) -> None:
    """Whoever started us is gone: so is the program."""
    end_descendants(os.getpid())
    os._exit(1)


def _become(command: list[str], limits: dict[str, str]) -> None:
    """Be the program, with its limits; never returns."""
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
    """The soft limit, which has a signal or an error of its own, and a hard one."""
    _, hard = resource.getrlimit(what)
    wanted = most + 1 if what == resource.RLIMIT_CPU else most
    if hard != resource.RLIM_INFINITY:
        wanted = min(wanted, hard)
    resource.setrlimit(what, (min(most, wanted), wanted))
