"""A Dask scheduler and its workers on the loopback, started as a user starts them."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from reference.jobs.processes import end_descendants
from tests.helpers.places import ROOT

#: Less patient than by itself with jobs that waited where a worker died: ours are told apart.
SETTINGS = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}


@dataclass
class Dask:
    """A scheduler of its own in a folder; workers are started by and by."""

    folder: Path
    address: str = ""
    processes: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def scheduler(self) -> subprocess.Popen[bytes]:
        """Start it, and wait until it can be reached."""
        process = self._started("scheduler", "scheduler", "--host", "127.0.0.1", "--port", "0")
        log = self.folder / "scheduler.log"
        deadline = time.monotonic() + 60
        while "Scheduler at:" not in (text := log.read_text(encoding="utf-8")):
            assert time.monotonic() < deadline, text
            time.sleep(0.05)
        self.address = text.partition("Scheduler at:")[2].split()[0]
        return process

    def worker(self, name: str, *more: str) -> subprocess.Popen[bytes]:
        """Start a worker of one thread; it comes when it comes."""
        place = ["--name", name, "--local-directory", str(self.folder / name)]
        return self._started(name, "worker", self.address, "--nthreads", "1", *place, *more)

    def _started(self, name: str, *words: str) -> subprocess.Popen[bytes]:
        home = self.folder / name
        home.mkdir()
        program = str(Path(sys.executable).with_name("dask"))
        environment = {
            **os.environ, **SETTINGS,
            "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(home / "cache"),
        }  # fmt: skip
        with (self.folder / f"{name}.log").open("wb") as log:
            process = subprocess.Popen(
                [program, *words, "--no-dashboard"], cwd=home, env=environment, stderr=log
            )
        self.processes.append(process)
        return process


@contextmanager
def running(folder: Path) -> Iterator[Dask]:
    """A scheduler that is gone, with all its workers, when the block ends."""
    dask = Dask(folder)
    try:
        dask.scheduler()
        yield dask
    finally:
        for process in dask.processes:
            end_descendants(process.pid)
            process.kill()
            process.wait()
