"""Run another author's program once, with limits and, if asked, in a sandbox.

When it has ended, nothing that it started is left.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from minirt.errors import ReferenceError
from reference.jobs.monitor import Limits, Monitor, ProgramEnd
from reference.jobs.processes import all_processes
from reference.jobs.sandbox import sandbox_missing, sandboxed
from reference.jobs.scratch_folders import plain_files

__all__ = ["Limits", "ProgramEnd", "plain_files", "run_program", "sandbox_missing"]

#: By how much the kernel's limit of processes is above ours: ours is exceeded first, and reported.
_MARGIN = 32
_ROOT = Path(__file__).resolve().parents[2]
#: Isolated (-I): neither the program's folder nor the caller's variables decide what is imported.
_SUPERVISOR = (
    "import sys; sys.path.insert(0, sys.argv.pop(1)); "
    "from reference.jobs.supervisor import main; main()"
)


def run_program(
    command: Sequence[str],
    workdir: Path,
    limits: Limits | None = None,
    sandbox: bool = False,
    visible: Iterable[Path] = (),
) -> ProgramEnd:
    """Run a program until it ends or exceeds a limit; then end all that it started.

    Parameters
    ----------
    command : sequence of str
        A program, by its name on the search path or by its path (from `workdir`), and arguments.
    workdir : path
        An existing folder of its own: its working directory, HOME and TMPDIR. In a sandbox it can
        write nowhere else. Call `plain_files` before reading what it leaves there.
    limits : Limits, optional
    sandbox : bool
        Without a sandbox the limits hold too, but the program has all rights of its user: it can
        write elsewhere, use the network and end other processes of the user.
    visible : paths, optional
        What it can read in a sandbox, besides the system, this Python and the files that the
        command names: for instance the folder of a program that loads files of its own.

    Raises
    ------
    ReferenceError
        There is no sandbox on this machine, and one is asked for.
    """
    workdir = workdir.resolve()
    limits = limits or Limits()
    reason = sandbox_missing() if sandbox else None
    if reason:
        raise ReferenceError("no sandbox for the program", got=reason)
    program = _find(command[0], workdir)
    if program is None:
        return ProgramEnd(None, f"there is no program {command[0]!r}", "")
    words = [program, *command[1:]]
    if not sandbox:
        environment = {**os.environ, "HOME": str(workdir), "TMPDIR": str(workdir)}
        with _started(words, environment, workdir, limits) as run:
            return run.wait()
    most = limits.processes + _MARGIN
    with (
        sandboxed(words, workdir, most, visible) as (wrapped, environment, scratch),
        _started(wrapped, environment, workdir, limits, scratch) as run,
    ):
        return run.wait()


def _find(name: str, workdir: Path) -> str | None:
    if "/" not in name:
        return shutil.which(name)
    path = os.path.normpath(workdir / name)
    return path if os.path.isfile(path) else None  # noqa: PTH113 - Path's raises what it may not see


@contextmanager
def _started(
    words: Sequence[str],
    environment: dict[str, str],
    workdir: Path,
    limits: Limits,
    scratch: Path | None = None,
) -> Iterator[Monitor]:
    """Start a supervisor with the program as its child; on leaving, end them all."""
    read, write = os.pipe()
    python = [sys.executable, "-I", "-S", "-c", _SUPERVISOR, str(_ROOT)]
    numbers = [str(os.getpid()), str(write), _kernel_limits(limits, scratch)]
    with subprocess.Popen(
        [*python, *numbers, *words],
        cwd=workdir,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        pass_fds=[write],
        start_new_session=True,
    ) as supervisor:
        os.close(write)
        run = Monitor(supervisor, read, workdir, limits, scratch)
        try:
            yield run
        finally:
            run.end()
            os.close(read)


def _kernel_limits(limits: Limits, scratch: Path | None) -> str:
    """The limits that the kernel enforces, a little above those that `Monitor` enforces."""
    numbers = {
        "cpu": int(limits.cpu_seconds) + 1,
        "address": 2 * limits.memory + 2**30,
        "file": limits.file_bytes + 1,
    }
    if scratch is None:  # the kernel counts all processes of the user; a sandbox sets it inside
        others = sum(process.threads for process in all_processes())
        numbers["processes"] = others + limits.processes + _MARGIN
    return ",".join(f"{name}={number}" for name, number in numbers.items())
