"""Nested media: POV-Ray's indices of refraction for a scene's transparent bodies.

minirt looks at the surface alone: a ray that hits its outside goes from 1 to ior, one that hits
its inside from ior to 1, whatever is around. POV-Ray keeps a list of the interiors that a ray is
in and takes the quotient of the last one's index and the next one's. The two agree where bodies
are disjoint or strictly nested, and POV-Ray's index of each is the product of the `ior` of all
bodies that it lies in. Whether this holds for the rays of a scene is checked in `reference`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from minirt.scene import Object, Scene, Sphere
from minirt.vectors import Floats, column, cross, dot, norm

#: An observer who sees a surface's inside under more than this share of 4π is inside the body.
_INSIDE = 1 / 16


@dataclass(frozen=True)
class Body:
    """Transparent objects that share an interior: a sphere, or all facets of one material.

    Attributes
    ----------
    objects : tuple of int
        Numbers of the objects.
    index : float
        POV-Ray's index of refraction.
    """

    objects: tuple[int, ...]
    index: float


def transparent_bodies(scene: Scene) -> tuple[Body, ...]:
    """The transparent bodies of a scene, each with its index in POV-Ray.

    Its list of interiors is empty at the observer (see `converters.povray.shapes`), so that the
    index there is 1. A body that contains the observer is entered, for POV-Ray, where a ray leaves
    it: the index behind its surface is 1/ior of the index before it.
    """
    groups = _groups(scene)
    turned = [_contains(scene, group, np.array(scene.screen.P0)) for group in groups]
    bodies = []
    for group in groups:
        index, point = 1.0, _surface_point(scene.objects[group[0]])
        for other, out in zip(groups, turned, strict=True):
            behind = out != (other is group or _contains(scene, other, point))
            if other is group and out:
                index /= _ior(scene, other)
            elif behind:
                index *= 1 / _ior(scene, other) if out else _ior(scene, other)
        bodies.append(Body(group, index))
    return tuple(bodies)


def _groups(scene: Scene) -> list[tuple[int, ...]]:
    spheres: list[tuple[int, ...]] = []
    facets: dict[str, tuple[int, ...]] = {}
    for number, thing in enumerate(scene.objects):
        if scene.material_of(number).transmittance == 0:
            continue
        if isinstance(thing, Sphere):
            spheres.append((number,))
        else:
            facets[thing.material] = (*facets.get(thing.material, ()), number)
    return [*spheres, *facets.values()]


def _ior(scene: Scene, group: tuple[int, ...]) -> float:
    return scene.material_of(group[0]).ior or 1.0


def _surface_point(thing: Object) -> Floats:
    if isinstance(thing, Sphere):
        return np.asarray(thing.center + np.array([thing.radius, 0.0, 0.0]))
    return np.asarray(thing.vertices[0])


def _contains(scene: Scene, group: tuple[int, ...], point: Floats) -> bool:
    """Whether a point is in a body: in its sphere, or where it sees its facets from inside."""
    things = [scene.objects[number] for number in group]
    inside = 0.0
    for thing in things:
        if isinstance(thing, Sphere):
            return float(norm(thing.center - point)) < thing.radius
        inside += _solid_angle(*(corner - column(point) for corner in thing.corners))
    return inside > _INSIDE * 4 * math.pi


def _solid_angle(a: Floats, b: Floats, c: Floats) -> float:
    """The solid angle of triangles (3, m) seen from the origin, positive from behind.

    Source: A. Van Oosterom, J. Strackee 1983, doi:10.1109/TBME.1983.325207.
    """
    A, B, C = norm(a), norm(b), norm(c)
    volume = dot(a, cross(b, c))
    angle = np.arctan2(volume, A * B * C + dot(a, b) * C + dot(a, c) * B + dot(b, c) * A)
    return 2 * float(angle.sum())
