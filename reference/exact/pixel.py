"""The lecture's algorithm for some pixels of a scene, in balls: S1–S6, S8–S12, S14–S16."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from minirt.scene import Scene
from minirt.screen import VirtualScreen
from reference.exact.balls import Ball, as_ball, blurred_by, each_blurred, known, rationals, unit
from reference.exact.leaving import reflected, refracted
from reference.exact.primitives import ExactRay, Primitive, Solution
from reference.exact.shapes import Answer, Ray
from reference.exact.trace import First, Tracer

#: Quantities that every hit has, and those of materials with an index of refraction.
AT_A_HIT = (
    "t", "position", "normal", "shadow", "reflection", "reflection_object", "reflection_t",
)  # fmt: skip
IN_GLASS = ("tir", "refraction", "refraction_object", "refraction_t")


@dataclass
class PixelAnswers:
    """What is known of one pixel: a value, a ball or balls by quantity; None where it is open.

    Attributes
    ----------
    values : dict
        Quantities that do not apply are not in it.
    solution : Solution or None
        The exact t and its condition, where it is certain what is met.
    """

    values: dict[str, Any] = field(default_factory=dict)
    solution: Solution | None = None

    def leave_out(self, *names: str) -> None:
        """These quantities do not apply after all."""
        for name in names:
            self.values.pop(name)


@dataclass(frozen=True)
class _Point:
    """A surface point that is known: pixel's answers, and what leaves from it starts here."""

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
    """d as a kernel sees it: give or take 4 ulp for making it, and 4 for using it.

    minirt makes d with 7 roundings, of 2⁻⁵³ of the sizes of its terms each.
    """
    pairs = zip(ray.d, ray.d_size, strict=True)
    return [blurred_by(as_ball(x), as_ball(2 * size)) for x, size in pairs]


def _values(first: First) -> dict[str, Any]:
    """Of a primary ray; at a hit every quantity that follows is open until it is known."""
    hit = {Answer.YES: True, Answer.NO: False, Answer.OPEN: None}[first.hit]
    values = {"hit": hit, "object": first.object, "triangle": first.face}
    return values if hit is False else values | dict.fromkeys(AT_A_HIT)


def _point(
    scene: Scene, pixel: PixelAnswers, exact: ExactRay, ray: Ray, primitive: Primitive, t: Ball
) -> _Point:
    """The point that a ray meets. Source: S5."""
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
    """ϱ where there is an index of refraction, or total internal reflection. Source: S16."""
    passing = []
    for point in points:
        if point.ior is not None:
            total, direction = refracted(point.delta, point.normal, point.ior)
            point.answers.values["tir"] = None if total is None else int(total)
            if total:
                point.answers.leave_out("refraction", "refraction_t")
                point.answers.values["refraction_object"] = -1
            if direction is not None:
                passing.append((point, direction))
    _put_branches(scene, tracer, "refraction", passing)


def _put_branches(
    scene: Scene, tracer: Tracer, name: str, leaving: Sequence[tuple[_Point, list[Ball]]]
) -> None:
    """RT(M, direction, ε, ∞). Source: S14, S16."""
    rays = [Ray(each_blurred(p.M), each_blurred(d), scene.epsilon) for p, d in leaving]
    for (point, direction), first in zip(leaving, tracer.first(rays), strict=True):
        values = {name: direction, f"{name}_object": first.object, f"{name}_t": first.t}
        point.answers.values |= values
        if first.hit is Answer.NO:
            point.answers.leave_out(f"{name}_t")
