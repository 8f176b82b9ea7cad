"""What a person sees of a history in the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from reference.compare.check import Check
from reports.history.difference import KINDS, CellChange, Difference, Kind
from reports.history.entry import Entry
from reports.history.previous import Point
from reports.history.trends import HIGHEST, LOWEST, Change
from reports.results.words import ICONS, count, figure, one_line, share, times

#: Cells of one kind that are listed one by one; the page has them all.
MOST_LINES = 30
_BLOCKS = "▁▂▃▄▅▆▇█"
_STYLES: dict[Kind, str] = {"worse": "bold dark_orange", "better": "bold blue"}
#: Icons of a scene's states.
SCENE_ICONS = {"passed": "✓", "failed": "✗", "incomplete": "!", "not compared": "–"}


def print_difference(found: Difference, console: Console) -> None:
    """A line for each cell that changed, and the counts."""
    for word, entry in (("from", found.first), ("to", found.second)):
        _say(console, Text(f"{word:4} {run_in_words(entry)}", "dim"))
    for fact, was, now in found.origin:
        _say(console, Text(f"     {one_line(fact)}: {one_line(was)} → {one_line(now)}", "dim"))
    for line in scenes_in_words(found):
        _say(console, Text(line))
    for kind, (sign, _) in KINDS.items():
        cells = [cell for cell in found.notable if cell.kind == kind]
        for cell in cells[:MOST_LINES]:
            _say(console, Text(cell_line(cell), _STYLES.get(kind, "")))
        if len(cells) > MOST_LINES:
            _say(console, Text(f"{sign} … and {len(cells) - MOST_LINES} more {kind}", "dim"))
    _say(console, Text(f"{verdict_of(found)}: {sentence_of(found)}", "bold"))


def verdict_of(found: Difference) -> str:
    """Whether anything fails, or has no answer, that did better before; and what is lost."""
    if found.regressions:
        return f"{count(found.regressions, 'cell')} got worse"
    counts = found.counts
    lost = [f"{count(counts[k], 'cell')} {k}" for k in ("worse", "gone") if counts[k]]
    return f"No new failure, but {' and '.join(lost)}" if lost else "Nothing got worse"


def sentence_of(found: Difference) -> str:
    """The counts, in a sentence."""
    parts = [f"{number} {kind}" for kind, number in found.counts.items() if number]
    told = ", ".join(parts) or "no cell changed"
    return f"{told}; {count(found.same, 'cell')} the same"


def scenes_in_words(found: Difference) -> list[str]:
    """Scenes that are new, gone, renamed or altered, a line each kind."""
    lines = [
        (f"{count(len(names), 'scene')} {what}: {', '.join(names)}")
        for what, names in (
            ("only in the second run", found.new),
            ("only in the first run", found.gone),
            ("renamed", [f"{old} → {new}" for old, new in found.renamed]),
            ("altered under the same name", found.altered),
        )
        if names
    ]
    return [one_line(line, 1000) for line in lines]


def cell_line(cell: CellChange) -> str:
    """One cell: the sign, where, before and after, and why it fails."""
    sign, _ = KINDS[cell.kind]
    place = " × ".join(map(one_line, cell.name))
    was, now = (check_in_words(each) for each in (cell.before, cell.after))
    reason = cell.after.reason if cell.after is not None and cell.kind == "worse" else ""
    return f"{sign} {place}: {was} → {now}" + (f"; {one_line(reason)}" if reason else "")


def check_in_words(check: Check | None) -> str:
    """A check's icon and figure, and its share of certain pixels where it was compared."""
    if check is None:
        return "none"
    certain = f" ({share(check.certain, check.pixels)} certain)" if check.pixels else ""
    return f"{ICONS[check.state]} {figure(check)}{certain}"


def run_in_words(entry: Entry) -> str:
    """A run in a line: its number, when, from which commit, and its verdict."""
    name = f"run {entry.number}" if entry.number is not None else "results.json"
    commit = f", commit {entry.commit[:10]}" if entry.commit else ""
    dirty = " with local changes" if entry.dirty else ""
    return f"{name}, {entry.started}{commit}{dirty}: {one_line(entry.sentence)}"


def print_trend(
    series: str, trend: Sequence[Point], changes: Sequence[Change], most: int, console: Console
) -> None:
    """The newest runs of a scene in one series, oldest first, and every change."""
    shown = trend[-most:]
    _say(console, Text(f"{one_line(series)}: {count(len(trend), 'run')}  {blocks(shown)}", "bold"))
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for name in ("run", "started", "commit", "state", "worst ratio", ""):
        table.add_column(name, justify="right" if name in ("run", "worst ratio") else "left")
    told = {change.after.run: change for change in changes}
    for point in shown:
        change = told.get(point.run)
        ratio = "none" if point.ratio is None else times(point.ratio)
        table.add_row(
            str(point.run), point.started[:19].replace("T", " "), (point.commit or "none")[:10],
            f"{SCENE_ICONS.get(point.state, '–')} {point.state}", ratio,
            Text(f"{sign_of(change)} {change.what}" if change else ""),
        )  # fmt: skip
    console.print(table)


def sign_of(change: Change) -> str:
    """▲ worse, ▼ better, ≠ neither."""
    return {False: "▲", True: "▼", None: "≠"}[change.better]


def blocks(trend: Sequence[Point]) -> str:
    """A trend as a line of blocks, logarithmic; a dot where nothing was compared."""
    span = math.log(HIGHEST / LOWEST)
    levels = [
        "·" if p.ratio is None
        else _BLOCKS[round(math.log(min(max(p.ratio, LOWEST), HIGHEST) / LOWEST) / span * 7)]
        for p in trend
    ]  # fmt: skip
    return "".join(levels)


def _say(console: Console, text: Text) -> None:
    console.print(text, soft_wrap=True)
