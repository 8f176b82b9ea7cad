"""A scene as what pyrender needs: triangles and a camera, as plain arrays and numbers.

Nothing here imports pyrender. Its camera is OpenGL's: it sits at the origin, x to the right, y
up, and looks along −z. Everything is handed over in the observer's own coordinates,
((p − P0)·u, (p − P0)·v, −sign(ν)·(p − P0)·n), computed in float64 and scaled by a power of two.
So all of pyrender's poses are the identity, and float32 resolves distances from the observer
equally well whatever the frame's handedness, ν's sign, or the scene's place and size.

pyrender culls back faces in its segmentation pass, whatever its flags say. So every face is wound
counter-clockwise as the observer sees it. Faces without an area are left out: they are never hit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from converters.tessellate import TRIANGLES, Icosphere, icosphere_within
from minirt.scene import Object, Scene, Sphere
from minirt.screen import VirtualScreen
from minirt.vectors import Bools, Floats, Ints, column, cross, dot, norm

#: Most triangles for all spheres of a scene together, and for one of them.
TRIANGLE_BUDGET, MAX_PER_SPHERE = 1_500_000, 500_000
#: Finest and coarsest error of a sphere, in pixels at its nearest point.
FINEST, COARSEST = 1 / 128, 1 / 16
#: Least near/far: below it a depth buffer of 24 bits resolves hardly anything.
LEAST_NEAR = 2.0**-14
#: Margin between the clipping planes and what they must not clip: far above every rounding.
_MARGIN = 2.0**-10


@dataclass(frozen=True)
class Camera:
    """pyrender's `IntrinsicsCamera` at the origin: lengths in pixels, planes in its coordinates.

    Source: S1, S2.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    znear: float
    zfar: float


@dataclass(frozen=True, eq=False)
class Part:
    """One object's triangles: vertices (k, 3) float64 of the camera, faces (m, 3) int32."""

    object: int
    vertices: Floats
    faces: Ints


@lru_cache(maxsize=1)
def pyrender_scene(scene: Scene) -> PyrenderScene:
    """A scene for pyrender; the latest is cached, since it is needed to declare and to draw."""
    return PyrenderScene(scene)


class PyrenderScene:
    """A scene in the coordinates of pyrender's camera.

    Parameters
    ----------
    scene : Scene

    Attributes
    ----------
    scale : float
        A power of two: pyrender's lengths are this times the scene's.
    pixel : float
        The wider side of a pixel over its distance from the observer.
    """

    def __init__(self, scene: Scene) -> None:
        screen = scene.screen
        self.scene = scene
        self.scale = 2.0 ** (6 - math.frexp(scene.extent)[1])
        width, height = (screen.r - screen.l) / screen.nx, (screen.t - screen.b) / screen.ny
        self.pixel = max(width, height) / abs(screen.nu)

    def points(self, points: Floats) -> Floats:
        """Points (k, 3) of the scene in the camera's coordinates, float64."""
        screen = self.scene.screen
        towards = (points - np.array(screen.P0)).T
        forward = math.copysign(self.scale, screen.nu)
        x, y, z = (dot(towards, column(axis)) for axis in (screen.u, screen.v, screen.n))
        return np.stack((self.scale * x, self.scale * y, -forward * z), axis=1)

    @cached_property
    def icospheres(self) -> dict[int, Icosphere]:
        """The polyhedron of each sphere, by the object's number.

        The error of each, seen by the observer, is the same small part of a pixel: as small as
        the budget of triangles allows, between `FINEST` and `COARSEST`.
        """
        bounds = {k: self.pixel * self._clearance(s) / s.radius for k, s in self._spheres()}
        cost = sum(TRIANGLES / bound for bound in bounds.values() if bound)
        part = min(max(cost / TRIANGLE_BUDGET, FINEST), COARSEST)
        return {k: icosphere_within(part * bound, MAX_PER_SPHERE) for k, bound in bounds.items()}

    def chord_errors(self) -> Iterator[tuple[float, float]]:
        """For each sphere: the error of its triangles, and the least distance from the observer.

        Both are in scene units.
        """
        for k, sphere in self._spheres():
            yield sphere.radius * self.icospheres[k].error, self._clearance(sphere)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """Every object that has a face with an area, in the scene's order."""
        turned = (_turned(k, *self._triangles(k, o)) for k, o in enumerate(self.scene.objects))
        return tuple(part for part in turned if len(part.faces))

    @cached_property
    def camera(self) -> Camera:
        """The camera; its near and far planes enclose all that is in view, tightly."""
        screen = self.scene.screen
        near, far = self._depths()
        across, up = screen.nx / (screen.r - screen.l), screen.ny / (screen.t - screen.b)
        nu = abs(screen.nu)
        return Camera(nu * across, nu * up, -screen.l * across, screen.t * up, near, far)

    def _spheres(self) -> Iterator[tuple[int, Sphere]]:
        for number, thing in enumerate(self.scene.objects):
            if isinstance(thing, Sphere):
                yield number, thing

    def _clearance(self, sphere: Sphere) -> float:
        """Distance of the observer from a sphere's surface, in scene units."""
        return abs(float(norm(sphere.center - np.array(self.scene.screen.P0))) - sphere.radius)

    def _triangles(self, number: int, thing: Object) -> tuple[Floats, Ints]:
        if not isinstance(thing, Sphere):
            return self.points(thing.vertices), thing.faces
        icosphere = self.icospheres[number]
        center = self.points(thing.center[None])
        return icosphere.around(center, self.scale * thing.radius), icosphere.faces

    def _depths(self) -> tuple[float, float]:
        """Near and far plane: what is in view lies between them; (1, 2) where nothing is."""
        corners = _corners(self.scene.screen)
        ranges = [_depth_range(part, corners) for part in self.parts]
        near = min((low for low, _ in ranges), default=math.inf)
        far = max((high for _, high in ranges), default=0.0)
        if far <= 0:
            return 1.0, 2.0
        return near * (1 - _MARGIN), far * (1 + _MARGIN)


def _turned(number: int, vertices: Floats, faces: Ints) -> Part:
    """The part with its faces wound counter-clockwise for the observer, without those of no area.

    The observer is at the origin: a face shows its front where (b − a) × (c − a) points to it.
    """
    a, b, c = (vertices[faces[:, k]].T for k in range(3))
    away = dot(a, cross(b - a, c - a))
    turned = np.where((away > 0)[:, None], faces[:, ::-1], faces)
    return Part(number, vertices, turned[away != 0])


def _corners(screen: VirtualScreen) -> Floats:
    """The screen's corners at depth 1 from the observer, (3, 4)."""
    sides = [(x, y) for x in (screen.l, screen.r) for y in (screen.b, screen.t)]
    x, y = np.array(sides).T / abs(screen.nu)
    return np.stack((x, y, -np.ones(4)))


def _depth_range(part: Part, corners: Floats) -> tuple[float, float]:
    """Bounds on the depths at which a part's faces are in view; (+inf, 0) where none is.

    A face is nowhere nearer than its nearest vertex, nor than its plane is within the screen.
    1/depth of a plane is linear over the screen, (d·N)/(a·N) for the ray d that has depth 1: it
    is largest at one of the corners.
    """
    a, b, c = (part.vertices[part.faces[:, k]].T for k in range(3))
    N = cross(b - a, c - a)
    nearest = np.minimum(np.minimum(-a[2], -b[2]), -c[2])
    farthest = np.maximum(np.maximum(-a[2], -b[2]), -c[2])
    with np.errstate(divide="ignore"):
        inverse = (dot(N[:, :, None], corners[:, None]) / dot(a, N)[:, None]).max(axis=1)
        near = np.maximum(nearest, np.where(inverse > 0, 1.0 / inverse, np.inf))
    seen = (farthest > 0) & (inverse > 0) & ~_outside_frustum(a, b, c, corners)
    if not seen.any():
        return math.inf, 0.0
    return float(near[seen].min()), float(farthest[seen].max())


def _outside_frustum(a: Floats, b: Floats, c: Floats, corners: Floats) -> Bools:
    """Whether all three corners of a face lie outside the same side of the view frustum."""
    left, right = corners[0].min(), corners[0].max()
    low, high = corners[1].min(), corners[1].max()
    beyond = [
        [p[0] < -left * p[2], p[0] > -right * p[2], p[1] < -low * p[2], p[1] > -high * p[2]]
        for p in (a, b, c)
    ]
    beyond_all: Bools = np.logical_and.reduce(beyond).any(axis=0)
    return beyond_all
