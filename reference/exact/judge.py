"""Judge a frame of minirt's: where the exact answer is certain, minirt must give it."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from minirt.frame import Array, Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.exact.balls import Ball, as_ball, middle, precision, radius
from reference.exact.condition import BOUND, ULP
from reference.exact.pixel import PixelAnswers, exact_pixels
from reference.exact.primitives import Solution

#: Quantities that the judge computes, in the table's order.
JUDGED = tuple(
    name
    for name in QUANTITIES
    if name in {
        "hit", "object", "triangle", "t", "position", "normal", "shadow",
        "reflection", "reflection_object", "reflection_t",
        "tir", "refraction", "refraction_object", "refraction_t",
    }
)  # fmt: skip


@dataclass(frozen=True)
class Opinion:
    """The judge's opinion on one quantity of one pixel.

    Attributes
    ----------
    quantity : str
    row, column : int
        From the TOP, and from the left.
    decided, agrees : bool
        Whether the exact answer is certain, and whether minirt gives it; the second is True if the
        first is False.
    ulps : float or None
        Error in ulp: of t, divided by its condition number; of other numbers, in quarters of what
        4 ulp in every step add up to; None for discrete quantities.
    ours, exact : list of float
    """

    quantity: str
    row: int
    column: int
    decided: bool
    agrees: bool
    ulps: float | None
    ours: tuple[float, ...]
    exact: tuple[float, ...]


@dataclass(frozen=True)
class Count:
    """One quantity over all the pixels that were judged; `ulps` is the largest error."""

    quantity: str
    judged: int
    decided: int
    agreed: int
    ulps: float | None


@dataclass(frozen=True)
class Judgement:
    """The judge's result for a scene's frame.

    Attributes
    ----------
    pixels : int
        Number of pixels that were judged.
    counts : tuple of Count
    convictions : tuple of Opinion
        Where the answer is certain and minirt's is another.
    worst : Opinion or None
        The opinion with the largest error of t, within bounds or not.
    seconds : float
    """

    pixels: int
    counts: tuple[Count, ...]
    convictions: tuple[Opinion, ...]
    worst: Opinion | None
    seconds: float


def judge_pixels(scene: Scene, frame: Frame, pixels: Sequence[tuple[int, int]]) -> Judgement:
    """Compare a frame of minirt's with exact arithmetic.

    Parameters
    ----------
    scene : Scene
    frame : Frame
        minirt's own; quantities that it lacks are not judged.
    pixels : sequence of (row, column)
        Rows from the TOP.
    """
    begin = time.perf_counter()
    opinions = list(opinions_of(scene, frame, pixels))
    counts = tuple(_count(name, opinions) for name in JUDGED if name in frame)
    convictions = tuple(o for o in opinions if not o.agrees)
    measured = [o for o in opinions if o.quantity == "t" and o.decided]
    worst = max(measured, key=lambda o: o.ulps or 0.0, default=None)
    return Judgement(len(pixels), counts, convictions, worst, time.perf_counter() - begin)


def opinions_of(scene: Scene, frame: Frame, pixels: Sequence[tuple[int, int]]) -> list[Opinion]:
    """One opinion for each pixel and each quantity that applies there."""
    with precision():
        answers = exact_pixels(scene, pixels)
        return [
            _opinion(name, pixel, answer, np.atleast_1d(frame[name][pixel]))
            for pixel, answer in zip(pixels, answers, strict=True)
            for name in JUDGED
            if name in frame and name in answer.values
        ]


def _opinion(name: str, pixel: tuple[int, int], answer: PixelAnswers, ours: Array) -> Opinion:
    value, mine = answer.values[name], tuple(map(float, ours))
    if QUANTITIES[name].discrete:
        known = value is not None
        exact = (float(value),) if known else ()
        return Opinion(name, *pixel, known, not known or mine == exact, None, mine, exact)
    balls = [] if value is None else value if isinstance(value, list) else [value]
    if not balls or not all(ball.is_finite() for ball in balls):
        return Opinion(name, *pixel, False, True, None, mine, ())
    if name == "t" and answer.solution is not None:
        balls = [answer.solution.t]
        ulps = _t_error(mine[0], answer.solution)
    else:
        ulps = max(_error(x, ball) for x, ball in zip(mine, balls, strict=True))
    return Opinion(name, *pixel, True, ulps <= BOUND, ulps, mine, tuple(map(middle, balls)))


def _t_error(ours: float, exact: Solution) -> float:
    """Error of t in ulp times its condition number."""
    if not math.isfinite(ours):
        return math.inf
    return middle(abs(as_ball(ours) - exact.t) / (abs(exact.t) * exact.condition * ULP))


def _error(ours: float, ball: Ball) -> float:
    """Error in quarters of the ball's radius: 4 is the largest that 4 ulp in every step allow."""
    if not math.isfinite(ours):
        return math.inf
    error, allowed = middle(abs(as_ball(ours) - ball.mid())), radius(ball)
    return 0.0 if error == 0 else BOUND * error / allowed if allowed else math.inf


def _count(name: str, opinions: Sequence[Opinion]) -> Count:
    these = [opinion for opinion in opinions if opinion.quantity == name]
    decided = [opinion for opinion in these if opinion.decided]
    errors = [opinion.ulps for opinion in decided if opinion.ulps is not None]
    agreed = sum(opinion.agrees for opinion in decided)
    return Count(name, len(these), len(decided), agreed, max(errors, default=None))
