"""Memory: whether there is enough for what is about to be done, and that it is had cheaply."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

from minirt.errors import InputError

#: A little less than the largest block, 32 MiB, whose size glibc still learns from.
_LEARNT = 2**25 - 2**16

#: Where Linux says what is free, and what a group of processes may use and uses.
_FREE = Path("/proc/meminfo")
_GROUPS = (
    (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory.current")),
    (
        Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
        Path("/sys/fs/cgroup/memory/memory.usage_in_bytes"),
    ),
)


def require_memory(needed: int, what: str) -> None:
    """Refuse what would not fit.

    Parameters
    ----------
    needed : int
        Bytes.
    what : str
        What they are for.

    Raises
    ------
    InputError
        Less is free. Where nothing says how much is, everything is let through.
    """
    free = available()
    if free is not None and needed > free:
        raise InputError(
            "not enough memory", where=what, got=f"{_gigabytes(free)} free",
            expected=f"{_gigabytes(needed)}",
        )  # fmt: skip


def available() -> int | None:
    """Bytes that this process may still take, by the least known limit; None if none is known."""
    return min(_told(), default=None)


def keep_freed_memory() -> None:
    """Have what arrays free at hand for the next ones.

    glibc gives memory back to the system beyond twice the largest block that it has mapped and
    unmapped so far, and the system clears every page that it hands out again: an array's pages cost
    several times the arithmetic on them. So one large block is mapped and unmapped, untouched.
    Other allocators do not care.
    """
    np.empty(_LEARNT, dtype=np.uint8)


def _told() -> Iterator[int]:
    with suppress(OSError, ValueError, StopIteration, IndexError):
        lines = _FREE.read_text(encoding="ascii").splitlines()
        yield int(next(line for line in lines if line.startswith("MemAvailable")).split()[1]) * 1024
    for most, used in _GROUPS:
        with suppress(OSError, ValueError):  # not there, or "max"
            yield max(0, int(most.read_text()) - int(used.read_text()))
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY:
        with suppress(OSError, ValueError, IndexError):
            pages = int(Path("/proc/self/statm").read_text().split()[0])
            yield max(0, limit - pages * resource.getpagesize())


def _gigabytes(count: int) -> str:
    return f"{count / 1e9:.2f} GB"
