"""Whether there is memory for what is about to be done: asked before, not found out too late."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from minirt.errors import InputError

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
    """Bytes that this process may still take: the least of all that is told; None if nothing is."""
    return min(_told(), default=None)


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
