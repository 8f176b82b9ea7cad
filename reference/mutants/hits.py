"""Wrong versions of S4, S6 and S8: which hit counts, and the sphere."""

from __future__ import annotations

import numpy as np

from minirt.rules import SLIDES
from minirt.shapes.sphere import sphere_quadratic, sphere_roots
from minirt.vectors import Bools, Floats, Ints, dot, unit
from reference.mutants.mutant import Mutant


def _first_in_order(
    t: Floats, object_: Ints, triangle_: Ints,
    best_t: Floats, best_object: Ints, best_triangle: Ints,
) -> Bools:  # fmt: skip
    earlier = (object_ < best_object) | ((object_ == best_object) & (t < best_t))
    found: Bools = np.isfinite(t) & ((best_object < 0) | earlier)
    return found


def _last_along_ray(
    t: Floats, object_: Ints, triangle_: Ints,
    best_t: Floats, best_object: Ints, best_triangle: Ints,
) -> Bools:  # fmt: skip
    found: Bools = np.isfinite(t) & ((best_object < 0) | (t > best_t))
    return found


def _behind_too(t: Floats, t0: Floats, t1: Floats) -> Bools:
    inside: Bools = (t <= t1) & np.isfinite(t)
    return inside


def _from_screen_on(t: Floats, t0: Floats, t1: Floats) -> Bools:
    inside: Bools = (t >= np.where(t0 == 0, 1.0, t0)) & (t <= t1) & np.isfinite(t)
    return inside


def _far_root(near: Floats, far: Floats, near_counts: Bools, far_counts: Bools) -> Floats:
    return np.where(far_counts, far, np.where(near_counts, near, np.inf))


def _near_root_only(near: Floats, far: Floats, near_counts: Bools, far_counts: Bools) -> Floats:
    return np.where(near_counts, near, np.inf)


def _absolute_delta(P0: Floats, d: Floats, C: Floats, R: Floats) -> tuple[Floats, Floats]:
    a, b, _, quarter_delta = sphere_quadratic(P0, d, C, R)
    root = np.sqrt(np.abs(quarter_delta))
    return (b - root) / a, (b + root) / a


def _half_linear_term(P0: Floats, d: Floats, C: Floats, R: Floats) -> tuple[Floats, Floats]:
    L = P0 - C
    a, b, c = dot(d, d), dot(d, L), dot(L, L) - R * R
    delta = b * b - 4.0 * a * c
    root = np.sqrt(np.maximum(delta, 0.0))
    near = np.where(delta >= 0, (-b - root) / (2.0 * a), np.inf)
    return near, np.where(delta >= 0, (-b + root) / (2.0 * a), np.inf)


def _unit_direction_assumed(P0: Floats, d: Floats, C: Floats, R: Floats) -> tuple[Floats, Floats]:
    L = C - P0
    b = dot(d, L)
    quarter_delta = b * b - dot(L, L) + R * R
    root = np.sqrt(np.maximum(quarter_delta, 0.0))
    meets = quarter_delta >= 0
    return np.where(meets, b - root, np.inf), np.where(meets, b + root, np.inf)


def _larger_radius(P0: Floats, d: Floats, C: Floats, R: Floats) -> tuple[Floats, Floats]:
    return sphere_roots(P0, d, C, R + 1e-5)


def _textbook_in_float32(P0: Floats, d: Floats, C: Floats, R: Floats) -> tuple[Floats, Floats]:
    P0, d, C, R = (v.astype(np.float32) for v in (P0, d, C, R))  # type: ignore[assignment]
    L = P0 - C
    a, b, c = dot(d, d), 2 * dot(d, L), dot(L, L) - R * R
    delta = b * b - 4 * a * c
    root = np.sqrt(np.maximum(delta, 0))
    near, far = ((-b + sign * root) / (2 * a) for sign in (-1, 1))
    return tuple(np.where(delta >= 0, t.astype(np.float64), np.inf) for t in (near, far))  # type: ignore[return-value]


def _not_unit(M: Floats, C: Floats) -> Floats:
    return M - C


def _inward(M: Floats, C: Floats) -> Floats:
    return unit(C - M)


def _from_origin(M: Floats, C: Floats) -> Floats:
    return unit(M)


MUTANTS = (
    Mutant("nearest-by-object-order", "S4", "with the first object in the scene's order taken",
           "The loop over the objects ends at the first one that is hit at all.",
           "object", SLIDES.replace(closer=_first_in_order)),
    Mutant("last-hit", "S4", "with the last object along the ray taken",
           "A comparison of t the wrong way round, or a z-buffer cleared to 0.",
           "object", SLIDES.replace(closer=_last_along_ray)),
    Mutant("negative-root-accepted", "S6", "with hits behind the ray's origin counted",
           "The whole line was met, not the half-line t > 0.",
           "hit", SLIDES.replace(in_interval=_behind_too)),
    Mutant("hits-before-screen-ignored", "S6", "with hits before the virtual screen ignored",
           "A rasteriser's near plane: t starts at 1 for the observer's rays.",
           "hit", SLIDES.replace(in_interval=_from_screen_on)),
    Mutant("far-root", "S8", "with the larger root",
           "−b + √Δ was tried first: the back of each sphere is seen.",
           "object", SLIDES.replace(smallest_root=_far_root)),
    Mutant("near-root-only", "S8", "with the near root only",
           "From inside a sphere the near root lies behind, and the sphere is missed.",
           "hit", SLIDES.replace(smallest_root=_near_root_only)),
    Mutant("absolute-discriminant", "S8", "with √|Δ| in the place of the test Δ ≥ 0",
           "It keeps the square root from failing, and every ray meets every sphere.",
           "hit", SLIDES.replace(sphere=_absolute_delta)),
    Mutant("half-linear-term", "S8", "with d·(P0−C) in the place of 2d·(P0−C)",
           "The halved formula's b under the full formula's 4ac.",
           "hit", SLIDES.replace(sphere=_half_linear_term)),
    Mutant("unit-direction-assumed", "S8", "with d·d taken for 1",
           "The short formula of other books holds for unit directions only.",
           "hit", SLIDES.replace(sphere=_unit_direction_assumed)),
    Mutant("radius-larger-by-1e-5", "S8", "with the radius larger by 1e-5",
           "A bias that is to hide speckles.",
           "t", SLIDES.replace(sphere=_larger_radius)),
    Mutant("sphere-in-float32", "S8", "with textbook roots in float32",
           "−b ± √Δ cancels, and float32 has few digits to lose.",
           "t", SLIDES.replace(sphere=_textbook_in_float32)),
    Mutant("sphere-normal-not-unit", "S8", "with the normal M − C not made a unit vector",
           "It is one on a sphere of radius 1.",
           "normal", SLIDES.replace(sphere_normal=_not_unit)),
    Mutant("sphere-normal-inward", "S8", "with the normal pointing inward",
           "C − M in the place of M − C.",
           "normal", SLIDES.replace(sphere_normal=_inward)),
    Mutant("sphere-normal-from-origin", "S8", "with the normal measured from the origin",
           "It is right for a sphere around the origin, as in a first example.",
           "normal", SLIDES.replace(sphere_normal=_from_origin)),
)  # fmt: skip
