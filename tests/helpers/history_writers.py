"""Processes that write a history: at once, or until they are killed."""

from __future__ import annotations

import multiprocessing.synchronize
import os
import random
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import count
from pathlib import Path

from reports.history.entry import Entry
from reports.history.store import History

#: Processes that have imported what a history needs before they begin.
READY = multiprocessing.get_context("forkserver")
READY.set_forkserver_preload(["reports.history.store"])


def append_many(
    target: str,
    run: Entry,
    digests: Sequence[str],
    gate: multiprocessing.synchronize.Barrier,
) -> None:
    """Open a history when all are there, and add a run many times."""
    gate.wait(60)
    with History(target) as history:
        for digest in digests:
            history.append(replace(run, digest=digest))


def write_until_killed(target: str, folder: Path, acknowledge: int) -> None:
    """Write reports and add runs without end; say the number of each that was added."""
    from reports.history.entry import entry_of
    from reports.results.record import results_document
    from reports.run import write_reports
    from tests.helpers.report_runs import good_run

    run = replace(good_run(), folder=folder)
    entry = entry_of(results_document(run))
    with History(target) as history:
        for mark in count():
            number = history.append(replace(entry, digest=f"{os.getpid()}-{mark}"))
            os.write(acknowledge, f"{number}\n".encode())
            write_reports(run)


def main(folder: Path, seed: str) -> None:
    """For each line "begin TARGET" or "write TARGET": a writer that is killed.

    Either at any moment from its beginning, or at any after it has added its first run. Prints
    what it had added.
    """
    import reports.run
    from tests.helpers.report_runs import good_run

    texts = {name: make(good_run()) for name, make in reports.run.REPORTS.items()}
    reports.run.REPORTS = {name: lambda _, t=text: t for name, text in texts.items()}  # type: ignore[misc]
    moments = random.Random(seed)  # noqa: S311 - not for secrets
    for line in sys.stdin:
        word, target = line.split()
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            write_until_killed(target, folder, writer)
        os.close(writer)
        told = os.read(reader, 1000) if word == "write" else b""
        time.sleep(moments.uniform(0, 0.1 if word == "write" else 0.3))
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        with os.fdopen(reader, "rb") as pipe:
            numbers = (told + pipe.read()).decode().split()
        print("killed" if os.WIFSIGNALED(status) else "ended", *numbers, flush=True)  # noqa: T201


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
