"""One scene of a pack: its folder with the frame, the contact sheet and the uncertain pixels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from converters.frames.io import write_frame
from converters.scene_folder import write_scene_folder
from minirt.scene import Scene
from reference.compare.precision import Claim, Precision, declared
from reference.compare.stability import Exact, Stability, exact_answer, stability_of
from reports.pack.contact_sheet import write_sheet
from reports.pack.manifest import (
    QuantityModel,
    SceneEntry,
    ToleranceModel,
    array_hash,
    files_in,
)

#: The number formats that a pack says tolerances for.
PRECISIONS: tuple[Precision, ...] = ("float64", "float32", "half")


def pack_scene(scene: Scene, confirmed_by: dict[str, list[str]], folder: Path) -> SceneEntry:
    """Write the folder of one scene, and return its entry. Runs in a child process."""
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
    """Write where each quantity is uncertain, one bool array each."""
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
