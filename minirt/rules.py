"""The lecture's rules S1–S16 as one record of pure functions, each of which can be replaced.

`render` takes every step of the algorithm from such a record. `SLIDES` holds the lecture's own
rules; a harness that wants to know whether it would notice a mistake hands over a record with
that one mistake in it: ``SLIDES.replace(refract=my_wrong_refraction)``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from minirt import optics, screen, shading
from minirt.errors import InputError
from minirt.rule_types import (
    CloserRule,
    CombineRule,
    DepthRule,
    DistanceRule,
    FaceNormalRule,
    IlluminateRule,
    IndicesRule,
    IntervalRule,
    ModelFromViewRule,
    PixelCenterRule,
    PlaneRule,
    PointAtRule,
    PolygonRule,
    RayDirectionRule,
    ReflectRule,
    RefractRule,
    ShadowColorRule,
    SmallestRootRule,
    SphereNormalRule,
    SphereRule,
    StartRule,
    ToLightRule,
    TowardViewerRule,
    TriangleRule,
    ViewFrameRule,
)
from minirt.shapes.plane import plane_normal, plane_t
from minirt.shapes.polygon import polygon_hit
from minirt.shapes.sphere import sphere_normal, sphere_roots
from minirt.shapes.triangle import triangle_hit
from minirt.vectors import Bools, Floats, Ints, dot, norm


def closer(
    t: Floats, object_: Ints, triangle_: Ints,
    best_t: Floats, best_object: Ints, best_triangle: Ints,
) -> Bools:  # fmt: skip
    """Whether a hit comes before the best one so far: smaller t; at equal t the lower number.

    Source: S4, S5.
    """
    first = (object_ < best_object) | ((object_ == best_object) & (triangle_ < best_triangle))
    before: Bools = (t < best_t) | ((t == best_t) & np.isfinite(t) & ((best_object < 0) | first))
    return before


def in_interval(t: Floats, t0: Floats | float, t1: Floats | float) -> Bools:
    """t ∈ [t0, t1] and t > 0: the half-line begins behind its origin. Source: S6, S5, E3."""
    inside: Bools = (t >= t0) & (t <= t1) & (t > 0) & np.isfinite(t)
    return inside


def smallest_root(near: Floats, far: Floats, near_counts: Bools, far_counts: Bools) -> Floats:
    """The smallest root in the interval: the far one where the origin lies inside. Source: S8."""
    return np.where(near_counts, near, np.where(far_counts, far, np.inf))


def to_light(l: Floats) -> Floats:
    """The unit direction −l/‖l‖ of the shadow ray. Source: S12."""
    return -l / norm(l)


def start_of_secondary(epsilon: float) -> float:
    """t0 of RT(M, −l, ε, ∞), RT(P, ρ, ε, ∞), RT(P, ϱ, ε, ∞): ε, so that M's own surface is not met.

    ε is the third argument of RT; the slide says the first (E4). M is the surface point seen
    through the pixel; the slide says the pixel's centre (E5). Source: S12, S14, S16.
    """
    return epsilon


def toward_viewer(s: Floats, delta: Floats) -> Floats:
    """The normal turned to where the ray came from: s·δ ≤ 0. Source: S13."""
    return np.where(dot(s, delta) > 0, -s, s)


_Rule = TypeVar("_Rule")


def _rule(number: str, function: _Rule) -> _Rule:
    default: _Rule = field(default=function, metadata={"rule": number})
    return default


@dataclass(frozen=True, repr=False)
class Rules:
    """Every step of the algorithm, by its field's name; `number` tells which rule it is.

    Examples
    --------
    >>> wrong = SLIDES.replace(start_of_secondary=lambda epsilon: 0.0)
    >>> wrong
    SLIDES with start_of_secondary replaced
    >>> wrong.changed()
    ('start_of_secondary',)
    >>> Rules.number("start_of_secondary")
    'S12'
    """

    view_frame: ViewFrameRule = _rule("S1", screen.view_frame)
    pixel_center: PixelCenterRule = _rule("S2", screen.pixel_center)
    model_from_view: ModelFromViewRule = _rule("S3", screen.model_from_view)
    closer: CloserRule = _rule("S4", closer)
    ray_direction: RayDirectionRule = _rule("S5", screen.ray_direction)
    point_at: PointAtRule = _rule("S5", screen.point_at)
    depth_of: DepthRule = _rule("S5", screen.depth_of)
    distance_of: DistanceRule = _rule("S5", screen.distance_of)
    in_interval: IntervalRule = _rule("S6", in_interval)
    combine: CombineRule = _rule("S7", shading.combine)
    sphere: SphereRule = _rule("S8", sphere_roots)
    smallest_root: SmallestRootRule = _rule("S8", smallest_root)
    sphere_normal: SphereNormalRule = _rule("S8", sphere_normal)
    triangle: TriangleRule = _rule("S9", triangle_hit)
    face_normal: FaceNormalRule = _rule("S9", plane_normal)
    plane: PlaneRule = _rule("S10", plane_t)
    polygon: PolygonRule = _rule("S11", polygon_hit)
    to_light: ToLightRule = _rule("S12", to_light)
    start_of_secondary: StartRule = _rule("S12", start_of_secondary)
    toward_viewer: TowardViewerRule = _rule("S13", toward_viewer)
    illuminate: IlluminateRule = _rule("S13", shading.illuminate)
    shadow_color: ShadowColorRule = _rule("S13", shading.shadow_color)
    reflect: ReflectRule = _rule("S14", optics.reflected_direction)
    indices: IndicesRule = _rule("S15", optics.refractive_indices)
    refract: RefractRule = _rule("S16", optics.refracted_direction)

    def replace(self, **functions: Callable[..., Any]) -> Rules:
        """A copy with some rules replaced.

        Raises
        ------
        InputError
            A name that is no rule's, or something that cannot be called.
        """
        for name, function in functions.items():
            if name not in self.__dataclass_fields__:
                names = ", ".join(self.__dataclass_fields__)
                raise InputError("no such rule", got=name[:80], expected=f"one of {names}")
            if not callable(function):
                got = type(function).__name__
                raise InputError("not a function", where=name, got=got, expected="a function")
        return dataclasses.replace(self, **functions)

    def changed(self) -> tuple[str, ...]:
        """Names of the rules that are not the lecture's."""
        return tuple(
            f.name for f in dataclasses.fields(self) if getattr(self, f.name) is not f.default
        )

    def __repr__(self) -> str:
        changed = ", ".join(self.changed())
        return f"SLIDES with {changed} replaced" if changed else "SLIDES"

    @classmethod
    def number(cls, name: str) -> str:
        """The number, S1–S16, of a rule by its field's name."""
        return str(cls.__dataclass_fields__[name].metadata["rule"])


#: The lecture's own rules.
SLIDES = Rules()
