"""Make a pack, or approve other frames in it: confirmed, and written whole or not at all."""

from __future__ import annotations

import platform
import re
import shutil
from collections.abc import Callable, Collection, Iterable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from converters.atomic import atomic_folder, require_replaceable
from minirt.errors import InputError, ReferenceError
from minirt.scene import Scene
from minirt.version import __version__
from reference.jobs.isolate import Workers
from reports.pack.confirm import Confirmed, PackOptions, confirm
from reports.pack.manifest import (
    CHECKSUM,
    MANIFEST,
    Approval,
    Manifest,
    SceneEntry,
    read_manifest,
    write_manifest,
)
from reports.pack.scene import pack_scene

#: Called with the numbers of steps done and of all steps.
Progress = Callable[[int, int], None]
#: No reference confirms, only exact arithmetic.
DEFAULTS = PackOptions()


def make_pack(
    scenes: Sequence[Scene],
    folder: Path,
    options: PackOptions = DEFAULTS,
    progress: Progress | None = None,
) -> Manifest:
    """Write a pack of reference images.

    Parameters
    ----------
    scenes : sequence of Scene
        At least one; their names differ.
    folder : Path
        New, empty, or an earlier pack of these scenes, or fewer, whose frames are the same: see
        `approve_pack`.
    options : PackOptions
    progress : callable, optional
        Called with the numbers of steps done and of all steps.

    Raises
    ------
    InputError
        The folder holds something else, frames that are not these, or more scenes.
    ReferenceError
        A frame is contradicted, or a required reference did not answer.
    """
    _require_replaceable_pack(folder)
    old = read_manifest(folder) if (folder / MANIFEST).exists() else None
    confirming, writing = _halves(len(scenes), progress)
    confirmed = confirm(scenes, options, confirming)
    with atomic_folder(folder) as staging:
        entries = _entries(scenes, confirmed, staging, options.jobs, writing)
        manifest = _manifest(entries, confirmed, options.required, old.approvals if old else ())
        if old is not None:
            _require_unchanged(old, manifest, folder)
        write_manifest(manifest, staging)
    return manifest


def approve_pack(
    folder: Path,
    scenes: Sequence[Scene],
    who: str,
    why: str,
    options: PackOptions = DEFAULTS,
    progress: Progress | None = None,
) -> tuple[Approval, ...]:
    """Replace or add scenes of a pack on purpose; the others keep every byte.

    Parameters
    ----------
    folder : Path
        A pack.
    scenes : sequence of Scene
        To be rendered and confirmed anew.
    who, why : str
        Kept in the pack; not empty.
    options, progress
        As for `make_pack`.

    Returns
    -------
    tuple of Approval
        One for each scene whose frame is another now.

    Raises
    ------
    InputError
        It is no pack, or `who` or `why` is empty.
    ReferenceError
        As for `make_pack`.
    """
    for name, text in (("who", who), ("why", why)):
        if not text.strip():
            raise InputError("an approval says who and why", where=name, got=repr(text))
    _require_replaceable_pack(folder)
    old = read_manifest(folder)
    confirming, writing = _halves(len(scenes), progress)
    confirmed = confirm(scenes, options, confirming)
    with atomic_folder(folder) as staging:
        fresh = {
            entry.name: entry
            for entry in _entries(scenes, confirmed, staging, options.jobs, writing)
        }
        kept = [entry for entry in old.scenes if entry.name not in fresh]
        for entry in kept:
            shutil.copytree(folder / entry.folder, staging / entry.folder)
        places = {entry.name: k for k, entry in enumerate(old.scenes)}
        entries = sorted([*kept, *fresh.values()], key=lambda e: places.get(e.name, len(places)))
        records = tuple(_approvals(old, fresh.values(), who, why))
        manifest = _manifest(entries, confirmed, options.required, (*old.approvals, *records))
        write_manifest(manifest, staging)
    return records


def _entries(
    scenes: Sequence[Scene], confirmed: Confirmed, staging: Path, jobs: int,
    progress: Callable[[int], None],
) -> list[SceneEntry]:  # fmt: skip
    """Every scene's folder and record, each made in a child process."""
    entries = []
    with Workers(max(1, min(jobs, len(scenes)))) as workers:
        started = [
            workers.submit(None, pack_scene, scene, confirmed.by[scene.name], staging / name)
            for scene, name in zip(scenes, _folders(scenes), strict=True)
        ]
        for scene, job in zip(scenes, started, strict=True):
            outcome = job.outcome()
            if outcome.state != "done":
                raise ReferenceError("cannot be packed", where=scene.name, got=outcome.reason)
            entries.append(outcome.value)
            progress(len(entries))
    return entries


def _manifest(
    entries: list[SceneEntry], confirmed: Confirmed, required: Collection[str],
    approvals: Iterable[Approval],
) -> Manifest:  # fmt: skip
    return Manifest(
        minirtPack=1,
        versions={
            "minirt": __version__, "NumPy": np.__version__, "Python": platform.python_version()
        },
        references=confirmed.programs,
        required=sorted(required),
        scenes=entries,
        approvals=list(approvals),
    )  # fmt: skip


def _folders(scenes: Sequence[Scene]) -> list[str]:
    """A folder's name for each scene: its own where every system takes it."""
    names = [re.sub(r"[^A-Za-z0-9._-]+", "-", scene.name).strip(".-")[:60] for scene in scenes]
    folded = [name.lower() for name in names]
    return [
        name
        if name and folded.count(name.lower()) == 1
        else f"{name or 'scene'}-{scene.sha256[:8]}"
        for name, scene in zip(names, scenes, strict=True)
    ]


def _approvals(
    old: Manifest, fresh: Iterable[SceneEntry], who: str, why: str
) -> Iterable[Approval]:
    for entry in fresh:
        before, now = old.entry(entry.name), _hashes(entry)
        was = {} if before is None else _hashes(before)
        if was != now:
            yield Approval(scene=entry.name, who=who, why=why, old=was, new=now)


def _hashes(entry: SceneEntry) -> dict[str, str]:
    return {name: quantity.sha256 for name, quantity in entry.quantities.items()}


def _require_replaceable_pack(folder: Path) -> None:
    """Refuse a folder that holds anything but an earlier pack."""
    if not (folder / MANIFEST).exists():
        require_replaceable(folder, ())
        return
    known = {MANIFEST, CHECKSUM, *(entry.folder for entry in read_manifest(folder).scenes)}
    require_replaceable(folder, sorted(known))


def _require_unchanged(old: Manifest, new: Manifest, folder: Path) -> None:
    lost = [entry.name for entry in old.scenes if new.entry(entry.name) is None]
    if lost:
        raise InputError(
            "the pack there has scenes that would be lost", where=str(folder),
            got=", ".join(lost)[:200], expected="these scenes too, or another folder",
        )  # fmt: skip
    changed = [
        entry.name
        for entry in new.scenes
        if (before := old.entry(entry.name)) is not None and _hashes(before) != _hashes(entry)
    ]
    if changed:
        raise InputError(
            "the pack there has other frames", where=str(folder), got=", ".join(changed)[:200],
            expected="the same, or minirt pack approve",
        )  # fmt: skip


def _halves(
    scenes: int, progress: Progress | None
) -> tuple[Callable[[int], None], Callable[[int], None]]:
    """Two callbacks: for scenes that are confirmed, and for those that are written afterwards."""

    def tell(before: int, done: int) -> None:
        if progress is not None:
            progress(before + done, 2 * scenes)

    return partial(tell, 0), partial(tell, scenes)
