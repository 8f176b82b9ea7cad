"""Mitsuba's own command on an exported scene: the first hits, by its `aov` integrator."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from converters.frames.images import open_image
from converters.mitsuba.scene import export_mitsuba, near_clip, unsupported_camera
from converters.placement import Placement, fitted_placement
from minirt.errors import InputError, ReferenceError
from minirt.frame import Frame
from minirt.scene import Scene
from minirt.vectors import Floats
from reference.renderers.mitsuba.errors import declared
from reference.renderers.mitsuba.source import NO_ALPHA
from reference.renderers.pixel_arrays import PixelArrays, direction_lengths, faceted
from reference.source import Declared, Rendering, Unsupported

#: Seconds for one image. An object costs the integrator some 50 ns a pixel: 1,000 of them on a
#: million pixels take a minute.
TIMEOUT = 600.0

_AOVS = (
    "distance:depth,position:position,normal:geo_normal,object:shape_index,face:prim_index,uv:uv"
)
_UNSUPPORTED = {
    "ray": "Mitsuba's aov integrator has no channel for the ray",
    "color": "Mitsuba's aov integrator gives no colour of its own",
    "alpha": NO_ALPHA,
} | dict.fromkeys(
    (
        "shadow", "reflection", "reflection_object", "reflection_t",
        "tir", "refraction", "refraction_object", "refraction_t",
    ),
    "Mitsuba's aov integrator follows no ray beyond the first hit",
)  # fmt: skip


@dataclass(frozen=True)
class MitsubaCommand:
    """Mitsuba through its command and exported files only, as a user without Python has it."""

    name: str = "mitsuba-cli"

    def missing(self) -> str | None:
        """Why it cannot run here, with the command that would bring it; None where it can."""
        if find_command() is None:
            return "Mitsuba's command is not installed: pip install 'minirt[mitsuba]'"
        return None

    def ingredients(self) -> tuple[str | Path | None, ...]:
        """Mitsuba and its command."""
        return "mitsuba", "drjit", find_command()

    def declare(self, scene: Scene) -> Declared:
        """How it errs on this scene: as Mitsuba does."""
        return declared(scene, fitted_placement(scene))

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Export the scene, run the command, read its image.

        Raises
        ------
        Unsupported
            Pixels that are not square.
        ReferenceError
            The command failed or took too long.
        """
        fault = unsupported_camera(scene.screen)
        if fault:
            raise Unsupported(fault)
        image = scratch / "aov.exr"
        _run(export_aov(scene, scratch / "export"), image)
        frame = read_aov(scene, image)
        return Rendering(frame, _UNSUPPORTED, f"{_version()} scalar_rgb (command)")


def export_aov(scene: Scene, folder: Path) -> Path:
    """Export the scene with the integrator that outputs hits; return its XML file."""
    export_mitsuba(scene, folder, fitted_placement(scene), {"type": "aov", "aovs": _AOVS})
    return folder / "scene.xml"


def read_aov(scene: Scene, image: Path) -> Frame:
    """The image that Mitsuba's command has written of that scene, in minirt's conventions.

    Raises
    ------
    ReferenceError
        It cannot be used.
    """
    return _frame(scene, fitted_placement(scene), _channels(image, scene))


def find_command() -> Path | None:
    """Mitsuba's executable: the one in its Python package, else one on the search path."""
    package = importlib.util.find_spec("mitsuba")
    if package is not None and package.origin is not None:
        inside = Path(package.origin).parent / "mitsuba"
        if inside.is_file():
            return inside
    found = shutil.which("mitsuba")
    return Path(found) if found else None


def _run(scene: Path, image: Path) -> None:
    command = [str(find_command()), "-m", "scalar_rgb", str(scene), "-o", str(image)]
    try:
        result = subprocess.run(
            command, capture_output=True, text=True, errors="replace", timeout=TIMEOUT
        )
    except subprocess.TimeoutExpired:
        raise ReferenceError(f"Mitsuba's command took more than {TIMEOUT:g} s") from None
    if result.returncode != 0 or not image.is_file():
        raise ReferenceError(
            f"Mitsuba's command ended with status {result.returncode}",
            got=(result.stdout + result.stderr)[-2000:].strip(),
        )


@cache
def _version() -> str:
    """The first line of the command's help: name and version."""
    result = subprocess.run(
        [str(find_command()), "--help"], capture_output=True, text=True, timeout=TIMEOUT
    )
    return result.stdout.partition(" (")[0].strip()


def _channels(path: Path, scene: Scene) -> dict[str, Floats]:
    """The image's channels by name, each (ny·nx,) float64, top row first."""
    try:
        with open_image(path, (scene.screen.ny, scene.screen.nx)) as image:
            blocks = [np.stack(planes).astype(np.float64) for _, planes in image.blocks()]
            values = np.concatenate(blocks, axis=1).reshape(len(image.channels), -1)
            return dict(zip(image.channels, values, strict=True))
    except InputError as error:
        raise ReferenceError("Mitsuba's image cannot be used", got=str(error)) from None


def _frame(scene: Scene, placement: Placement, channels: dict[str, Floats]) -> Frame:
    """In minirt's conventions; `shape_index` counts from 1 and is 0 where nothing is hit."""
    number = channels["object.I"].astype(np.int32) - 1
    hit = number >= 0
    start = near_clip(scene, placement) * direction_lengths(scene.screen) / abs(scene.screen.nu)
    pixels = PixelArrays(scene)
    pixels.put_hits(
        number,
        channels["face.I"].astype(np.int32),
        (start + channels["distance.T"]) / placement.scale,
    )
    position = np.stack([channels[f"position.{axis}"] for axis in "XYZ"])
    pixels.put("position", placement.back(position.T).T, hit)
    uv = np.stack([channels["uv.U"], channels["uv.V"]])  # on triangles without a texture: (β, γ)
    pixels.put("barycentric", uv, faceted(scene, number))
    pixels.put("normal", np.stack([channels[f"normal.{axis}"] for axis in "XYZ"]), hit)
    return Frame(pixels.arrays)
