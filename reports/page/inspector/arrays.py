"""The arrays of one scene against one reference that a page holds, within a budget of bytes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Protocol

import numpy as np

from minirt.quantities import QUANTITIES, STAGES
from minirt.vectors import Floats
from reference.compare.check import Check
from reference.verify.results import Evidence
from reports.page.inspector.packing import Packed, pack, pack_ratio
from reports.page.pictures import Span, picture_span

#: Bytes that the arrays of one reference on one scene may take, before base64 adds a third.
ANSWER_BUDGET = 1_550_000
#: Bytes of all arrays of a page, before base64 adds a third: with them it stays below 25 MB.
PAGE_BUDGET = 15_500_000
#: Pixels of an image beyond which no arrays are kept: they would not fit.
MOST_PIXELS = 2**19


@dataclass(frozen=True)
class PackedArrays:
    """The arrays of one quantity.

    Attributes
    ----------
    ours, theirs : Packed
        Theirs packed as differences from ours where that is shorter.
    ratio : Packed
        Error over tolerance, with the sign of theirs − ours where that is one number.
    tolerance : Packed or None
        None for a discrete quantity.
    span : Span
        The values at the ends of its picture's colours.
    """

    ours: Packed
    theirs: Packed
    ratio: Packed
    tolerance: Packed | None
    span: Span

    @property
    def size(self) -> int:
        """Bytes."""
        parts = (self.ours, self.theirs, self.ratio, self.tolerance)
        return sum(len(packed.data) for packed in parts if packed is not None)


class HasArrays(Protocol):
    """Whatever brings the arrays of one scene against one reference, rounded and exact."""

    @property
    def arrays(self) -> dict[str, PackedArrays]:
        """By quantity, in order of importance; float64 may be rounded to float32."""

    @property
    def exact(self) -> dict[str, PackedArrays]:
        """By quantity, where `arrays` is rounded."""


def packed_arrays(
    evidence: Evidence,
) -> tuple[dict[str, PackedArrays], dict[str, PackedArrays]]:
    """The arrays of all quantities as float32 while the budget lasts, and exact ones of those.

    Returns
    -------
    rounded, exact : dict of str to PackedArrays
        What fails first comes first. `exact` has float64 where `rounded` had to round.
    """
    rounded: dict[str, PackedArrays] = {}
    exact: dict[str, PackedArrays] = {}
    budget = ANSWER_BUDGET if evidence.ours["hit"].size <= MOST_PIXELS else 0
    for name in _by_importance(evidence) if budget else ():
        arrays = _packed(name, evidence, rounded=True)
        if arrays.size <= budget:
            rounded[name] = arrays
            budget -= arrays.size
            if not (arrays.ours.exact and arrays.theirs.exact):
                exact[name] = _packed(name, evidence, rounded=False)
    return rounded, exact


def arrays_within(
    offered: Sequence[HasArrays], budget: int = PAGE_BUDGET
) -> list[dict[str, PackedArrays]]:
    """The arrays to hold of each scene and reference; none of those that the budget leaves out.

    Where it lasts, exact arrays replace rounded ones: first of every scene what fails first, then
    of every scene what comes next.
    """
    chosen: list[dict[str, PackedArrays]] = []
    for each in offered:
        size = sum(arrays.size for arrays in each.arrays.values())
        chosen.append(dict(each.arrays) if size <= budget else {})
        budget -= size if size <= budget else 0
    for turn in zip_longest(*(each.exact.items() for each in offered)):
        for held, item in zip(chosen, turn, strict=True):
            if item is None or item[0] not in held:
                continue
            name, exact = item
            more = exact.size - held[name].size
            if more <= budget:
                held[name] = exact
                budget -= more
    return chosen


def _by_importance(evidence: Evidence) -> list[str]:
    """Quantities in the order in which they get a share of the budget: what fails first first."""
    compared = [c for c in evidence.comparison.checks if c.quantity in evidence.comparison.ratio]

    def rank(check: Check) -> tuple[bool, bool, bool, int]:
        discrete = QUANTITIES[check.quantity].discrete
        return (
            not check.first_wrong, not discrete, check.state != "failed",
            STAGES.index(check.stage),
        )  # fmt: skip

    return [check.quantity for check in sorted(compared, key=rank)]


def _packed(name: str, evidence: Evidence, *, rounded: bool) -> PackedArrays:
    ours, theirs = evidence.ours[name], evidence.theirs[name]
    tolerance = evidence.stability.tolerance.get(name)
    return PackedArrays(
        pack(ours, rounded=rounded),
        pack(theirs, ours, rounded=rounded),
        pack_ratio(_signed_ratio(name, evidence)),
        None if tolerance is None else pack_ratio(tolerance),
        picture_span(name, ours, theirs),
    )


def _signed_ratio(name: str, evidence: Evidence) -> Floats:
    """Error over tolerance, negative where theirs is a smaller number than ours."""
    ratio = evidence.comparison.ratio[name]
    if QUANTITIES[name].components > 1:
        return ratio
    with np.errstate(invalid="ignore"):
        smaller = evidence.theirs[name].astype(np.float64) < evidence.ours[name]
    return np.where(smaller, -ratio, ratio)
