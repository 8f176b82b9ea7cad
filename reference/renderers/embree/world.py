"""A scene for Embree: its triangles, and its spheres beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from converters.placement import Placement
from minirt.scene import Facets, Scene, Sphere
from minirt.vectors import Bools, Floats, Ints
from reference.renderers.embree.rays import Engine
from reference.renderers.embree.sphere_rays import SphereSet


@dataclass(frozen=True, eq=False)
class FirstHits:
    """The first hits of n rays, in the renderer's coordinates.

    Attributes
    ----------
    object, face : (n,) int32
        −1 for none; the face of a sphere is 0.
    distance : (n,) float64
        Along the unit direction; +inf for none.
    position, normal : (3, n) float64
        Undefined where nothing is hit.
    uv : (2, n) float64
        Weights of the second and third corner; undefined on spheres.
    """

    object: Ints
    face: Ints
    distance: Floats
    position: Floats
    normal: Floats
    uv: Floats


class World:
    """Everything that a ray can hit.

    Parameters
    ----------
    scene : Scene
    placement : Placement
        The extent is at most 1 in it.
    engine
        Called with triangles (m, 3, 3): triangle, corner, coordinate.
    """

    def __init__(self, scene: Scene, placement: Placement, engine: type[Engine]) -> None:
        corners, objects, faces, spheres = [np.zeros((0, 3, 3))], [], [], []
        for number, thing in enumerate(scene.objects):
            if isinstance(thing, Facets):
                corners.append(placement.points(thing.vertices)[thing.faces])
                objects.append(np.full(len(thing.faces), number, dtype=np.int32))
                faces.append(np.arange(len(thing.faces), dtype=np.int32))
            else:
                spheres.append((number, thing))
        none = np.array([-1], dtype=np.int32)
        self._object, self._face = np.concatenate([*objects, none]), np.concatenate([*faces, none])
        self._engine, self._spheres = engine(np.concatenate(corners)), _spheres(spheres, placement)
        self._sphere_object = np.array([number for number, _ in spheres], dtype=np.int32)
        self.placement = placement
        self.program = self._engine.program + ("; spheres in closed form" if spheres else "")

    def first_hits(self, origins: Floats, directions: Floats) -> FirstHits:
        """First hits of rays (3, n) with unit directions."""
        met = self._engine.nearest(origins, directions)
        ball, away = self._spheres.nearest(origins, directions)
        object_, face, normal = self._object[met.triangle], self._face[met.triangle], met.normal
        distance = np.minimum(away, met.distance)
        position = origins + np.where(np.isfinite(distance), distance, 0.0) * directions
        curved = np.flatnonzero(away < met.distance)
        ball = ball[curved]
        object_[curved], face[curved] = self._sphere_object[ball], 0
        outward = position[:, curved] - self._spheres.center[:, ball]
        normal[:, curved] = outward / self._spheres.radius[ball]
        return FirstHits(object_, face, distance, position, normal, met.uv)

    def occluded(self, origins: Floats, directions: Floats) -> Bools:
        """Whether rays (3, n) hit anything, (n,)."""
        dark = self._engine.occluded(origins, directions)
        dark[~dark] = self._spheres.nearest(origins[:, ~dark], directions[:, ~dark])[0] >= 0
        return dark


def _spheres(found: list[tuple[int, Sphere]], placement: Placement) -> SphereSet:
    center = np.array([thing.center for _, thing in found], dtype=np.float64).reshape(-1, 3)
    radius = np.array([placement.length(thing.radius) for _, thing in found], dtype=np.float64)
    return SphereSet(np.ascontiguousarray(placement.points(center).T), radius)
