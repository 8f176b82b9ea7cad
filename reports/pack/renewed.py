"""Which scenes of a pack are approved anew, and what a pack holds in one line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from minirt import load_scene
from minirt.scene import Scene
from reports.inputs import chosen_scenes
from reports.pack import Only
from reports.pack.check import differences
from reports.pack.manifest import Manifest, read_manifest
from reports.results.words import count, listed


def renewed_scenes(
    folder: Path, only: Only, scenes: Sequence[str] | None, jobs: int
) -> list[Scene]:
    """The scenes that are to be rendered and confirmed anew.

    Parameters
    ----------
    folder : Path
        A pack.
    only : Only
    scenes : sequence of str or None
        Names of scenes that the pack may lack; None: the atlas.
    jobs : int
    """
    manifest = read_manifest(folder)
    packed = {entry.name: folder / entry.folder / "scene.json" for entry in manifest.scenes}
    lacking = (
        [s for s in chosen_scenes(scenes) if s.name not in packed] if only != Only.failing else []
    )
    if only is Only.missing:
        return lacking
    if only is Only.failing:
        differing = {each.scene for each in differences(folder, jobs)}
        packed = {name: path for name, path in packed.items() if name in differing}
    return [load_scene(path) for path in packed.values()] + lacking


def pack_summary(folder: Path, manifest: Manifest) -> str:
    """The scenes of a pack, who confirms them, and the quantities that are not confirmed."""
    who = listed([*manifest.references, "exact arithmetic"])
    open_ = {
        name
        for entry in manifest.scenes
        for name, quantity in entry.quantities.items()
        if not quantity.confirmed_by
    }
    tail = f"; not checked somewhere: {', '.join(sorted(open_))}" if open_ else ""
    return f"{folder}: {count(len(manifest.scenes), 'scene')}, confirmed by {who}{tail}"
