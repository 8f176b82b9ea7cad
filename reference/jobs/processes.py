"""A tree of processes as Linux shows it in /proc: what it uses, and how to end it."""

from __future__ import annotations

import ctypes
import os
import signal
import stat
import time
from collections.abc import Collection, Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

#: From <linux/prctl.h>.
SET_PDEATHSIG, SET_CHILD_SUBREAPER = 1, 36

_TICKS = os.sysconf("SC_CLK_TCK")
_PAGE = os.sysconf("SC_PAGE_SIZE")


@dataclass(frozen=True)
class Process:
    """One process at one moment.

    Attributes
    ----------
    pid, parent, session : int
    alive : bool
        False for a zombie.
    start : int
        Ticks between the machine's start and its own; unique together with `pid`.
    seconds : float
        CPU time of the process and of the children that it has waited for.
    threads : int
    resident : int
        Bytes of memory, shared pages included.
    """

    pid: int
    parent: int
    session: int
    alive: bool
    start: int
    seconds: float
    threads: int
    resident: int


def prctl(option: int, value: int) -> None:
    """Linux's `prctl(2)`.

    Raises
    ------
    OSError
    """
    if ctypes.CDLL(None, use_errno=True).prctl(option, value, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def all_processes() -> list[Process]:
    """Every process of the machine that /proc shows."""
    with os.scandir("/proc") as entries:
        found = [_read(int(entry.name)) for entry in entries if entry.name.isdecimal()]
    return [process for process in found if process is not None]


def descendants(processes: Iterable[Process], roots: Collection[int]) -> list[Process]:
    """The descendants of `roots` among `processes`, without the roots themselves."""
    children: dict[int, list[Process]] = {}
    for process in processes:
        children.setdefault(process.parent, []).append(process)
    found: list[Process] = []
    waiting = list(roots)
    while waiting:
        for child in children.pop(waiting.pop(), []):
            if child.pid not in roots:
                found.append(child)
            waiting.append(child.pid)
    return found


def end_descendants(root: int, patience: float = 10.0) -> None:
    """Kill all descendants of `root`, again and again until none is alive.

    If `root` is a subreaper (`prctl(2)`), it becomes the parent of every orphan among them: none
    escapes by a double fork.
    """
    deadline = time.monotonic() + patience
    while time.monotonic() < deadline:
        alive = [p for p in descendants(all_processes(), {root}) if p.alive]
        if not alive:
            return
        _kill(alive)


def end_known(known: Collection[tuple[int, int]], patience: float = 10.0) -> None:
    """Kill processes, known by (pid, start), with their descendants and their sessions."""
    deadline = time.monotonic() + patience
    sessions: set[int] = set()
    while time.monotonic() < deadline:
        now = all_processes()
        ours = [p for p in now if (p.pid, p.start) in known or p.session in sessions]
        ours += descendants(now, {p.pid for p in ours})
        sessions.update(p.session for p in ours if p.session in {pid for pid, _ in known})
        alive = [p for p in ours if p.alive]
        if not alive:
            return
        _kill(alive)


def marked_processes(mark: str) -> set[tuple[int, int]]:
    """Processes, as (pid, start), whose environment holds a variable, ``NAME=value``."""
    found = set()
    for process in all_processes():
        with suppress(OSError):  # it has just ended, or is not ours to look into
            variables = Path(f"/proc/{process.pid}/environ").read_bytes().split(b"\0")
            if os.fsencode(mark) in variables:
                found.add((process.pid, process.start))
    return found


def proportional_memory(processes: Iterable[Process]) -> int:
    """Bytes that the processes hold together; each shared page is split among its users."""
    total = 0
    for process in processes:
        try:
            lines = Path(f"/proc/{process.pid}/smaps_rollup").read_bytes().splitlines()
            total += 1024 * next(int(x.split()[1]) for x in lines if x.startswith(b"Pss:"))
        except (OSError, StopIteration):  # it has just ended
            continue
    return total


def deleted_bytes(processes: Iterable[Process]) -> int:
    """Bytes of the files that they hold open and that have been deleted from every folder."""
    sizes: dict[tuple[int, int], int] = {}
    for process in processes:
        with suppress(OSError):  # it has just ended, or is not ours to look into
            for link in Path(f"/proc/{process.pid}/fd").iterdir():
                with suppress(OSError):
                    held = link.stat()
                    if stat.S_ISREG(held.st_mode) and held.st_nlink == 0:
                        sizes[held.st_dev, held.st_ino] = 512 * held.st_blocks
    return sum(sizes.values())


def _read(pid: int) -> Process | None:
    try:
        line = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:  # it has just ended
        return None
    # The second field is the program's name in brackets, and may hold anything.
    state, *rest = line[line.rindex(b")") + 2 :].split()
    numbers = [int(word) for word in rest]
    return Process(
        pid=pid,
        parent=numbers[0],
        session=numbers[2],
        alive=state not in (b"Z", b"X"),
        start=numbers[18],
        seconds=sum(numbers[10:14]) / _TICKS,
        threads=numbers[16],
        resident=numbers[20] * _PAGE,
    )


def _kill(processes: Iterable[Process]) -> None:
    for process in processes:
        with suppress(ProcessLookupError, PermissionError):
            os.kill(process.pid, signal.SIGKILL)
    time.sleep(0.005)
