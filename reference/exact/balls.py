"""Ball arithmetic: numbers with an error bound, which every operation propagates.

A ball is a midpoint and a radius, and contains every number that could be meant. Balls are
python-flint's `arb`: a comparison is true only if it holds for all numbers in the balls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

from flint import arb, ctx, fmpq

from reference.exact.condition import BOUND, ULP, Vector, dot

Ball: TypeAlias = Any

#: Bits of the midpoints. Radii come from inputs of some 50 bits; rounding at twice that many bits
#: is negligible beside them.
BITS = 128
#: Largest number of bits that are tried. A result of which they do not give 64 counts as zero.
MOST_BITS = 4096

#: 1 and 0, each within 4 ulp: what minirt promises of each of its steps.
_ONE, _NOTHING = arb(1, BOUND * ULP), arb(0, BOUND * ULP)


@contextmanager
def precision(bits: int = BITS) -> Iterator[None]:
    """Compute with midpoints of so many bits inside the context."""
    with ctx.workprec(bits):
        yield


def rational(x: float) -> Any:
    """The number as an exact fraction."""
    return fmpq(*float(x).as_integer_ratio())


def rationals(xs: Iterable[float]) -> list[Any]:
    """Each of the numbers as an exact fraction."""
    return [rational(x) for x in xs]


def blurred(x: Ball) -> Ball:
    """x within 4 ulp."""
    return x * _ONE


def blurred_by(x: Ball, size: Ball) -> Ball:
    """x within 4 ulp of another size: that of the terms of which it is the sum."""
    return x + size * _NOTHING


def each_blurred(v: Vector) -> list[Ball]:
    """Each component within 4 ulp."""
    return [x * _ONE for x in v]


def known(xs: Iterable[float]) -> list[Ball]:
    """Float64 numbers as minirt uses them: each within 4 ulp."""
    return [arb(x) * _ONE for x in map(float, xs)]


def unit(v: Vector) -> list[Ball]:
    """v/‖v‖, each component within 4 ulp."""
    length = dot(v, v).sqrt()
    return each_blurred([x / length for x in v])


def as_ball(x: Any) -> Ball:
    """An exact number or a ball, as a ball of the present precision."""
    return arb(x)


def sharp(formula: Callable[[], Ball]) -> Ball:
    """Evaluate a formula on exact numbers, with as many bits as give 64 correct bits."""
    bits = BITS
    while True:
        with precision(bits):
            result = formula()
        if result.rel_accuracy_bits() >= 64 or bits >= MOST_BITS:
            return result
        bits *= 2


def middle(x: Ball) -> float:
    """The midpoint, rounded."""
    return float(x.mid())


def radius(x: Ball) -> float:
    """The radius, rounded; +inf if it is unbounded."""
    return float(x.rad()) if x.is_finite() else float("inf")
