"""The LLVM library that Mitsuba's vectorised variants compile with."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

#: drjit 1.5 aborts the process on some kernels with LLVM 14, 15 and 16; 18 and 19 work.
OLDEST = 18
#: The variable that tells drjit which library to load.
VARIABLE = "DRJIT_LIBLLVM_PATH"

_FOLDERS = (
    "/usr/lib/*-linux-gnu",
    "/usr/lib/llvm-*/lib",
    "/usr/lib64",
    "/usr/lib",
    "/usr/local/lib",
)
_VERSION = re.compile(r"libLLVM(?:-|\.so\.)(\d+)")


def find_llvm() -> Path | None:
    """Path of a libLLVM that drjit works with; None where there is none.

    A path in ``DRJIT_LIBLLVM_PATH`` is taken as it is; next come the Python environment's own
    (PyPI's ``karellen-llvm-core``) and the system's, the newest first.
    """
    chosen = os.environ.get(VARIABLE)
    if chosen:
        return Path(chosen) if Path(chosen).is_file() else None
    own = _candidates(Path(sys.prefix), "lib")
    system = [c for folder in _FOLDERS for c in _candidates(Path("/"), folder.lstrip("/"))]
    for found in (own, system):
        if found:
            return max(found)[1]
    return None


def _candidates(root: Path, folder: str) -> list[tuple[int, Path]]:
    """Versions and paths of the libraries in a folder that are new enough."""
    found = []
    for path in root.glob(f"{folder}/libLLVM*.so*"):
        version = _VERSION.match(path.resolve().name)
        if path.is_file() and version and int(version[1]) >= OLDEST:
            found.append((int(version[1]), path.resolve()))
    return found
