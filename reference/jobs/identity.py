"""The identity of a minirt: the hash of its source files, and the versions that it runs on."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from minirt import __version__

#: All packages that ship as minirt.
PACKAGES = ("minirt", "converters", "reference", "reports")
_SOURCES = (".py", ".j2", ".css")


@cache
def source_digest(*packages: str) -> str:
    """SHA-256 of the source files of packages, read once a process."""
    digest = hashlib.sha256()
    for package in packages:
        spec = find_spec(package)
        for folder in (spec.submodule_search_locations or ()) if spec else ():
            for path in sorted(Path(folder).rglob("*")):
                if path.suffix in _SOURCES:
                    digest.update(path.read_bytes())
    return digest.hexdigest()


def identity() -> str:
    """In words, what must be equal on two machines for their answers to be equal."""
    return (
        f"minirt {__version__} with the sources {source_digest(*PACKAGES)[:16]}, "
        f"Python {platform.python_version()}, NumPy {np.__version__}"
    )
