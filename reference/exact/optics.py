"""S14–S16 in ball arithmetic: the directions in which rays leave a surface."""

from __future__ import annotations

from reference.exact.balls import Ball, blurred, blurred_by, known
from reference.exact.condition import Vector


def reflected(delta: Vector, s: Vector) -> list[Ball]:
    """ρ = δ − 2(δ·s)s, of unit vectors. Source: S14."""
    cosine, size = _cosine(delta, s)
    pairs = list(zip(delta, s, strict=True))
    return [blurred_by(x - 2 * cosine * y, abs(x) + 2 * size * abs(y)) for x, y in pairs]


def refracted(delta: Vector, s: Vector, ior: float) -> tuple[bool | None, list[Ball] | None]:
    """Whether there is total internal reflection (None: open), and ϱ where there is none.

    Parameters
    ----------
    delta : 3 balls
        Unit direction of propagation.
    s : 3 balls
        Unit normal of the outside.
    ior : float
        Index of the inside; that of the outside is 1.

    Source: S15, S16, E1, E2.
    """
    cosine, _ = _cosine(delta, s)
    if not (cosine > 0 or cosine < 0):
        return None, None
    (index,) = known([ior])
    ratio = index if cosine > 0 else blurred(1 / index)
    s = s if cosine > 0 else [-y for y in s]
    cosine = abs(cosine)
    square = ratio * ratio
    radicand = blurred_by(1 - square * (1 - cosine * cosine), 1 + square * (1 + cosine * cosine))
    if not (radicand > 0 or radicand < 0):
        return None, None
    if radicand < 0:
        return True, None
    root = blurred(radicand.sqrt())
    along, size = root - ratio * cosine, root + ratio * cosine
    pairs = list(zip(delta, s, strict=True))
    return False, [
        blurred_by(ratio * x + along * y, ratio * abs(x) + size * abs(y)) for x, y in pairs
    ]


def _cosine(delta: Vector, s: Vector) -> tuple[Ball, Ball]:
    """δ·s within 4 ulp of its terms, and the sum of their sizes."""
    terms = [x * y for x, y in zip(delta, s, strict=True)]
    size = abs(terms[0]) + abs(terms[1]) + abs(terms[2])
    return blurred_by(terms[0] + terms[1] + terms[2], size), size
