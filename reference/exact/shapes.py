"""Whether a ray whose numbers are balls hits a shape, misses it, or neither is certain.

The lecture's equations as they stand: cancellation does no harm to balls of 128 bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple

from reference.exact.balls import Ball, blurred
from reference.exact.condition import Vector, cross, dot, minus


class Answer(Enum):
    """The answer to a question about balls."""

    YES = "yes"
    NO = "no"
    OPEN = "open"


class Ray(NamedTuple):
    """P0 + t·d for t ≥ t0 and t > 0. Source: S5, S6."""

    P0: list[Ball]
    d: list[Ball]
    t0: float


class Intersection(NamedTuple):
    """Whether a ray hits a shape, at which t, and in which face (None: open)."""

    answer: Answer
    t: Ball
    face: int | None


MISSED = Intersection(Answer.NO, None, None)


def intersect_sphere(ray: Ray, C: Vector, R: Ball) -> Intersection:
    """The smallest root within the ray's interval. Source: S8."""
    L = minus(C, ray.P0)
    a, b = dot(ray.d, ray.d), dot(ray.d, L)
    k = b / a
    q = [x - k * y for x, y in zip(L, ray.d, strict=True)]
    quarter_delta = a * (R * R - dot(q, q))
    if quarter_delta < 0:
        return MISSED
    if not quarter_delta > 0:
        # a tangent, or nearly one: both roots are close to k
        half = quarter_delta.upper().sqrt() / a
        return _counted(Answer.OPEN, blurred((k - half).union(k + half)), 0, ray.t0)
    half = quarter_delta.sqrt() / a
    near = _counted(Answer.YES, blurred(k - half), 0, ray.t0)
    if near.answer is Answer.YES:
        return near
    far = _counted(Answer.YES, blurred(k + half), 0, ray.t0)
    if near.answer is Answer.NO:
        return far
    both = near.t if far.answer is Answer.NO else near.t.union(far.t)
    return Intersection(Answer.OPEN, both, 0)


def intersect_triangle(ray: Ray, corners: Sequence[Vector], N: Vector, face: int) -> Intersection:
    """Inside where the three weights have one sign. Source: S9."""
    A, B, C = (minus(corner, ray.P0) for corner in corners)
    weights = [dot(ray.d, cross(C, B)), dot(ray.d, cross(A, C)), dot(ray.d, cross(B, A))]
    inside = _one_sign(weights)
    if inside is Answer.NO:
        return MISSED
    return _counted(inside, blurred(dot(A, N) / dot(ray.d, N)), face, ray.t0)


def intersect_polygon(ray: Ray, corners: Sequence[Vector], p: Vector) -> Intersection:
    """The plane's t (S10), and the fan's first triangle that holds the point. Source: S11.

    A ray through a diagonal of the fan is inside the polygon: only its triangle is open.
    """
    V = [minus(corner, ray.P0) for corner in corners]
    rim = [dot(ray.d, cross(V[k + 1], V[k])) for k in range(1, len(V) - 1)]
    spoke = [dot(ray.d, cross(V[0], V[k])) for k in range(1, len(V))]
    fan = [_one_sign([rim[k], spoke[k + 1], -spoke[k]]) for k in range(len(rim))]
    found = next((k for k, inside in enumerate(fan) if inside is not Answer.NO), None)
    if found is None:
        return MISSED
    inside = Answer.YES if Answer.YES in fan else _one_sign([*rim, -spoke[0], spoke[-1]])
    if inside is Answer.NO:
        inside = Answer.OPEN
    face = found if fan[found] is Answer.YES else None
    return _counted(inside, blurred(dot(V[0], p) / dot(ray.d, p)), face, ray.t0)


def _one_sign(weights: Sequence[Ball]) -> Answer:
    positive, negative = [w > 0 for w in weights], [w < 0 for w in weights]
    if all(positive) or all(negative):
        return Answer.YES
    return Answer.NO if any(positive) and any(negative) else Answer.OPEN


def _counted(inside: Answer, t: Ball, face: int | None, t0: float) -> Intersection:
    """t ∈ [t0, ∞) and t > 0. Source: S6."""
    if t < t0 or t <= 0:
        return MISSED
    counts = t >= t0 and t > 0
    return Intersection(inside if counts else Answer.OPEN, t, face)
