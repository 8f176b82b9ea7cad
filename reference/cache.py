"""A cache on disk of frames and their stability, by a hash of everything that they depend on.

A frame and its stability depend on the scene, its meshes, the declared error and this program; a
reference's frame on the scene, this program, the reference's own versions and the processor. All of
them are in the key, down to the bytes of the source files, so that no stale entry is ever found.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import sys
import time
import zipfile
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache as once
from importlib import metadata
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

import numpy as np

from minirt.errors import InputError
from minirt.frame import Array, Frame
from minirt.render import frame_meta
from minirt.scene import Facets, Scene
from reference.compare.stability import Exact, Stability, exact_answer, stability_of
from reference.jobs.identity import source_digest
from reference.source import Declared, Reference, Rendering, Reproducible

#: Bytes on disk beyond which the least recently used entries are removed.
MOST_BYTES = 6 * 2**30

Arrays = dict[str, Array]


def usual_folder() -> Path:
    """The usual folder of the cache: below ``XDG_CACHE_HOME``, or ``~/.cache``."""
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(base).expanduser() / "minirt"


@dataclass(frozen=True)
class Cache:
    """Frames and their stability in a folder; any number of processes may share it.

    Attributes
    ----------
    folder : Path
        Created if it does not exist. An entry that cannot be read or written is computed anew.
    most_bytes : int
    """

    folder: Path
    most_bytes: int = MOST_BYTES

    def exact(self, scene: Scene) -> Exact:
        """minirt's own answer: see `reference.compare.stability.exact_answer`."""
        key = _key("exact", scene)
        found = self._get(key)
        if found is None:
            exact = exact_answer(scene)
            self._put(key, {"signature": exact.signature, **exact.frame.arrays})
            return exact
        signature = found.pop("signature")
        return Exact(scene, Frame(found, frame_meta(scene)), signature)

    def stability(self, exact: Exact, declared: Declared, names: Collection[str]) -> Stability:
        """The stability of minirt's answer: see `reference.compare.stability.stability_of`."""
        error = repr(replace(declared, derivation=""))
        key = _key("stability", exact.scene, error, *sorted(names))
        found = self._get(key)
        if found is None:
            made = stability_of(exact, declared, names)
            certain = {f"certain {name}": array for name, array in made.certain.items()}
            tolerance = {f"tolerance {name}": array for name, array in made.tolerance.items()}
            self._put(key, {**certain, **tolerance})
            return made
        return Stability(_part(found, "certain "), _part(found, "tolerance "))

    def rendering(
        self, reference: Reference, scene: Scene, scratch: Path
    ) -> tuple[Rendering, float, bool]:
        """A reference's answer, the seconds that it took, and whether it comes from the cache.

        Answers of `Reproducible` references are cached; exceptions are not.
        """
        key = _rendering_key(reference, scene) if isinstance(reference, Reproducible) else None
        found = None if key is None else _rendering(self._get(key))
        if found is not None:
            return *found, True
        made, seconds = timed_rendering(reference, scene, scratch)
        if key is not None:
            about = {
                "unsupported": dict(made.unsupported),
                "program": made.program,
                "seconds": seconds,
            }
            self._put(key, {"about": np.array(json.dumps(about)), **made.frame.arrays})
        return made, seconds, False

    def _get(self, key: str) -> Arrays | None:
        path = self.folder / f"{key}.npz"
        try:
            with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
                found = {name: archive[name] for name in archive.files}
            os.utime(path)  # marks it as used
        except (OSError, ValueError, zipfile.BadZipFile, EOFError, KeyError):
            return None
        return found

    def _put(self, key: str, arrays: Arrays) -> None:
        """Write an entry whole or not at all; writers of the same key write the same bytes."""
        with suppress(OSError):
            self.folder.mkdir(parents=True, exist_ok=True)
            with NamedTemporaryFile(dir=self.folder, suffix=".tmp", delete=False) as stream:
                try:
                    np.savez(stream, **dict[str, Any](arrays))
                    stream.close()
                    Path(stream.name).replace(self.folder / f"{key}.npz")
                except BaseException:
                    Path(stream.name).unlink(missing_ok=True)
                    raise
            self._prune()

    def _prune(self) -> None:
        """Remove the least recently used entries until the rest is within the limit."""
        used = []
        for path in self.folder.iterdir():
            with suppress(OSError):
                status = path.stat()
                used.append((status.st_mtime, status.st_size, path))
        total = sum(size for _, size, _ in used)
        for _, size, path in sorted(used):
            if total <= self.most_bytes:
                return
            path.unlink(missing_ok=True)
            total -= size


def timed_rendering(reference: Reference, scene: Scene, scratch: Path) -> tuple[Rendering, float]:
    """A reference's answer, and the seconds that it took."""
    start = time.perf_counter()
    made = reference.render(scene, scratch)
    return made, time.perf_counter() - start


def _rendering(found: Arrays | None) -> tuple[Rendering, float] | None:
    """A reference's answer from the cache; None if it cannot be read."""
    if found is None:
        return None
    try:
        about = json.loads(str(found.pop("about")))
        return Rendering(Frame(found), about["unsupported"], about["program"]), about["seconds"]
    except (KeyError, ValueError, TypeError, InputError):
        return None


def _part(arrays: Arrays, prefix: str) -> Arrays:
    names = [name for name in arrays if name.startswith(prefix)]
    return {name.removeprefix(prefix): arrays[name] for name in names}


def _key(kind: str, scene: Scene, *parts: str) -> str:
    digest = hashlib.sha256()
    for part in (kind, _program(), scene.sha256, *parts):
        digest.update(part.encode() + b"\0")
    for thing in scene.objects:
        if isinstance(thing, Facets) and thing.type == "mesh":
            digest.update(thing.vertices.tobytes())
            digest.update(thing.faces.tobytes())
    return digest.hexdigest()


@once
def _program() -> str:
    """Everything that computes: minirt's source files, NumPy and Python."""
    sources = source_digest("minirt", "converters", "reference")
    return f"{sys.version} {np.__version__} {sources}"


def _rendering_key(reference: Reproducible, scene: Scene) -> str:
    parts = [_ingredient(part) for part in reference.ingredients()]
    return _key("rendering", scene, repr(reference), _processor(), *parts)


def _ingredient(part: str | Path | None) -> str:
    """A distribution's version, or a file's path, size and time, which change if it is replaced."""
    if part is None:
        return ""
    try:
        if isinstance(part, str):
            return f"{part} {metadata.version(part)}"
        real = part.resolve(strict=True)
        status = real.stat()
    except (metadata.PackageNotFoundError, OSError, RuntimeError):  # RuntimeError: a loop of links
        return f"{part} absent"
    return f"{real} {status.st_size} {status.st_mtime_ns}"


@once
def _processor() -> str:
    """The processor and its features, which compilers use."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return platform.machine()
    return "".join(sorted({x for x in lines if x.startswith(("model name", "flags", "Features"))}))
