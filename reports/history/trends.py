"""Where a trend changed: between which two runs, and what.

The rule, stated once. A scene's trend changes

1. where its state is another one than in the run before: a night is enough; or
2. where the logarithm of its worst ratio takes a step that lasts: between runs of the same state,
   the median of up to ten runs after differs from the median of up to ten runs before by more than
   25 % and by more than four times the noise, and the three runs next to it on each side all lie
   on their own side of the middle. The noise is the median jump between neighbours, which one step
   or one outlier does not move; few runs tell little of it, and it counts for up to half as much
   again.

Ratios below 1/1000 count as 1/1000: a change far below the tolerance does not matter.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.history.previous import Point
from reports.results.words import times

#: Least runs on each side of a step, and most that are looked at.
LEAST, MOST = 3, 10
#: Least factor of a step, and how many times the noise it must be.
FACTOR, NOISE_FACTOR = 1.25, 4.0
#: Beyond these, ratios are taken to be equal.
LOWEST, HIGHEST = 1e-3, 1e6
#: Standard deviation of one run, from the median of the jumps between neighbours: 1/(0.6745·√2).
_FROM_JUMPS = 1.0484


@dataclass(frozen=True)
class Change:
    """A change of one scene's trend.

    Attributes
    ----------
    before, after : Point
        The two neighbouring runs between which it happened.
    better : bool or None
        None where neither is better, such as another scene under the same name.
    what : str
        For people.
    """

    before: Point
    after: Point
    better: bool | None
    what: str


def changes_of(trend: Sequence[Point]) -> list[Change]:
    """Every change of a trend, oldest first.

    Parameters
    ----------
    trend : sequence of Point
        One scene in one series, oldest first.
    """
    found: list[Change] = []
    start = 0
    for k in range(1, len(trend) + 1):
        if k == len(trend) or trend[k].state != trend[k - 1].state:
            found += _steps_within(trend[start:k])
            if k < len(trend):
                found.append(_new_state(trend[k - 1], trend[k]))
            start = k
    return found


def _new_state(before: Point, after: Point) -> Change:
    better = {"passed": True, "failed": False}.get(after.state)
    if better is None and before.state == "passed":
        better = False
    what = f"{before.state} → {after.state}"
    return Change(before, after, better, what + _altered(before, after))


def _steps_within(points: Sequence[Point]) -> list[Change]:
    """Steps among runs of one state; those without a ratio are left out."""
    known = [point for point in points if point.ratio is not None]
    logs = np.log([min(max(p.ratio or 0.0, LOWEST), HIGHEST) for p in known])
    found = []
    for k in sorted(_split(logs, 0, len(logs))):
        left, right = _sides(logs, k)
        low, high = math.exp(np.median(left)), math.exp(np.median(right))
        what = f"worst ratio {times(low)} → {times(high)}"
        before, after = known[k - 1], known[k]
        found.append(Change(before, after, high < low, what + _altered(before, after)))
    return found


def _altered(before: Point, after: Point) -> str:
    return "; the scene itself was altered" if before.sha256 != after.sha256 else ""


def _split(logs: NDArray[np.float64], start: int, end: int) -> list[int]:
    """The steps between two indices: the clearest one, then those to each side of it."""
    part = logs[start:end]
    if len(part) < 2 * LEAST:
        return []
    noise = _FROM_JUMPS * float(np.median(np.abs(np.diff(part))))
    few = 1 + LEAST / len(part)
    least = max(math.log(FACTOR), NOISE_FACTOR * noise * few)
    clearest, size, spread = 0, least, math.inf
    for k in range(LEAST, len(part) - LEAST + 1):
        left, right = _sides(part, k)
        low, high = np.median(left), np.median(right)
        step, rest = abs(high - low), np.concatenate([abs(left - low), abs(right - high)]).mean()
        if step > least and (rest, -step) < (spread, -size) and _lasts(left, right, low, high):
            clearest, size, spread = k, float(step), float(rest)
    if not clearest:
        return []
    here = start + clearest
    return [*_split(logs, start, here), here, *_split(logs, here, end)]


def _lasts(
    left: NDArray[np.float64], right: NDArray[np.float64], low: np.float64, high: np.float64
) -> bool:
    """Whether the neighbours on each side all lie nearer to their own median."""
    near = np.concatenate([left[-LEAST:] - low, high - right[:LEAST]]) / (high - low)
    return bool((near < 0.5).all())


def _sides(logs: NDArray[np.float64], k: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return logs[max(0, k - MOST) : k], logs[k : k + MOST]
