"""What a history knows of earlier runs of the same scenes; a run's page compares itself with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from reference.compare.check import Check
from reports.results.cells import CellName


@dataclass(frozen=True)
class Point:
    """One run of one scene in a trend.

    Attributes
    ----------
    run : int
        The run's number in the history.
    started : str
        ISO 8601, with the offset from UTC.
    commit : str or None
    state : str
        Of the scene.
    ratio : float or None
        The worst error over tolerance of all its cells; +inf for a discrete mismatch; None where
        nothing was compared.
    sha256 : str
        Of the scene as it was; empty for a run as a whole.
    dirty : bool or None
        Whether files differed from the commit.
    """

    run: int
    started: str
    commit: str | None
    state: str
    ratio: float | None
    sha256: str = ""
    dirty: bool | None = None


@dataclass(frozen=True)
class PreviousRun:
    """What a history knows of the scenes of a run, before that run.

    Attributes
    ----------
    last : Point or None
        The previous run as a whole, its `ratio` None; None where there was none.
    cells : mapping
        The checks of the previous run, as far as a history keeps them.
    scenes : mapping
        SHA-256 of each scene of the previous run, by name: new, removed, renamed (another name
        for the same hash) and altered scenes follow from it.
    trends : mapping
        Earlier points of each scene of the present run, oldest first.
    """

    last: Point | None
    cells: Mapping[CellName, Check]
    scenes: Mapping[str, str]
    trends: Mapping[str, tuple[Point, ...]]
