"""How many references confirm each quantity of a scene, counted pixel by pixel."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from minirt.vectors import Bools, Floats
from reference.compare.comparison import Comparison

#: Makes something small for a report, where the arrays are: of a map (ny, nx) int64 of the number
#: of sources that judged a pixel and agree with minirt, and of the mask (ny, nx) where any differs.
Draw = Callable[[NDArray[np.int64], Bools], Any]


@dataclass(frozen=True)
class Quorum:
    """One quantity of one scene over all references that gave it.

    Attributes
    ----------
    quantity : str
    sources : tuple of str
        References that gave it.
    confirmed : tuple of int
        confirmed[k]: pixels at which exactly k sources judged and agreed with minirt.
    dissent : dict of str to int
        By source: certain pixels at which it differs from minirt; only sources that do.
    alone : dict of str to int
        Of those: pixels at which every other source that judged agrees with minirt, of which
        there is at least one.
    drawn : object
        What the caller's `Draw` made of the maps; None without a `Draw` or a source.
    """

    quantity: str
    sources: tuple[str, ...]
    confirmed: tuple[int, ...]
    dissent: dict[str, int]
    alone: dict[str, int]
    drawn: Any = None


def quorum_of(
    comparisons: Mapping[str, Comparison], names: Iterable[str], draw: Draw | None = None
) -> tuple[Quorum, ...]:
    """Count, for each quantity, how many sources confirm each pixel, and which ones dissent.

    A source judges a pixel where the exact answer is stable under its own declared error; it
    agrees where its error is within the tolerance.

    Parameters
    ----------
    comparisons : dict of str to Comparison
        By reference, of one scene.
    names : iterable of str
        Quantities.
    draw : callable, optional
        Called with the maps of each quantity that a source gave.
    """
    return tuple(
        _quorum(
            name, {who: c.ratio[name] for who, c in comparisons.items() if name in c.ratio}, draw
        )
        for name in names
    )


def _quorum(name: str, ratios: Mapping[str, Floats], draw: Draw | None) -> Quorum:
    if not ratios:
        return Quorum(name, (), (), {}, {})
    stack = np.stack(list(ratios.values()))
    agree, differ = (stack <= 1).sum(axis=0), stack > 1
    single = (differ.sum(axis=0) == 1) & (agree >= 1)
    return Quorum(
        quantity=name,
        sources=tuple(ratios),
        confirmed=tuple(np.bincount(agree.ravel(), minlength=len(ratios) + 1).tolist()),
        dissent=_counted(ratios, differ),
        alone=_counted(ratios, differ & single),
        drawn=draw(agree, np.asarray(differ.any(axis=0))) if draw else None,
    )


def _counted(ratios: Mapping[str, object], where: Bools) -> dict[str, int]:
    counts = dict(zip(ratios, where.sum(axis=(1, 2)).tolist(), strict=True))
    return {who: int(count) for who, count in counts.items() if count}
