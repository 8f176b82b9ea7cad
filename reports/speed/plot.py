"""The measured speed as a drawing: rays a second against primitives, both axes logarithmic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from reports.page.template import template
from reports.speed.results import Case, Kind, Speed
from reports.speed.table import origin

#: Size of the drawing; top and bottom of its panels; left, right and labels of each panel.
WIDTH, HEIGHT = 960, 500
TOP, BOTTOM = 84.0, 424.0
_PANELS: dict[Kind, tuple[float, float]] = {"spheres": (62.0, 322.0), "triangles": (536.0, 796.0)}
#: From a panel's right edge to its labels, and between two of them.
_ASIDE, _GAP = 22.0, 16.5


@dataclass(frozen=True)
class Line:
    """One tracer in one panel.

    Attributes
    ----------
    tracer : str
    color : int
        Number of its color: that of its column in the table.
    points : tuple of (float, float, str)
        Where, and the words that a pointer over it shows.
    path, leader : str
        The line, and what leads from its end to its label, in SVG's language.
    label : (float, float)
        Where its name stands.
    """

    tracer: str
    color: int
    points: tuple[tuple[float, float, str], ...]
    path: str
    leader: str
    label: tuple[float, float]


@dataclass(frozen=True)
class Panel:
    """One kind of primitive: axes with their ticks, and a line a tracer."""

    kind: str
    left: float
    right: float
    across: tuple[tuple[float, str], ...]
    up: tuple[tuple[float, str], ...]
    lines: tuple[Line, ...]


@dataclass(frozen=True)
class Plot:
    """What the template draws."""

    panels: tuple[Panel, ...]
    words: str
    origin: str
    width: int = WIDTH
    height: int = HEIGHT
    top: float = TOP
    bottom: float = BOTTOM


def plot_of(speed: Speed) -> Plot:
    """The drawing of a run; a kind that was not measured has no panel."""
    cases = {kind: [case for case in speed.cases if case.kind == kind] for kind in _PANELS}
    rates = [rate for some in cases.values() for case in some for rate in case.rates.values()]
    decades = range(math.floor(math.log10(min(rates))), math.ceil(math.log10(max(rates))) + 1)
    panels = tuple(
        _panel(kind, some, speed.tracers, decades) for kind, some in cases.items() if some
    )
    names = ", ".join(speed.tracers)
    words = f"First hits a second against the number of spheres and of triangles, by {names}"
    return Plot(panels, words, f"make bench on {origin(speed)}")


def plot_svg(speed: Speed) -> str:
    """The drawing as a file of its own, for light and dark."""
    return template("speed.svg.j2").render(plot=plot_of(speed))


def _panel(kind: Kind, cases: Sequence[Case], tracers: Sequence[str], decades: range) -> Panel:
    left, right = _PANELS[kind]
    sizes = [case.primitives for case in cases]
    low, high = math.log10(min(sizes)), math.log10(max(sizes))
    span = max(high - low, 1.0)

    def across(size: float) -> float:
        return round(left + 8 + (right - left - 16) * (math.log10(size) - low) / span, 1)

    def up(rate: float) -> float:
        share = (math.log10(rate) - decades[0]) / (decades[-1] - decades[0])
        return round(BOTTOM - (BOTTOM - TOP) * share, 1)

    points = {
        name: tuple(
            (across(case.primitives), up(case.rates[name]), _words(name, case))
            for case in sorted(cases, key=lambda each: each.primitives)
            if name in case.rates
        )
        for name in tracers
    }
    shown = {name: place for name, place in points.items() if place}
    heights = spread([place[-1][1] for place in shown.values()])
    return Panel(
        kind, left, right,
        tuple((across(10.0**k), short(10**k)) for k in range(math.ceil(low), math.floor(high) + 1)),
        tuple((up(10.0**k), short(10**k) if k >= 0 else f"{10.0**k:g}") for k in decades),
        tuple(
            _line(name, tracers.index(name), place, (right + _ASIDE, height), right)
            for (name, place), height in zip(shown.items(), heights, strict=True)
        ),
    )  # fmt: skip


def _line(
    tracer: str, color: int, points: tuple[tuple[float, float, str], ...],
    label: tuple[float, float], right: float,
) -> Line:  # fmt: skip
    path = " ".join(f"{'L' if k else 'M'}{x} {y}" for k, (x, y, _) in enumerate(points))
    x, y, _ = points[-1]
    leader = f"M{x} {y} H{right} L{label[0] - 4} {label[1]}"
    return Line(tracer, color, points, path, leader, label)


def spread(heights: Sequence[float]) -> list[float]:
    """Heights moved apart, so that no label covers another, as little as that takes.

    Examples
    --------
    >>> spread([300.0, 100.0, 101.0])
    [300.0, 92.2, 108.8]
    """
    groups: list[list[int]] = []
    for k in sorted(range(len(heights)), key=heights.__getitem__):
        groups.append([k])
        while len(groups) > 1 and _middle(heights, groups[-2:]) < _room(groups[-2:]):
            groups[-2:] = [groups[-2] + groups[-1]]
    placed = list(heights)
    for group in groups:
        top = sum(heights[k] for k in group) / len(group) - _GAP * (len(group) - 1) / 2
        for place, k in enumerate(group):
            placed[k] = round(top + _GAP * place, 1)
    return placed


def _middle(heights: Sequence[float], groups: Sequence[Sequence[int]]) -> float:
    """From the middle of one group of labels to that of the next."""
    first, second = (sum(heights[k] for k in group) / len(group) for group in groups)
    return second - first


def _room(groups: Sequence[Sequence[int]]) -> float:
    """How far the middles of two groups must be apart."""
    return _GAP * sum(map(len, groups)) / 2


def short(size: int) -> str:
    """A power of ten on an axis.

    Examples
    --------
    >>> short(100), short(10_000), short(1_000_000)
    ('100', '10k', '1M')
    """
    for unit, sign in ((1_000_000, "M"), (1_000, "k")):
        if size >= unit:
            return f"{size // unit}{sign}"
    return str(size)


def _words(tracer: str, case: Case) -> str:
    return f"{tracer}, {case.name}: {case.rates[tracer]:,.0f} rays a second"
