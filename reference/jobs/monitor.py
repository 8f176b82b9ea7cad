"""Monitor a running program: its time, memory, processes, files and output; end it in time."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path
from typing import IO, cast

from reference.jobs.processes import (
    Process,
    all_processes,
    deleted_bytes,
    descendants,
    end_descendants,
    end_known,
    marked_processes,
    proportional_memory,
)
from reference.jobs.scratch_folders import excess, size_text

#: Bytes of a program's last output that are kept for the report.
_TAIL = 4000
#: Seconds between two samples of what a program uses.
_INTERVAL = 0.03


@dataclass(frozen=True)
class Limits:
    """What a program may use. The defaults suit a picture of a million pixels.

    Attributes
    ----------
    wall_seconds : float
    cpu_seconds : float
        Of all its processes and threads together.
    memory : int
        Bytes that all its processes hold together. One process may reserve twice as much and
        1 GiB more: many reserve what they never touch.
    processes : int
        Processes and threads at a time.
    file_bytes : int
        The largest file.
    output_bytes : int
        All its files together, and, counted apart, all that it prints.
    """

    wall_seconds: float = 60.0
    cpu_seconds: float = 120.0
    memory: int = 2 * 2**30
    processes: int = 256
    file_bytes: int = 512 * 2**20
    output_bytes: int = 2**30


@dataclass(frozen=True)
class ProgramEnd:
    """How a program ended.

    Attributes
    ----------
    status : int or None
        Its exit status; the negative number of the signal that ended it; None where we ended it
        or where it could not be started.
    reason : str
        Empty when it ended with status 0; else what happened, in a sentence without a full stop.
    output : str
        The last 4,000 bytes of its standard output and error.
    """

    status: int | None
    reason: str
    output: str


class Monitor:
    """A program under a supervisor (see `reference.jobs.supervisor`), and what it has used so far.

    Parameters
    ----------
    supervisor : Popen
        Its standard output is the program's.
    status : int
        The descriptor on which the supervisor reports how the program ended.
    workdir, scratch : path
        Where the program can write; `scratch` is None without a sandbox.
    limits : Limits
    """

    def __init__(
        self,
        supervisor: subprocess.Popen[bytes],
        status: int,
        workdir: Path,
        limits: Limits,
        scratch: Path | None,
    ) -> None:
        self._supervisor, self._status, self._limits = supervisor, status, limits
        self._folders = [workdir] if scratch is None else [workdir, scratch]
        #: The supervisor, and bubblewrap outside and inside, which are not the program's.
        self._own = 1 if scratch is None else 3
        self._sandboxed, self._begin = scratch is not None, time.monotonic()
        self._stream = cast(IO[bytes], supervisor.stdout).fileno()
        self._tail, self._printed, self._seconds = b"", 0, 0.0
        self._known: set[tuple[int, int]] = set()

    def wait(self) -> ProgramEnd:
        """Wait for the program to end, or end it because it exceeded a limit; how it ended."""
        sampled, reason = self._begin, ""
        answer: bytes | None = None
        while not reason and answer is None:
            ready, _, _ = select.select([self._stream, self._status], [], [], _INTERVAL)
            if self._stream in ready:
                self._read()
            if self._status in ready:
                answer = os.read(self._status, 20)
            elif time.monotonic() - sampled >= _INTERVAL:
                reason = self._exceeded()
                sampled = time.monotonic()
        if answer == b"":
            self._known.update(marked_processes(f"TMPDIR={self._folders[0]}"))
        self.end()
        self._read_the_rest()
        status, said = self._ending(answer)
        reason = reason or self._too_large() or said
        return ProgramEnd(status, reason, self._tail.decode(errors="replace"))

    def end(self) -> None:
        """Kill all that the program started, running or not. May be called again."""
        if self._supervisor.returncode is None:
            end_descendants(self._supervisor.pid)
            self._supervisor.kill()
            self._supervisor.wait()
        # If the program killed its supervisor, what it left behind has another parent now.
        end_known(self._known)

    def _read(self) -> bool:
        """Read a part of what was printed; whether there was any."""
        part = os.read(self._stream, 2**16)
        self._printed += len(part)
        self._tail = (self._tail + part)[-_TAIL:]
        return bool(part)

    def _read_the_rest(self) -> None:
        """Read what is left in the pipe after all writers have ended."""
        while select.select([self._stream], [], [], 0)[0] and self._read():
            pass

    def _exceeded(self) -> str:
        """The limit that the program exceeds now, as a sentence; else empty."""
        limits = self._limits
        if time.monotonic() - self._begin > limits.wall_seconds:
            return f"no answer within {limits.wall_seconds:g} s"
        if self._printed > limits.output_bytes:
            return f"printed more than {size_text(limits.output_bytes)}"
        now = all_processes()
        ours = descendants(now, {self._supervisor.pid})
        self._known.update((process.pid, process.start) for process in ours)
        supervisor = [process for process in now if process.pid == self._supervisor.pid]
        return self._exceeded_by([*supervisor, *ours]) or self._too_large(deleted_bytes(ours))

    def _exceeded_by(self, processes: list[Process]) -> str:
        """The limit of CPU time, processes or memory that processes exceed together."""
        limits = self._limits
        self._seconds = max(self._seconds, sum(process.seconds for process in processes))
        if self._seconds > limits.cpu_seconds:
            return _too_long(limits)
        if sum(process.threads for process in processes) - self._own > limits.processes:
            return f"ran more than {limits.processes} processes and threads"
        at_most = sum(process.resident for process in processes)
        if at_most > limits.memory and proportional_memory(processes) > limits.memory:
            return f"used more than {size_text(limits.memory)} of memory"
        return ""

    def _too_large(self, beside: int = 0) -> str:
        """The limit that the program's files exceed; `beside` bytes lie in no folder."""
        limits = self._limits
        return excess(self._folders, limits.file_bytes, limits.output_bytes, beside)

    def _ending(self, answer: bytes | None) -> tuple[int | None, str]:
        """The program's exit status, and what it means."""
        if answer is None:
            return None, ""
        if not answer:
            return None, "ended the process that watched it"
        status = os.waitstatus_to_exitcode(int(answer))
        if self._sandboxed and status - 128 in set(signal.Signals):
            status = 128 - status  # bubblewrap reports a signal as a shell does
        if self._printed > self._limits.output_bytes:
            return status, f"printed more than {size_text(self._limits.output_bytes)}"
        if status == -signal.SIGXCPU:
            return status, _too_long(self._limits)
        if status < 0:
            return status, f"was ended by {_signal_name(-status)}"
        return status, f"ended with status {status}" if status else ""


def _too_long(limits: Limits) -> str:
    return f"used more than {limits.cpu_seconds:g} s of CPU"


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:  # a real-time signal
        return f"signal {number}"
