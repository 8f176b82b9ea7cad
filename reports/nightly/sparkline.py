"""A trend as a small drawing: the worst ratio from run to run, on a logarithmic scale."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from reports.history.previous import Point
from reports.history.trends import Change
from reports.results.words import count, times

#: Size of the drawing in its own units, and the room that its marks need at each edge.
WIDTH, HEIGHT, EDGE = 260.0, 46.0, 5.0
#: Ratios at the lower and the upper edge; what lies beyond is drawn on it.
LOWEST, HIGHEST = 1e-2, 1e2


@dataclass(frozen=True)
class Dot:
    """One run: where, how it ended, and the words that a pointer over it shows."""

    x: float
    y: float
    state: str
    words: str


@dataclass(frozen=True)
class Sparkline:
    """What the template draws.

    Attributes
    ----------
    dots : tuple of Dot
    lines : tuple of str
        Corner points of each unbroken line.
    limit : float
        The height at which an error equals its tolerance.
    marks : tuple of (float, bool)
        Where it changed, and whether for the better.
    words : str
        The whole drawing in a sentence.
    """

    dots: tuple[Dot, ...]
    lines: tuple[str, ...]
    limit: float
    marks: tuple[tuple[float, bool], ...]
    words: str


def sparkline(trend: Sequence[Point], changes: Sequence[Change]) -> Sparkline:
    """The drawing of a trend, oldest run on the left; the newest always at the right edge."""
    dots = tuple(_dot(point, k, len(trend)) for k, point in enumerate(trend))
    at = {point.run: k for k, point in enumerate(trend)}
    marks = tuple(
        (_across((at[c.before.run] + at[c.after.run]) / 2, len(trend)), bool(c.better))
        for c in changes
        if c.before.run in at and c.after.run in at
    )
    return Sparkline(dots, tuple(_lines(trend, dots)), _up(1.0), marks, _words(trend, changes))


def _dot(point: Point, k: int, number: int) -> Dot:
    ratio = "nothing compared" if point.ratio is None else f"worst ratio {times(point.ratio)}"
    commit = f", commit {point.commit[:10]}" if point.commit else ""
    words = f"run {point.run}, {point.started[:16]}{commit}: {point.state}, {ratio}"
    kind = point.state if point.state in ("passed", "failed") else "other"
    y = HEIGHT - EDGE if point.ratio is None else _up(point.ratio)
    return Dot(_across(k, number), y, kind, words)


def _lines(trend: Sequence[Point], dots: Sequence[Dot]) -> list[str]:
    """Lines that break where nothing was compared."""
    lines: list[list[str]] = [[]]
    for point, dot in zip(trend, dots, strict=True):
        if point.ratio is None:
            lines.append([])
        else:
            lines[-1].append(f"{dot.x:.1f},{dot.y:.1f}")
    return [" ".join(line) for line in lines if len(line) > 1]


def _across(k: float, number: int) -> float:
    step = (WIDTH - 2 * EDGE) / max(number - 1, 11)  # few runs stand close together
    return round(WIDTH - EDGE - (number - 1 - k) * step, 1)


def _up(ratio: float) -> float:
    clipped = min(max(ratio, LOWEST), HIGHEST)
    share = math.log(clipped / LOWEST) / math.log(HIGHEST / LOWEST)
    return round(HEIGHT - EDGE - share * (HEIGHT - 2 * EDGE), 1)


def _words(trend: Sequence[Point], changes: Sequence[Change]) -> str:
    failed = sum(point.state == "failed" for point in trend)
    text = f"{count(len(trend), 'run')}, {failed} failed"
    last = f"; changed last at run {changes[-1].after.run}" if changes else "; no change"
    return text + last
