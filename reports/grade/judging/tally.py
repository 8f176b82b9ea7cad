"""Count the right pixels of a scene for each part of a rubric, and turn them into credit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from minirt.quantities import QUANTITIES, STAGES
from minirt.vectors import Bools
from reference.verify.results import Evidence
from reports.grade.assignment.rubric import Part
from reports.grade.judging.relevance import first_wrong, relevant_pixels

#: Consequences of an earlier mistake are left out while this share of the pixels remains.
_LEAST_SHARE = 0.5


@dataclass(frozen=True)
class Tally:
    """The pixels of one scene that a part is judged by.

    Attributes
    ----------
    judged, right : int
        Certain pixels that are relevant for the part, without consequences of earlier mistakes.
    given, asked : int
        Quantities.
    """

    judged: int
    right: int
    given: int
    asked: int

    @property
    def share(self) -> float:
        """The share of right pixels."""
        return self.right / self.judged if self.judged else 1.0


def charged_pixels(parts: Iterable[tuple[Part, tuple[str, ...]]], seen: Evidence) -> Bools:
    """The pixels of one scene whose first mistake some part is about, (ny, nx).

    Parameters
    ----------
    parts : iterable of (Part, tuple of str)
        All of the rubric, also those that are judged on other scenes, with their quantities, from
        `quantities_judged`.
    seen : Evidence
    """
    mask = np.zeros(seen.ours.size, dtype=np.bool_)
    for part, names in parts:
        relevant = relevant_pixels(part, seen.scene, seen.ours, seen.theirs)
        for name in names:
            if name in seen.comparison.ratio:
                mask |= relevant & first_wrong(part, name, seen)
    return mask


def tally(part: Part, names: tuple[str, ...], seen: Evidence, excused: Bools) -> Tally:
    """Count the pixels of one scene for a part.

    A pixel is wrong where a quantity of the part is wrong at the pixel's first wrong stage, and the
    part's rules can be blamed for it. Where some part is about an earlier mistake, the error here
    is a consequence and is left out of the count, as long as half of the pixels remain; beyond
    that consequences count as wrong. What follows from a mistake that no part is about counts as
    wrong here.

    Parameters
    ----------
    part : Part
    names : tuple of str
        From `quantities_judged`.
    seen : Evidence
    excused : (ny, nx) bool
        From `charged`.
    """
    comparison = seen.comparison
    given = [name for name in names if name in comparison.ratio]
    relevant = relevant_pixels(part, seen.scene, seen.ours, seen.theirs)
    considered = relevant & _certain(given or names, seen)
    wrong, follows = (np.zeros(seen.ours.size, dtype=np.bool_) for _ in range(2))
    for name in given:
        later = comparison.ratio[name] > 1
        later &= comparison.first_stage < STAGES.index(QUANTITIES[name].stage)
        wrong |= first_wrong(part, name, seen) | (later & ~excused)
        follows |= later & excused
    wrong &= considered
    follows &= considered & ~wrong
    all_, bad_, later_ = (int(mask.sum()) for mask in (considered, wrong, follows))
    judged = all_ - later_ if all_ - later_ >= _LEAST_SHARE * all_ else all_
    right = all_ - later_ - bad_ if given else 0
    return Tally(judged, right, len(given), len(names))


def credit(share: float, full: float, zero: float) -> float:
    """Partial credit: 0 to 1, linear between the shares that earn nothing and everything."""
    return min(1.0, max(0.0, (share - zero) / (full - zero)))


def _certain(names: Sequence[str], seen: Evidence) -> Bools:
    certain: Bools = np.zeros(seen.ours.size, dtype=np.bool_)
    for name in names:
        certain |= seen.stability.certain[name]
    return certain
