"""Runs of small programs for the tests: as whoever runs the tests, and as another user."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import Any

import pytest

from reference.jobs.program import Limits, ProgramEnd, run_program
from tests.helpers.places import ROOT

#: Debian's `nobody`: an ordinary user, for whom the sandbox is made with user namespaces.
NOBODY = 65534
_AS_NOBODY = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"]
#: `run_program` in a process of its own.
JOB = """
import json, sys
from dataclasses import asdict
from pathlib import Path
from reference.jobs.program import Limits, run_program
command, workdir, limits, sandbox = json.loads(sys.argv[1])
print(json.dumps(asdict(run_program(command, Path(workdir), Limits(**limits), sandbox))))
"""


def users() -> list[str]:
    """Root tests as `nobody` too."""
    return ["me"] if os.geteuid() != 0 else ["me", "nobody"]


def _as_nobody(python: str, job: str) -> subprocess.CompletedProcess[str]:
    """A job of `nobody`, with this environment's packages whichever Python it is."""
    environment = {**os.environ, "PYTHONPATH": sysconfig.get_path("purelib")}
    words = [*_AS_NOBODY, python, "-c", JOB, job]
    return subprocess.run(
        words, cwd=ROOT, capture_output=True, text=True, check=False, env=environment
    )


@lru_cache
def nobodys_python() -> str | None:
    """A Python that `nobody` can run with our packages: root's own may lie in root's home."""
    for python in [sys.executable, "/usr/bin/python3"]:
        with TemporaryDirectory(prefix="minirt-test-") as folder:
            shutil.chown(folder, NOBODY, NOBODY)
            job = json.dumps([[python, "-S", "-c", "print(1)"], folder, {}, False])
            done = _as_nobody(python, job)
            if done.returncode == 0 and json.loads(done.stdout) == asdict(ProgramEnd(0, "", "1\n")):
                return python
    return None


@dataclass
class Place:
    """A working folder beside one that nobody else may touch, and a user who runs programs."""

    user: str
    folder: Path
    limits: Limits = field(default_factory=lambda: Limits(wall_seconds=30))

    @property
    def workdir(self) -> Path:
        return self.folder / "workdir"

    @property
    def python(self) -> str:
        """The interpreter of the programs that are run."""
        if self.user == "me":
            return sys.executable
        return nobodys_python() or pytest.skip("nobody can run no Python here with our packages")

    @property
    def secret(self) -> Path:
        return self.folder / "neighbour" / "reference.txt"

    def run(self, code: str, *arguments: str, sandbox: bool = True, **limits: Any) -> ProgramEnd:
        """Run Python code as the user."""
        subject = self.workdir / "subject.py"
        subject.write_text(code, encoding="utf-8")
        command = [self.python, "-S", str(subject), *arguments]
        return self.run_command(command, sandbox=sandbox, **limits)

    def run_command(self, command: list[str], sandbox: bool = True, **limits: Any) -> ProgramEnd:
        """Run a command as the user."""
        wanted = {**asdict(self.limits), **limits}
        if self.user == "me":
            return run_program(command, self.workdir, Limits(**wanted), sandbox)
        for path in [self.workdir, *self.workdir.iterdir()]:
            shutil.chown(path, NOBODY, NOBODY)
        job = json.dumps([command, str(self.workdir), wanted, sandbox])
        done = _as_nobody(self.python, job)
        assert done.returncode == 0, done.stderr
        return ProgramEnd(**json.loads(done.stdout))

    def snapshot(self) -> dict[str, object]:
        """What lies beside the working folder, with its content and times."""
        beside = self.folder / "neighbour"
        return {
            str(path): (path.lstat().st_mtime_ns, path.is_file() and path.read_bytes())
            for path in [beside, *beside.rglob("*")]
        }

    def survivors(self) -> list[int]:
        """Processes that were started in the working folder and are alive."""
        mark, found = os.fsencode(f"TMPDIR={self.workdir}"), []
        for entry in Path("/proc").iterdir():
            try:
                if entry.name.isdecimal() and mark in (entry / "environ").read_bytes():
                    found.append(int(entry.name))
            except OSError:  # it has just ended
                continue
        return found


@contextmanager
def place_of(user: str) -> Iterator[Place]:
    """A place for one test, with the assertion that nothing beside the working folder changed."""
    folder = Path(mkdtemp(prefix="minirt-test-")).resolve()
    try:
        folder.chmod(0o755)
        place = Place(user, folder)
        place.workdir.mkdir()
        place.secret.parent.mkdir()
        place.secret.write_text("the right answer", encoding="utf-8")
        before = place.snapshot()
        yield place
        assert place.snapshot() == before
        assert place.survivors() == []
    finally:
        subprocess.run(["rm", "-rf", "--", str(folder)], check=True)  # noqa: S607
