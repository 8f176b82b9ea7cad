"""Numbers with an error bound: midpoint and radius, of which every operation keeps account.

A ball holds every number that could stand in its place. Balls are python-flint's `arb`: a
comparison is true only where it holds for all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

from flint import arb, ctx, fmpq

from reference.exact.condition import BOUND, ULP, Vector, dot

Ball: TypeAlias = Any

#: Bits of the midpoints. Radii come from the inputs, of 50 bits or so; what is rounded beyond
#: twice that is nothing beside them.
BITS = 128
#: Where 64 bits of an exact result are not found with so many, it is zero or as good as that.
MOST_BITS = 4096

#: 1 and 0, give or take 4 ulp: what minirt promises of each of its steps.
_ONE, _NOTHING = arb(1, BOUND * ULP), arb(0, BOUND * ULP)


@contextmanager
def precision(bits: int = BITS) -> Iterator[None]:
    """Midpoints of so many bits meanwhile."""
    with ctx.workprec(bits):
        yield


def rational(x: float) -> Any:
    """The number itself, as an exact fraction."""
    return fmpq(*float(x).as_integer_ratio())


def rationals(xs: Iterable[float]) -> list[Any]:
    """Each of the numbers itself."""
    return [rational(x) for x in xs]


def blurred(x: Ball) -> Ball:
    """x, give or take 4 ulp of it."""
    return x * _ONE


def blurred_by(x: Ball, size: Ball) -> Ball:
    """x, give or take 4 ulp of another size: that of the terms whose sum it is."""
    return x + size * _NOTHING


def each_blurred(v: Vector) -> list[Ball]:
    """Each component give or take 4 ulp of it."""
    return [x * _ONE for x in v]


def known(xs: Iterable[float]) -> list[Ball]:
    """Float64 numbers as a kernel sees them: give or take 4 ulp of each."""
    return [arb(x) * _ONE for x in map(float, xs)]


def unit(v: Vector) -> list[Ball]:
    """v/‖v‖, give or take 4 ulp of each component."""
    length = dot(v, v).sqrt()
    return each_blurred([x / length for x in v])


def as_ball(x: Any) -> Ball:
    """An exact number, or a ball, at the precision that is set."""
    return arb(x)


def sharp(formula: Callable[[], Ball]) -> Ball:
    """A ball of exact numbers, with as many bits as it takes to know 64 of the result."""
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
    """The radius, rounded; +inf for what may be anything."""
    return float(x.rad()) if x.is_finite() else float("inf")
