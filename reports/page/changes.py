"""What has changed since the previous run: arrows, scenes, and a trend line for each scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from reference.compare.check import COMPARED, Check
from reference.verify.results import SceneResult
from reports.history.previous import Point, PreviousRun
from reports.history.trends import Change, changes_of
from reports.page.matrix import MatrixCell
from reports.results.cells import CellName, cells_of
from reports.results.findings import SceneFindings
from reports.results.words import count, listed, one_line, times

#: A worst error that grows or shrinks by less than this factor has not changed.
_SAME = 1.1
#: Size of a trend line in CSS pixels, and the least and largest ratio that it tells apart.
_WIDTH, _HEIGHT, _LOW, _HIGH = 96, 24, 1e-3, 1e3


@dataclass(frozen=True)
class SceneChanges:
    """Scenes of this run beside those of the previous one, by name.

    Attributes
    ----------
    new, removed, altered : tuple of str
        An altered scene has its old name and another content.
    renamed : tuple of (str, str)
        Old and new name of the same content.
    """

    new: tuple[str, ...]
    removed: tuple[str, ...]
    altered: tuple[str, ...]
    renamed: tuple[tuple[str, str], ...]


def scene_changes(previous: PreviousRun, results: Sequence[SceneResult]) -> SceneChanges:
    """Which scenes are new, removed, renamed or altered."""
    now = {result.scene.name: result.scene.sha256 for result in results}
    gone = {sha: name for name, sha in previous.scenes.items() if name not in now}
    came = {name: sha for name, sha in now.items() if name not in previous.scenes}
    renamed = tuple((gone[sha], name) for name, sha in came.items() if sha in gone)
    old = {name for name, _ in renamed}
    return SceneChanges(
        new=tuple(name for name, sha in came.items() if sha not in gone),
        removed=tuple(name for name in gone.values() if name not in old),
        altered=tuple(n for n, sha in now.items() if previous.scenes.get(n, sha) != sha),
        renamed=renamed,
    )


def arrow(check: Check, was: Check | None) -> str:
    """▲ where a cell is worse than it was, ▼ where it is better, nothing where it is neither."""
    if was is None or was.state not in COMPARED or check.state not in COMPARED:
        return ""
    if was.state != check.state:
        order = ("passed", "known", "failed")
        return "▲" if order.index(check.state) > order.index(was.state) else "▼"
    now, then = check.ratio or 0.0, was.ratio or 0.0
    if now > then * _SAME:
        return "▲"
    return "▼" if now * _SAME < then else ""


def with_arrow(cell: MatrixCell, check: Check, was: Check | None) -> MatrixCell:
    """A cell of the matrix that says how it has changed."""
    sign = arrow(check, was)
    if not sign or was is None:
        return cell
    word = "worse" if sign == "▲" else "better"
    ratio = "" if was.ratio is None else f", {times(was.ratio)}"
    return replace(cell, arrow=sign, title=f"{cell.title}; {word}: it was {was.state}{ratio}")


@dataclass(frozen=True, eq=False)
class RunChanges:
    """A run against the previous one of its series.

    Attributes
    ----------
    previous : PreviousRun
        Its `last` is None where there was none: then nothing has changed.
    scenes : SceneChanges
    arrows : dict of CellName to str
        The cells that have changed, each with its arrow.
    """

    previous: PreviousRun
    scenes: SceneChanges
    arrows: Mapping[CellName, str]


def run_changes(previous: PreviousRun, results: Sequence[SceneResult]) -> RunChanges:
    """What has changed since the previous run."""
    signs = {
        cell.name: arrow(cell.check, previous.cells.get(cell.name)) for cell in cells_of(results)
    }
    arrows = {name: sign for name, sign in signs.items() if sign}
    return RunChanges(previous, scene_changes(previous, results), arrows)


def changes_in_words(changes: RunChanges) -> list[str]:
    """Sentences against the previous run; none where there was none."""
    last = changes.previous.last
    if last is None:
        return []
    signs = list(changes.arrows.values())
    worse, better = signs.count("▲"), signs.count("▼")
    commit = f", commit {last.commit[:10]}" if last.commit else ""
    change = f"{count(worse, 'cell')} worse, {better} better" if signs else "no cell has changed"
    head = f"Against the run of {last.started}{commit}: {change}."
    return [head, *_scenes_in_words(changes.scenes)]


def _scenes_in_words(scenes: SceneChanges) -> Iterator[str]:
    pairs = tuple(f"{old} → {new}" for old, new in scenes.renamed)
    for word, names in (
        ("New", scenes.new), ("Removed", scenes.removed), ("Renamed", pairs),
        ("Altered", scenes.altered),
    ):  # fmt: skip
        if names:
            yield f"{word}: {listed([one_line(name, 80) for name in names])}."


def change_tags(changes: RunChanges, scene: str) -> list[str]:
    """`new` and `changed`, where a scene is."""
    if changes.previous.last is None:
        return []
    new = {*changes.scenes.new, *(name for _, name in changes.scenes.renamed)}
    changed = {*(name[0] for name in changes.arrows), *changes.scenes.altered}
    return [*(["new"] if scene in new else []), *(["changed"] if scene in changed else [])]


@dataclass(frozen=True)
class Trend:
    """The worst error over tolerance of one scene, run by run, as a line to draw.

    Attributes
    ----------
    path : str
        The line, in SVG's language.
    dots : tuple of (float, float, bool)
        x, y and whether the scene failed, of each run.
    one : float
        y of the tolerance.
    changed : float or None
        x of the run at which it changed last: its state, or a lasting step.
    words : str
        The same in words.
    width, height : int
    """

    path: str
    dots: tuple[tuple[float, float, bool], ...]
    one: float
    changed: float | None
    words: str
    width: int = _WIDTH
    height: int = _HEIGHT


def trend_of(previous: PreviousRun, scene: SceneFindings, commit: str | None) -> Trend | None:
    """How a scene did in earlier runs and does now; None where there were none."""
    earlier = previous.trends.get(scene.result.scene.name, ())
    if not earlier:
        return None
    ratio = None if scene.worst is None else scene.worst.ratio
    now = Point(
        earlier[-1].run + 1, "now", commit, scene.state, ratio, scene.result.scene.sha256
    )  # fmt: skip
    points = (*earlier, now)
    step = (_WIDTH - 8) / max(1, len(points) - 1)
    places = [
        (4 + step * k, _height(point.ratio), point.state == "failed")
        for k, point in enumerate(points)
        if point.ratio is not None
    ]
    changes = changes_of(points)
    last = changes[-1] if changes else None
    path = " ".join(f"{'L' if k else 'M'}{x:.1f} {y:.1f}" for k, (x, y, _) in enumerate(places))
    return Trend(
        path=path,
        dots=tuple(places),
        one=_height(1.0),
        changed=4 + step * points.index(last.after) if last else None,
        words=_trend_in_words(points, last),
    )


def _height(ratio: float) -> float:
    """Where a ratio stands on a logarithmic scale, in CSS pixels from the top."""
    inside = min(max(ratio, _LOW), _HIGH)
    share = math.log(inside / _LOW) / math.log(_HIGH / _LOW)
    return round(3 + (_HEIGHT - 6) * (1 - share), 1)


def _trend_in_words(points: Sequence[Point], last: Change | None) -> str:
    known = [point.ratio for point in points if point.ratio is not None]
    text = f"worst error ÷ tolerance over {count(len(points), 'run')}"
    if known:
        text += f": from {times(known[0])} to {times(known[-1])}"
    if last is not None:
        at = f"commit {last.after.commit[:10]}" if last.after.commit else last.after.started
        turned = last.before.state != last.after.state
        text += f"; {last.after.state if turned else last.what} since {at}"
    return text
