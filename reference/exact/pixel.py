"""The lecture's algorithm for some pixels, in ball arithmetic: S1–S6, S8–S12, S14–S16."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from minirt.scene import Scene
from minirt.screen import VirtualScreen
from reference.exact.balls import Ball, as_ball, blurred_by, each_blurred, known, rationals, unit
from reference.exact.optics import reflected, refracted
from reference.exact.primitives import ExactRay, Primitive, Solution
from reference.exact.shapes import Answer, Ray
from reference.exact.trace import FirstHit, Tracer

#: Quantities of every hit, and those of materials with an index of refraction.
AT_A_HIT = (
    "t", "position", "normal", "shadow", "reflection", "reflection_object", "reflection_t",
)  # fmt: skip
IN_GLASS = ("tir", "refraction", "refraction_object", "refraction_t")


@dataclass
class PixelAnswers:
    """The answers for one pixel: a value, a ball or balls by quantity; None where it is open.

    Attributes
    ----------
    values : dict
        Without the quantities that do not apply.
    solution : Solution or None
        The exact t and its condition number, if it is certain what is hit.
    """

    values: dict[str, Any] = field(default_factory=dict)
    solution: Solution | None = None

    def remove(self, *names: str) -> None:
        """Remove quantities that do not apply after all."""
        for name in names:
            self.values.pop(name)


@dataclass(frozen=True)
class _Point:
    """A surface point that is certain: the answers of its pixel, and where secondary rays start."""

    answers: PixelAnswers
    M: list[Ball]
    delta: list[Ball]
    normal: list[Ball]
    ior: float | None


def exact_pixels(scene: Scene, pixels: Sequence[tuple[int, int]]) -> list[PixelAnswers]:
    """The answers at pixels (row from the top, column)."""
    tracer = Tracer(scene)
    exact = [exact_ray(scene.screen, row, column) for row, column in pixels]
    rays = [Ray(known(scene.screen.P0), _seen_direction(ray), 0.0) for ray in exact]
    found = tracer.first(rays)
    answers = [PixelAnswers(_values(first)) for first in found]
    points = [
        _point(scene, pixel, whole, ray, first.primitive, first.t)
        for pixel, whole, ray, first in zip(answers, exact, rays, found, strict=True)
        if first.primitive is not None
    ]
    _put_shadows(scene, tracer, points)
    _put_branches(scene, tracer, "reflection", [(p, reflected(p.delta, p.normal)) for p in points])
    _put_refractions(scene, tracer, points)
    return answers


def exact_ray(screen: VirtualScreen, row: int, column: int) -> ExactRay:
    """The ray of a pixel from the scene's numbers, in rationals. Source: S1–S3, S5."""
    l, r, b, t, nu, half = rationals((screen.l, screen.r, screen.b, screen.t, screen.nu, 0.5))
    right = (r - l) / screen.nx * (column + half)
    up = (t - b) / screen.ny * (screen.ny - 1 - row + half)
    rows = list(zip(*(rationals(axis) for axis in (screen.u, screen.v, screen.n)), strict=True))
    d = [u * (l + right) + v * (b + up) + n * nu for u, v, n in rows]
    sizes = abs(l) + right, abs(b) + up, abs(nu)
    d_size = [sum(abs(x) * size for x, size in zip(axis, sizes, strict=True)) for axis in rows]
    return ExactRay(rationals(screen.P0), d, d_size)


def _seen_direction(ray: ExactRay) -> list[Ball]:
    """d as minirt uses it: within 4 ulp for computing it, and 4 for its use.

    minirt computes d with 7 roundings, each of 2⁻⁵³ of the sizes of its terms.
    """
    pairs = zip(ray.d, ray.d_size, strict=True)
    return [blurred_by(as_ball(x), as_ball(2 * size)) for x, size in pairs]


def _values(first: FirstHit) -> dict[str, Any]:
    """Values of a primary ray; at a hit all further quantities are open at first."""
    hit = {Answer.YES: True, Answer.NO: False, Answer.OPEN: None}[first.hit]
    values = {"hit": hit, "object": first.object, "triangle": first.face}
    return values if hit is False else values | dict.fromkeys(AT_A_HIT)


def _point(
    scene: Scene, pixel: PixelAnswers, exact: ExactRay, ray: Ray, primitive: Primitive, t: Ball
) -> _Point:
    """The point that a ray hits. Source: S5."""
    pixel.solution = primitive.solve(exact)
    M = [p + t * x for p, x in zip(ray.P0, ray.d, strict=True)]
    normal = primitive.normal_at(M)
    ior = scene.material_of(primitive.object).ior
    pixel.values |= {"t": t, "position": M, "normal": normal}
    if ior is not None:
        pixel.values |= dict.fromkeys(IN_GLASS)
    return _Point(pixel, M, unit(ray.d), normal, ior)


def _put_shadows(scene: Scene, tracer: Tracer, points: Sequence[_Point]) -> None:
    """RT(M, −l, ε, ∞). Source: S12."""
    to_light = each_blurred(unit([-as_ball(x) for x in rationals(scene.light_direction)]))
    rays = [Ray(each_blurred(point.M), to_light, scene.epsilon) for point in points]
    for point, dark in zip(points, tracer.occluded(rays), strict=True):
        shadow = {Answer.YES: 1, Answer.NO: 0, Answer.OPEN: None}[dark]
        point.answers.values["shadow"] = shadow


def _put_refractions(scene: Scene, tracer: Tracer, points: Sequence[_Point]) -> None:
    """ϱ, or total internal reflection, where there is an index of refraction. Source: S16."""
    passing = []
    for point in points:
        if point.ior is not None:
            total, direction = refracted(point.delta, point.normal, point.ior)
            point.answers.values["tir"] = None if total is None else int(total)
            if total:
                point.answers.remove("refraction", "refraction_t")
                point.answers.values["refraction_object"] = -1
            if direction is not None:
                passing.append((point, direction))
    _put_branches(scene, tracer, "refraction", passing)


def _put_branches(
    scene: Scene, tracer: Tracer, name: str, secondary: Sequence[tuple[_Point, list[Ball]]]
) -> None:
    """RT(M, direction, ε, ∞). Source: S14, S16."""
    rays = [Ray(each_blurred(p.M), each_blurred(d), scene.epsilon) for p, d in secondary]
    for (point, direction), first in zip(secondary, tracer.first(rays), strict=True):
        values = {name: direction, f"{name}_object": first.object, f"{name}_t": first.t}
        point.answers.values |= values
        if first.hit is Answer.NO:
            point.answers.remove(f"{name}_t")
