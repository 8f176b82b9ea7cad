"""What is installed here, whether each reference renderer really works, what brings the rest."""

from __future__ import annotations

import os
import platform
import re
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np

from minirt import __version__, load_scene
from reference.jobs.isolate import Workers
from reference.jobs.sandbox import sandbox_missing, sandbox_version
from reference.registry import REFERENCES, choose_references
from reference.renderers.mitsuba.cli import find_command
from reference.renderers.mitsuba.llvm import OLDEST, VARIABLE, find_llvm
from reference.source import Reference

#: Seconds for a picture of 192 pixels; a cold start of Mitsuba takes some two.
TIMEOUT = 60.0


@dataclass(frozen=True)
class Package:
    """A library: `version` is None where it is missing; `brings` is the command that brings it."""

    name: str
    version: str | None
    needed: bool
    brings: str


@dataclass(frozen=True)
class Trial:
    """How a reference renderer did on a tiny scene.

    Attributes
    ----------
    reference : str
    state : str
    program : str
        What really ran.
    reason, output : str
        Why it did not work, with the command that helps where one is known; its last output.
    seconds : float
        Including the start of the process.
    required : bool
    """

    reference: str
    state: Literal["works", "missing", "failed", "crashed", "timed out"]
    program: str = ""
    reason: str = ""
    output: str = ""
    seconds: float = 0.0
    required: bool = False


@dataclass(frozen=True)
class Examination:
    """Everything the doctor found."""

    machine: dict[str, str]
    packages: tuple[Package, ...]
    references: tuple[Trial, ...]

    @property
    def healthy(self) -> bool:
        """Whether everything works that minirt needs or that was required."""
        here = all(package.version for package in self.packages if package.needed)
        return here and all(trial.state == "works" for trial in self.references if trial.required)

    def document(self) -> dict[str, Any]:
        """As JSON."""
        return {"healthy": self.healthy, **asdict(self)}


def examine(
    required: Sequence[str] = (), progress: Callable[[int, int], None] | None = None
) -> Examination:
    """Look at the machine, the packages, and try every reference in a child process.

    Parameters
    ----------
    required : sequence of str
        Names of references that must work.
    progress : callable, optional
        Called with references tried and references in all.

    Raises
    ------
    InputError
        An unknown name among those required.
    """
    names = {reference.name for reference in choose_references(required)}
    trials = []
    for number, reference in enumerate(REFERENCES.values(), start=1):
        trials.append(attempt(reference, reference.name in names))
        if progress is not None:
            progress(number, len(REFERENCES))
    return Examination(_machine(), tuple(_packages()), tuple(trials))


def attempt(reference: Reference, required: bool = False, timeout: float = TIMEOUT) -> Trial:
    """Render a tiny scene with a reference in a child process, and say how it went."""
    reason = reference.missing()
    if reason:
        return Trial(reference.name, "missing", reason=reason, required=required)
    begin = time.perf_counter()
    with Workers(1) as workers:
        outcome = workers.submit(timeout, _render_tiny, reference).outcome()
    seconds = time.perf_counter() - begin
    if outcome.state == "done":
        return Trial(reference.name, "works", outcome.value, "", "", seconds, required)
    state: Any = "failed" if outcome.state == "raised" else outcome.state
    return Trial(reference.name, state, "", outcome.reason, outcome.output, seconds, required)


def _render_tiny(reference: Reference) -> str:
    """Render 16 × 12 pixels of one sphere; the name of what ran. Runs in a child process."""
    document = load_scene("atlas:one-sphere").to_dict()
    document["screen"] |= {"nx": 16, "ny": 12}
    with TemporaryDirectory(prefix="minirt-") as scratch:
        rendering = reference.render(load_scene(document), Path(scratch))
    if not rendering.frame["hit"].any():
        raise ValueError("it does not see the sphere")
    return rendering.program


def _machine() -> dict[str, str]:
    simd = np.show_config(mode="dicts")["SIMD Extensions"]
    library, command = find_llvm(), find_command()
    no_library = f"none of version {OLDEST} or newer; {VARIABLE} can name one"
    return {
        "minirt": __version__,
        "Python": f"{platform.python_version()}, {sys.executable}",
        "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
        "processors": str(os.cpu_count()),
        "NumPy's SIMD": " ".join([*simd["baseline"], *simd["found"]]),
        "libLLVM": str(library) if library else no_library,
        "mitsuba": str(command) if command else "no such command",
        "sandbox": sandbox_missing() or sandbox_version(),
    }


def _packages() -> Iterator[Package]:
    """What the project's own metadata asks for, its tests' needs left out."""
    for text in metadata.requires("minirt") or ():
        specifier, _, marker = text.partition(";")
        if "extra == 'test'" in marker.replace('"', "'"):
            continue
        name = re.split(r"[^\w.-]", specifier)[0]
        command = [sys.executable, "-m", "pip", "install", specifier.strip()]
        yield Package(name, _version(name), "extra" not in marker, shlex.join(command))


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
