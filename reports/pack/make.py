"""Make a pack: render, have every frame confirmed, write it whole or not at all."""

from __future__ import annotations

import platform
import re
import shutil
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from converters.atomic import atomic_folder, require_replaceable
from converters.frames.io import write_frame
from converters.scene_folder import write_scene_folder
from minirt.errors import InputError, ReferenceError
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from minirt.version import __version__
from reference.compare.precision import Claim, Precision, declared
from reference.compare.stability import Exact, Stability, exact_answer, stability_of
from reference.jobs.isolate import Workers
from reference.source import Reference
from reference.verify.options import Options
from reference.verify.results import SceneResult
from reference.verify.run import verify
from reports.pack.manifest import (
    CHECKSUM,
    MANIFEST,
    Approval,
    Manifest,
    QuantityModel,
    SceneEntry,
    ToleranceModel,
    array_hash,
    files_in,
    read_manifest,
    write_manifest,
)
from reports.pack.sheet import write_sheet
from reports.results.cells import scene_state
from reports.results.findings import findings_of
from reports.results.verdict import decide

#: The number formats that a pack says tolerances for.
PRECISIONS: tuple[Precision, ...] = ("float64", "float32", "half")

#: Called with the numbers of steps done and of all steps.
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Confirmed:
    """What was found out about scenes before they are packed.

    Attributes
    ----------
    by : dict of str to dict of str to list of str
        By scene and quantity: who confirms it.
    programs : dict of str to str
        What really ran, by reference.
    """

    by: dict[str, dict[str, list[str]]]
    programs: dict[str, str]


def make_pack(
    scenes: Sequence[Scene],
    folder: Path,
    references: Sequence[Reference] = (),
    required: Collection[str] = (),
    jobs: int = 2,
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
    references : sequence of Reference
        Who is asked to confirm; the exact judge is always asked.
    required : collection of str
        Names of references without whose answer there is no pack.
    jobs : int
    progress : callable, optional

    Raises
    ------
    InputError
        The folder holds something else, frames that are not these, or more scenes.
    ReferenceError
        A frame is contradicted, or a required reference did not answer.
    """
    _require_room(folder)
    old = read_manifest(folder) if (folder / MANIFEST).exists() else None
    first, second = _halves(len(scenes), progress)
    confirmed = confirmations(scenes, references, required, jobs, first)
    with atomic_folder(folder) as staging:
        entries = _entries(scenes, confirmed, staging, jobs, second)
        manifest = _manifest(entries, confirmed, required, old.approvals if old else ())
        if old is not None:
            _require_unchanged(old, manifest, folder)
        write_manifest(manifest, staging)
    return manifest


def approve_pack(
    folder: Path,
    scenes: Sequence[Scene],
    who: str,
    why: str,
    references: Sequence[Reference] = (),
    required: Collection[str] = (),
    jobs: int = 2,
    progress: Progress | None = None,
) -> tuple[Approval, ...]:
    """Replace, or add, scenes of a pack on purpose; the others stay to the byte.

    Parameters
    ----------
    folder : Path
        A pack.
    scenes : sequence of Scene
        To be rendered and confirmed anew.
    who, why : str
        Kept in the pack; not empty.
    references, required, jobs, progress
        As for `make_pack`.

    Returns
    -------
    tuple of Approval
        One for each scene whose frame is another now.

    Raises
    ------
    InputError
        It is no pack, or nobody approves, or for no reason.
    ReferenceError
        As for `make_pack`.
    """
    for name, text in (("who", who), ("why", why)):
        if not text.strip():
            raise InputError("an approval says who and why", where=name, got=repr(text))
    _require_room(folder)
    old = read_manifest(folder)
    first, second = _halves(len(scenes), progress)
    confirmed = confirmations(scenes, references, required, jobs, first)
    with atomic_folder(folder) as staging:
        fresh = {entry.name: entry for entry in _entries(scenes, confirmed, staging, jobs, second)}
        kept = [entry for entry in old.scenes if entry.name not in fresh]
        for entry in kept:
            shutil.copytree(folder / entry.folder, staging / entry.folder)
        places = {entry.name: k for k, entry in enumerate(old.scenes)}
        entries = sorted([*kept, *fresh.values()], key=lambda e: places.get(e.name, len(places)))
        records = tuple(_approvals(old, fresh.values(), who, why))
        manifest = _manifest(entries, confirmed, required, (*old.approvals, *records))
        write_manifest(manifest, staging)
    return records


def confirmations(
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    required: Collection[str],
    jobs: int,
    tell: Callable[[int], None],
) -> Confirmed:
    """Compare scenes with references and exact arithmetic.

    Raises
    ------
    ReferenceError
        Anything contradicts a frame, or a required reference did not answer.
    """
    results = []
    for result in verify(scenes, references, Options(jobs=jobs)):
        results.append(result)
        tell(len(results))
    names = [reference.name for reference in references]
    verdict = decide(findings_of(results, names), names, required)
    refused = [r.scene.name for r in results if scene_state(r) == "failed" or r.judgement is None]
    if refused or any(name in trouble for trouble in verdict.troubles for name in required):
        raise ReferenceError(
            "not confirmed, so nothing was packed", where=", ".join(refused)[:200],
            got=verdict.sentence,
        )  # fmt: skip
    programs = {
        answer.reference: answer.program
        for result in results
        for answer in result.references
        if answer.declared is not None
    }
    return Confirmed({result.scene.name: _confirmed_by(result) for result in results}, programs)


def _confirmed_by(result: SceneResult) -> dict[str, list[str]]:
    by: dict[str, list[str]] = {name: [] for name in QUANTITIES}
    for answer in result.references:
        for check in answer.checks:
            if check.state == "passed":
                by[check.quantity].append(answer.reference)
    for count in result.judgement.counts if result.judgement else ():
        if count.decided and count.agreed == count.decided:
            by[count.quantity].append("judge")
    return by


def _entries(
    scenes: Sequence[Scene], confirmed: Confirmed, staging: Path, jobs: int,
    tell: Callable[[int], None],
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
            tell(len(entries))
    return entries


def pack_scene(scene: Scene, confirmed_by: dict[str, list[str]], folder: Path) -> SceneEntry:
    """Write one scene's folder; give its record. Runs in a child process."""
    exact = exact_answer(scene)
    stabilities = {
        name: stability_of(exact, declared(scene, Claim(name, handed=name))) for name in PRECISIONS
    }
    write_scene_folder(scene, folder)
    write_frame(exact.frame, folder / "frame.npz")
    write_frame(exact.frame, folder / "frame.exr")
    certain = np.logical_and.reduce(list(stabilities["float64"].certain.values()))
    write_sheet(exact.frame, certain, scene.name, folder / "sheet.png")
    for name, stability in stabilities.items():
        _write_masks(stability, folder / f"uncertain-{name}.npz")
    return SceneEntry(
        name=scene.name,
        folder=folder.name,
        sha256=scene.sha256,
        nx=scene.screen.nx,
        ny=scene.screen.ny,
        quantities=_quantities(exact, stabilities, confirmed_by),
        files=files_in(folder),
    )


def _write_masks(stability: Stability, path: Path) -> None:
    """Where each quantity cannot be judged, a bool array each."""
    masks: dict[str, Any] = {name: ~mask for name, mask in stability.certain.items()}
    np.savez_compressed(path, **masks)


def _quantities(
    exact: Exact, stabilities: dict[Precision, Stability], confirmed_by: dict[str, list[str]]
) -> dict[str, QuantityModel]:
    return {
        name: QuantityModel(
            sha256=array_hash(array),
            dtype=array.dtype.str,
            shape=list(array.shape),
            confirmed_by=confirmed_by[name],
            precisions={kind: _tolerance(s, name) for kind, s in stabilities.items()},
        )
        for name, array in exact.frame.items()
    }


def _tolerance(stability: Stability, name: str) -> ToleranceModel:
    certain = stability.certain[name]
    allowed = stability.tolerance[name][certain] if name in stability.tolerance else np.zeros(0)
    return ToleranceModel(
        certain=int(certain.sum()),
        median=float(np.median(allowed)) if allowed.size else None,
        largest=float(allowed.max()) if allowed.size else None,
    )


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


def _require_room(folder: Path) -> None:
    """Only an earlier pack is ever replaced."""
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
    """What is told of scenes that are confirmed, and of scenes that are written after that."""

    def tell(before: int, done: int) -> None:
        if progress is not None:
            progress(before + done, 2 * scenes)

    return partial(tell, 0), partial(tell, scenes)
