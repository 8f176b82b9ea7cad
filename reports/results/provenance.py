"""Where and from what a run's results came."""

from __future__ import annotations

import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from minirt.version import __version__


@dataclass(frozen=True)
class Provenance:
    """What somebody needs to know to repeat a run.

    Attributes
    ----------
    commit : str or None
        Of the git checkout that the working folder lies in; None outside one.
    dirty : bool or None
        Whether files differ from that commit.
    cpu, system : str
        Model of the processor; name and version of the operating system.
    cores : int
        That this process may use.
    versions : dict of str to str
        Of minirt, Python and NumPy.
    command : str
        The command line, as a shell takes it; the password of a URL is left out.
    started : str
        UTC, ISO 8601.
    """

    commit: str | None
    dirty: bool | None
    cpu: str
    cores: int
    system: str
    versions: dict[str, str]
    command: str
    started: str


def provenance() -> Provenance:
    """What is true of this process now."""
    commit = _git("rev-parse", "HEAD")
    changes = _git("status", "--porcelain") if commit else None
    return Provenance(
        commit=commit,
        dirty=None if changes is None else bool(changes),
        cpu=_cpu(),
        cores=len(os.sched_getaffinity(0))
        if hasattr(os, "sched_getaffinity")
        else os.cpu_count() or 1,
        system=_system(),
        versions={
            "minirt": __version__,
            "Python": platform.python_version(),
            "NumPy": np.__version__,
        },
        command=without_passwords(shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])),
        started=datetime.now(UTC).isoformat(timespec="seconds"),
    )


def without_passwords(text: str) -> str:
    """Text in which a URL's password, before its host or among its options, is three stars.

    Examples
    --------
    >>> without_passwords("--history postgresql://ana:secret@db/minirt?sslpassword=s")
    '--history postgresql://ana:***@db/minirt?sslpassword=***'
    """
    hidden = re.sub(r"(://[^:/?#@\s]*):[^\s/]*@", r"\1:***@", text)
    return re.sub(
        r"([?&]\w*(?:password|passwd|pwd|token)=)[^&\s'\"]*", r"\1***", hidden, flags=re.I
    )


def _git(*arguments: str) -> str | None:
    """What git answers about the working folder; None without git or outside a checkout."""
    git = shutil.which("git")
    if git is None:
        return None
    try:
        done = subprocess.run(
            [git, "--no-optional-locks", *arguments],
            capture_output=True, text=True, errors="replace", timeout=20,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def _cpu() -> str:
    """The processor's model, as Linux names it; its architecture elsewhere."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def _system() -> str:
    try:
        return f"{platform.freedesktop_os_release()['PRETTY_NAME']}, {platform.platform()}"
    except (OSError, KeyError):
        return platform.platform()
