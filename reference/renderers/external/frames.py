"""Frames that another implementation has written, now or earlier."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from converters.frames.io import read_frame
from minirt.errors import MinirtError
from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.compare.precision import Claim, declared
from reference.source import Declared, NoAnswer, Rendering

#: Formats of integers: 8 or 16 bits of a colour are too coarse to compare.
_INTEGERS = frozenset({".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".tga"})


@dataclass(frozen=True)
class FramesSubject:
    """Frames that were rendered earlier: ``SCENE.npz``, ``SCENE.exr`` or ``SCENE/`` in a folder."""

    folder: Path
    claim: Claim
    name: str = "subject"
    most: float | None = None

    def missing(self) -> str | None:
        """Why there is nothing to judge; None where there is."""
        return None if self.folder.is_dir() else f"there is no folder {str(self.folder)!r}"

    def declare(self, scene: Scene) -> Declared:
        """The bounds that follow from its author's claim."""
        return declared(scene, self.claim, self.most)

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Read the scene's frame.

        Raises
        ------
        NoAnswer
            There is none, more than one, or it cannot be read.
        """
        name = scene.name
        if name in ("", ".", "..") or "/" in name or "\0" in name:
            raise NoAnswer("the scene's name is no file's", got=repr(name)[:80])
        found = [
            path
            for path in (self.folder / f"{name}{suffix}" for suffix in (".npz", ".exr", ""))
            if os.path.lexists(path)
        ]
        if len(found) == 1:
            return read_rendering(found[0], scene, f"frames in {self.folder.name}")
        raise NoAnswer(
            "more than one frame of the scene" if found else "no frame of the scene",
            where=str(self.folder), got=" and ".join(path.name for path in found),
            expected=f"{name}.npz, {name}.exr or {name}/",
        )  # fmt: skip


def read_rendering(path: Path, scene: Scene, program: str) -> Rendering:
    """Read the frame that a program left, without the quantities whose format is too coarse.

    Raises
    ------
    NoAnswer
        It cannot be read.
    """
    try:
        frame = read_frame(path, (scene.screen.ny, scene.screen.nx))
    except MinirtError as error:
        raise NoAnswer(
            error.what, where=path.name, got=error.got, expected=error.expected
        ) from None
    coarse = {
        name: "whole numbers of 8 or 16 bits are too coarse to compare: use .exr, .pfm or .npy"
        for name in frame
        if not QUANTITIES[name].discrete and path.is_dir() and _only_integers(path, name)
    }
    kept = {name: array for name, array in frame.items() if name not in coarse}
    return Rendering(Frame(kept, frame.meta), coarse, program)


def _only_integers(folder: Path, name: str) -> bool:
    kinds = {path.suffix.lower() for path in folder.iterdir() if path.stem == name}
    return bool(kinds) and kinds <= _INTEGERS
