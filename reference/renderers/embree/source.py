"""The Embree reference: minirt's own rays; Embree's hits on triangles, weights and normals."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from converters.placement import centered_placement
from minirt.frame import Frame
from minirt.rules import SLIDES
from minirt.scene import Scene
from minirt.vectors import column, unit
from minirt.whitted import primary_directions
from reference.renderers.embree.errors import declared
from reference.renderers.embree.rays import Embree, Engine
from reference.renderers.embree.secondary import SecondaryRays
from reference.renderers.embree.trimesh_rays import TrimeshEngine
from reference.renderers.embree.world import World
from reference.renderers.pixel_arrays import PixelArrays, Values, faceted
from reference.source import Declared, Rendering

_UNSUPPORTED = {
    "ray": "Embree has no camera: the rays are minirt's own",
    "color": "Embree does not shade",
    "alpha": "Embree has no materials",
}


@dataclass(frozen=True)
class EmbreeReference:
    """Embree through embreex or, without embreex, trimesh's own engine.

    Spheres, which Embree is not given, and the directions of secondary rays have formulas of the
    reference's own.
    """

    name: str = "embree"

    def missing(self) -> str | None:
        """None: trimesh is always there, and its engine needs nothing else."""
        return None

    def ingredients(self) -> tuple[str | Path | None, ...]:
        """Embree, and the engine that replaces it."""
        return "embreex", "trimesh"

    def declare(self, scene: Scene) -> Declared:
        """How it errs on this scene."""
        return declared(scene, centered_placement(scene))

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Render the scene; imports Embree, so only in a child process."""
        world = World(scene, centered_placement(scene), engine_here())
        return Rendering(Frame(_arrays(scene, world)), _UNSUPPORTED, world.program)


def engine_here() -> type[Engine]:
    """Embree, or trimesh's engine where embreex is missing."""
    return Embree if importlib.util.find_spec("embreex") else TrimeshEngine


def _arrays(scene: Scene, world: World) -> dict[str, Values]:
    """Every quantity of the frame."""
    placement, screen = world.placement, scene.screen
    d = unit(primary_directions(scene, SLIDES, np.arange(screen.nx * screen.ny)))
    P0 = np.broadcast_to(column(placement.points(np.array(screen.P0))), d.shape)
    found = world.first_hits(P0, d)
    hit = found.object >= 0
    pixels = PixelArrays(scene)
    pixels.put_hits(found.object, found.face, found.distance / placement.scale)
    pixels.put("position", placement.back(found.position.T).T, hit)
    pixels.put("barycentric", found.uv, faceted(scene, found.object))
    pixels.put("normal", found.normal, hit)
    SecondaryRays(scene, world, d, found).put(pixels)
    return pixels.arrays
