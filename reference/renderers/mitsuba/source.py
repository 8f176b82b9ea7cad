"""Mitsuba 3 through its Python interface: its camera, hits, normals and secondary rays."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from converters.mitsuba.materials import is_exact
from converters.mitsuba.scene import unsupported_camera
from converters.placement import fitted_placement
from minirt.frame import Frame
from minirt.scene import Scene
from minirt.screen import image_pixels
from minirt.vectors import Floats
from reference.renderers.mitsuba import trace as columns
from reference.renderers.mitsuba.errors import declared
from reference.renderers.mitsuba.frame import frame_arrays
from reference.renderers.mitsuba.llvm import find_llvm
from reference.renderers.mitsuba.trace import World, bounce, primary
from reference.renderers.mitsuba.world import load_world, run, start
from reference.source import Declared, Rendering, Unsupported

_NAMES = {"mitsuba-llvm": "llvm_ad_rgb", "mitsuba-scalar": "scalar_rgb"}
#: Why no route through Mitsuba gives α.
NO_ALPHA = "Mitsuba's materials have no α: its own alpha says whether anything was hit"
_INSTALL = "pip install 'minirt[mitsuba]'"


@dataclass(frozen=True)
class MitsubaReference:
    """Mitsuba's geometry and, where its light transport is the slides' own, its colours.

    Attributes
    ----------
    name : str
        ``mitsuba-llvm``: all pixels at once, needs a libLLVM ≥ 18; ``mitsuba-scalar``: pixel by
        pixel, needs none.
    """

    name: str = "mitsuba-llvm"

    @property
    def variant(self) -> str:
        """Mitsuba's name of the variant."""
        return _NAMES[self.name]

    def missing(self) -> str | None:
        """Why it cannot run here, with the command that would bring it; None where it can."""
        if importlib.util.find_spec("mitsuba") is None:
            return f"Mitsuba is not installed: {_INSTALL}"
        if self.variant.startswith("llvm") and find_llvm() is None:
            return "no libLLVM of version 18 or newer: pip install karellen-llvm-core==18.1.8.0"
        return None

    def ingredients(self) -> tuple[str | Path | None, ...]:
        """Mitsuba, its compiler and, for a vectorised variant, LLVM."""
        return "mitsuba", "drjit", find_llvm() if self.variant.startswith("llvm") else None

    def declare(self, scene: Scene) -> Declared:
        """How it errs on this scene."""
        return declared(scene, fitted_placement(scene))

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Render the scene; imports Mitsuba, so only in a child process.

        Raises
        ------
        Unsupported
            Pixels that are not square.
        """
        fault = unsupported_camera(scene.screen)
        if fault:
            raise Unsupported(fault)
        mi, dr = start(self.variant)
        placement = fitted_placement(scene)
        world = load_world(mi, dr, scene, scratch, placement)
        answers = run(world, primary, _pixel_positions(scene))
        arrays = frame_arrays(scene, placement, answers)
        unsupported = {"alpha": NO_ALPHA}
        faults = unsupported_colors(scene)
        if faults:
            unsupported["color"] = "; ".join(faults)
        else:
            first = answers[columns.ORIGIN], answers[columns.DIRECTION]
            arrays["color"] = _color(world, scene, np.concatenate(first))
        return Rendering(Frame(arrays), unsupported, f"Mitsuba {mi.__version__} {self.variant}")


def unsupported_colors(scene: Scene) -> list[str]:
    """Every reason why Mitsuba's colours are not the slides' on this scene; none where they are."""
    faults = []
    if any(scene.background):
        faults.append("in Mitsuba a background that is not black lights the objects")
    if scene.shadow_color is not None and any(scene.shadow_color):
        faults.append("Mitsuba has no colour of shadows")
    used = sorted({thing.material for thing in scene.objects})
    inexact = ", ".join(repr(name) for name in used if not is_exact(scene.materials[name]))
    if inexact:
        why = "Mitsuba's radiance is the slides' for pure diffuse and pure mirrors only"
        faults.append(f"{why}, not for {inexact}")
    return faults


def _pixel_positions(scene: Scene) -> tuple[Floats, Floats]:
    """Centres of the pixels in [0, 1]² from the upper left corner, top row first."""
    screen = scene.screen
    i, j = image_pixels(screen, np.arange(screen.nx * screen.ny))
    return (i + 0.5) / screen.nx, (screen.ny - 0.5 - j) / screen.ny


def _color(world: World, scene: Scene, rays: Floats) -> Any:
    """Radiance along rays (6, n), as an image: one bounce a generation, S7 and S13."""
    color = np.zeros((3, rays.shape[1]))
    share, pixels = np.ones_like(color), np.arange(rays.shape[1])
    for _ in range(scene.max_depth + 1):
        if not len(pixels):
            break
        answers = run(world, bounce, list(rays))
        color[:, pixels] += share * answers[columns.RADIANCE]
        going = answers[columns.MIRRORED] == 1
        share, pixels = (share * answers[columns.SHARE])[:, going], pixels[going]
        rays = answers[columns.SPAWNED][:, going]
    return np.ascontiguousarray(color.T).reshape(scene.screen.ny, scene.screen.nx, 3)
