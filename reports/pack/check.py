"""Prove a pack again: render its scenes anew and compare bit by bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from converters.frames.io import read_frame
from minirt import load_scene
from minirt.errors import MinirtError
from minirt.frame import Array
from minirt.render import render
from reference.jobs.isolate import Workers
from reports.pack.manifest import (
    CHECKSUM,
    MANIFEST,
    ChangedManifest,
    Manifest,
    SceneEntry,
    array_hash,
    files_in,
    read_manifest,
)


@dataclass(frozen=True)
class Difference:
    """One thing in which a pack is not what it says.

    Attributes
    ----------
    scene : str
        Empty where it concerns the pack as a whole.
    what : str
        The file or the quantity, and how it differs.
    """

    scene: str
    what: str


def differences(
    folder: Path, jobs: int = 2, progress: Callable[[int, int], None] | None = None
) -> Iterator[Difference]:
    """Everything in which a pack differs from its manifest, or from what minirt renders now.

    Raises
    ------
    InputError
        It is no pack.
    """
    try:
        manifest = read_manifest(folder)
    except ChangedManifest as error:
        yield Difference("", error.what)
        return
    yield from _strangers(folder, manifest)
    with Workers(max(1, min(jobs, len(manifest.scenes)))) as workers:
        started = [workers.submit(None, check_scene, folder, entry) for entry in manifest.scenes]
        for k, (entry, job) in enumerate(zip(manifest.scenes, started, strict=True), start=1):
            outcome = job.outcome()
            found = outcome.value if outcome.state == "done" else [f"no answer: {outcome.reason}"]
            yield from (Difference(entry.name, what) for what in found)
            if progress is not None:
                progress(k, len(manifest.scenes))


def check_scene(folder: Path, entry: SceneEntry) -> list[str]:
    """What differs in one scene. Runs in a child process."""
    place = folder / entry.folder
    found = list(_files(place, entry))
    try:
        scene = load_scene(place / "scene.json")
        kept = read_frame(place / "frame.npz", (entry.ny, entry.nx))
    except MinirtError as error:
        return [*found, str(error)]
    fresh = render(scene)
    for name, quantity in entry.quantities.items():
        if name not in kept:
            found.append(f"{name}: not in frame.npz")
            continue
        if array_hash(kept[name]) != array_hash(fresh[name]):
            found.append(f"{name}: {_where(kept[name], fresh[name])}")
        elif array_hash(fresh[name]) != quantity.sha256:
            found.append(f"{name}: the manifest has another hash than frame.npz")
    return found


def _files(place: Path, entry: SceneEntry) -> Iterator[str]:
    there = files_in(place)
    for name in sorted(entry.files.keys() | there.keys()):
        if name not in there:
            yield f"{name}: missing"
        elif name not in entry.files:
            yield f"{name}: not in the manifest"
        elif there[name] != entry.files[name]:
            yield f"{name}: other bytes than were packed"


def _where(kept: Array, fresh: Array) -> str:
    """How many pixels differ, and the first of them with both values."""
    if kept.shape != fresh.shape or kept.dtype != fresh.dtype:
        return f"packed {kept.dtype} {kept.shape}, now {fresh.dtype} {fresh.shape}"
    ny, nx = kept.shape[:2]
    packed, now = (
        np.ascontiguousarray(a).view(np.uint8).reshape(ny, nx, -1) for a in (kept, fresh)
    )
    different = (packed != now).any(axis=2)
    row, column = np.argwhere(different)[0].tolist()
    return (
        f"{int(different.sum())} of {different.size} pixels differ, the first at column {column}, "
        f"row {row}: packed {kept[row, column]}, now {fresh[row, column]}"
    )


def _strangers(folder: Path, manifest: Manifest) -> Iterator[Difference]:
    known = {MANIFEST, CHECKSUM, *(entry.folder for entry in manifest.scenes)}
    for path in sorted(folder.iterdir()):
        if path.name not in known:
            yield Difference("", f"{path.name}: not in the manifest")
