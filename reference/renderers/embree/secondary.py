"""Secondary rays, by formulas that are used nowhere else, and what they hit.

None of minirt's rules is used, so that a mistake in one of them shows. A ray is split into its
components along the surface and along the normal: a mirror reverses the second one, Snell's law
scales the first by ν/ν_t.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from minirt.scene import Scene
from minirt.vectors import Bools, Floats, column, dot, norm, unit
from reference.renderers.embree.errors import START_OFFSET
from reference.renderers.embree.world import FirstHits, World
from reference.renderers.pixel_arrays import PixelArrays, indexed


@dataclass(frozen=True, eq=False)
class SecondaryRays:
    """The secondary rays at the first hits of an image.

    Attributes
    ----------
    scene : Scene
    world : World
    delta : (3, n) float64
        Unit directions of the rays that arrived.
    found : FirstHits
        Where those rays hit.
    """

    scene: Scene
    world: World
    delta: Floats
    found: FirstHits

    def put(self, pixels: PixelArrays) -> None:
        """Shadow, reflection and refraction of every pixel."""
        scene, number = self.scene, self.found.object
        hit, glassy = number >= 0, indexed(scene, number)
        to_light = -column(scene.light_direction)
        direction = np.broadcast_to(to_light / norm(to_light), self.delta.shape)
        dark, start = np.zeros_like(hit), self._started(direction)
        dark[hit] = self.world.occluded(start[:, hit], direction[:, hit])
        pixels.put("shadow", dark, hit)
        self._put_branch(pixels, "reflection", mirrored(self.delta, self.found.normal), hit)
        ior = [scene.materials[thing.material].ior or 1.0 for thing in scene.objects]
        direction = refracted(self.delta, self.found.normal, np.array([*ior, 1.0])[number])
        total = np.isnan(direction[0])
        pixels.put("tir", total, glassy)
        self._put_branch(pixels, "refraction", direction, glassy & ~total)

    def _put_branch(self, pixels: PixelArrays, name: str, direction: Floats, where: Bools) -> None:
        """The direction of a secondary ray and what it hits, measured from the surface."""
        start = self._started(direction)
        onward = self.world.first_hits(start[:, where], direction[:, where])
        number, length = np.full(where.shape, -1, dtype=np.int32), np.full(where.shape, np.inf)
        number[where], length[where] = onward.object, onward.distance
        length += dot(start - self.found.position, direction)
        pixels.put(name, direction, where)
        pixels.put(f"{name}_object", number, number >= 0)
        pixels.put(f"{name}_t", length / self.world.placement.scale, number >= 0)

    def _started(self, direction: Floats) -> Floats:
        """Starting points of rays (3, n): off the surface, on the side to which the rays go."""
        M, normal = self.found.position, self.found.normal
        offset = START_OFFSET * (1.0 + np.abs(M).max(axis=0))
        start: Floats = M + np.copysign(offset, dot(normal, direction)) * normal
        return start


def mirrored(delta: Floats, normal: Floats) -> Floats:
    """Unit directions (3, n) of the reflected rays."""
    across = dot(delta, normal) * normal
    return unit((delta - across) - across)


def refracted(delta: Floats, normal: Floats, ior: Floats) -> Floats:
    """Unit directions (3, n) of the refracted rays; NaN at total internal reflection.

    Parameters
    ----------
    delta, normal : (3, n) float64
        Unit.
    ior : (n,) float64
        Index of what lies behind the normal, relative to what lies before it.
    """
    cosine = dot(delta, normal)
    bent = np.where(cosine < 0, 1.0 / ior, ior) * (delta - cosine * normal)
    with np.errstate(invalid="ignore"):
        left = np.sqrt(1.0 - dot(bent, bent))
    return bent + np.copysign(left, cosine) * normal
