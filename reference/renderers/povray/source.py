"""The POV-Ray reference: analytic spheres in float64, and colours that follow the slides."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from converters.placement import Placement
from converters.povray.media import transparent_bodies
from converters.povray.scene import povray_scene, unsupported_colors
from converters.povray.shapes import povray_placement
from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from minirt.vectors import Ints
from reference.renderers.pixel_arrays import PixelArrays
from reference.renderers.povray import passes
from reference.renderers.povray.errors import coarse_color, declared, exposure_of
from reference.renderers.povray.media_lists import media_fault
from reference.renderers.povray.run import find_povray, povray_version, render_pictures
from reference.source import Declared, Rendering

_GIVEN = (
    "hit", "object", "triangle", "t", "depth", "distance", "position", "normal", "shadow", "color",
)  # fmt: skip
_BEYOND = "the pictures drawn by POV-Ray tell of first hits: rays beyond them show in its colours"
_REASONS = {
    "ray": "POV-Ray tells no directions: the positions of its hits lie along its rays",
    "barycentric": "POV-Ray's triangles have no barycentric coordinates",
    "alpha": "POV-Ray has no α that changes nothing else",
}


@dataclass(frozen=True)
class PovrayReference:
    """The `povray` program on five pictures of a scene: four that encode hits, and its colours."""

    name: str = "povray"

    def missing(self) -> str | None:
        """Why it cannot run here, with the command that would bring it; None where it can."""
        if find_povray() is None:
            return "POV-Ray is not installed: apt-get install povray"
        return None

    def ingredients(self) -> tuple[str | Path | None, ...]:
        """The program."""
        return (find_povray(),)

    def declare(self, scene: Scene) -> Declared:
        """How it errs on this scene."""
        return declared(scene, povray_placement(scene))

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Write the pictures' texts, run the program on all at once, read its images.

        Raises
        ------
        ReferenceError
            The program failed or took too long.
        """
        placement = povray_placement(scene)
        grid = passes.Grid.of(scene, placement)
        pictures = passes.pictures(scene, placement, grid)
        fault = _color_fault(scene)
        if fault is None:
            pictures["color"] = povray_scene(scene, exposure_of(scene))
        codes = render_pictures(pictures, scene.screen, scratch)
        frame = _frame(scene, placement, grid, codes)
        reasons = {name: _REASONS.get(name, _BEYOND) for name in QUANTITIES}
        if fault is not None:
            reasons["color"] = fault
        unsupported = {name: reason for name, reason in reasons.items() if name not in frame}
        return Rendering(frame, unsupported, povray_version())


def _color_fault(scene: Scene) -> str | None:
    """Why this scene's colours are not asked for; None where they are."""
    faults = unsupported_colors(scene) or [fault for fault in (coarse_color(scene),) if fault]
    return faults[0] if faults else media_fault(scene, transparent_bodies(scene))


def _frame(scene: Scene, placement: Placement, grid: passes.Grid, codes: dict[str, Ints]) -> Frame:
    """In minirt's conventions."""
    number, face, outside, lit = passes.read_what(scene, codes["what"])
    hit = number >= 0
    position = placement.back(grid.position(codes["where-1"], codes["where-2"]))
    ray = position - np.array(scene.screen.P0)
    pixels = PixelArrays(scene)
    pixels.put_hits(number, face, np.sqrt((ray * ray).sum(axis=1)))
    pixels.put("position", position.T, hit)
    pixels.put("normal", passes.read_normal(codes["normal"], outside).T, hit)
    pixels.put("shadow", ~lit, hit)
    if "color" in codes:
        color = codes["color"] / (passes.WHITE * exposure_of(scene))
        pixels.put("color", color.T, np.ones_like(hit))
    return Frame(pixels.arrays)
