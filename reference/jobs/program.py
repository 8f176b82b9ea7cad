"""Run another author's program once, with limits, in a sandbox where asked; nothing survives it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from minirt.errors import ReferenceError
from reference.jobs.processes import all_processes
from reference.jobs.sandbox import sandbox_missing, sandboxed
from reference.jobs.scratch_folders import plain_files
from reference.jobs.watch import Ended, Limits, Watch

__all__ = ["Ended", "Limits", "plain_files", "run_program", "sandbox_missing"]

#: The kernel's own limit of processes lies above ours, so that a program is seen to exceed it.
_SPARE = 32
_ROOT = Path(__file__).resolve().parents[2]
#: Isolated (-I): the program's folder and the caller's variables do not choose what we import.
_GUARDIAN = (
    "import sys; sys.path.insert(0, sys.argv.pop(1)); "
    "from reference.jobs.guardian import main; main()"
)


def run_program(
    command: Sequence[str],
    room: Path,
    limits: Limits | None = None,
    sandbox: bool = False,
    visible: Iterable[Path] = (),
) -> Ended:
    """Run a program in its room until it ends or exceeds a limit; then all it started is dead.

    Parameters
    ----------
    command : sequence of str
        A program, by its name on the search path or by its path (from `room`), and arguments.
    room : path
        An existing folder of its own: its working directory, HOME and TMPDIR. In a sandbox the
        only place that it can write to. Read what it leaves there after `plain_files` only.
    limits : Limits, optional
    sandbox : bool
        Without one the limits hold too, but the program is trusted with all that its user can
        do: it can write elsewhere, use the network and end other processes of the user.
    visible : paths, optional
        What it can read in a sandbox beside the system, this Python and the files that the
        command names: the folder of a program that loads files of its own.

    Raises
    ------
    ReferenceError
        A sandbox is asked for where there is none.
    """
    room = room.resolve()
    limits = limits or Limits()
    reason = sandbox_missing() if sandbox else None
    if reason:
        raise ReferenceError("no sandbox for the program", got=reason)
    program = _find(command[0], room)
    if program is None:
        return Ended(None, f"there is no program {command[0]!r}", "")
    words = [program, *command[1:]]
    if not sandbox:
        environment = {**os.environ, "HOME": str(room), "TMPDIR": str(room)}
        with _started(words, environment, room, limits) as run:
            return run.wait()
    spare = limits.processes + _SPARE
    with (
        sandboxed(words, room, spare, visible) as (wrapped, environment, scratch),
        _started(wrapped, environment, room, limits, scratch) as run,
    ):
        return run.wait()


def _find(name: str, room: Path) -> str | None:
    if "/" not in name:
        return shutil.which(name)
    path = os.path.normpath(room / name)
    return path if os.path.isfile(path) else None  # noqa: PTH113 - Path's raises what it may not see


@contextmanager
def _started(
    words: Sequence[str],
    environment: dict[str, str],
    room: Path,
    limits: Limits,
    scratch: Path | None = None,
) -> Iterator[Watch]:
    """A guardian with the program as its child; on leaving, all of them are dead."""
    read, write = os.pipe()
    python = [sys.executable, "-I", "-S", "-c", _GUARDIAN, str(_ROOT)]
    numbers = [str(os.getpid()), str(write), _kernel_limits(limits, scratch)]
    with subprocess.Popen(
        [*python, *numbers, *words],
        cwd=room,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        pass_fds=[write],
        start_new_session=True,
    ) as guardian:
        os.close(write)
        run = Watch(guardian, read, room, limits, scratch)
        try:
            yield run
        finally:
            run.end()
            os.close(read)


def _kernel_limits(limits: Limits, scratch: Path | None) -> str:
    """What the kernel itself enforces, a little above what `Watch` watches."""
    numbers = {
        "cpu": int(limits.cpu_seconds) + 1,
        "address": 2 * limits.memory + 2**30,
        "file": limits.file_bytes + 1,
    }
    if scratch is None:  # in a sandbox it is set inside; here all that its user runs counts
        others = sum(process.threads for process in all_processes())
        numbers["processes"] = others + limits.processes + _SPARE
    return ",".join(f"{name}={number}" for name, number in numbers.items())
