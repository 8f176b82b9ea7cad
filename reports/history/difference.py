"""What changed from one run to another, cell by cell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from minirt.quantities import QUANTITIES
from reference.compare.check import COMPARED, UNANSWERED, Check, State
from reports.history.entry import Entry
from reports.results.cells import CellName
from reports.results.words import figure, share

Kind = Literal["worse", "better", "higher", "lower", "changed", "new", "gone"]

#: Kinds in the order in which they are listed, with a sign and what they mean.
KINDS: dict[Kind, tuple[str, str]] = {
    "worse": ("▲", "a worse state"),
    "better": ("▼", "a better state"),
    "higher": ("↑", "the same state, a larger error"),
    "lower": ("↓", "the same state, a smaller error"),
    "changed": ("≠", "neither better nor worse"),
    "new": ("+", "not in the first run"),
    "gone": ("−", "not in the second run"),
}

#: States from good to bad; those between are no verdict.
_BADNESS: dict[State, int] = {
    "passed": 0, "not supported": 1, "not given": 1, "known": 2,
    "missing": 3, "timed out": 3, "crashed": 3, "failed": 3,
}  # fmt: skip


@dataclass(frozen=True)
class CellChange:
    """One cell that changed; None where it was not there."""

    name: CellName
    kind: Kind
    before: Check | None
    after: Check | None

    @property
    def regression(self) -> bool:
        """Whether it fails, or has no answer, and did better before."""
        return self.kind == "worse" and self.after is not None and _fails(self.after)


@dataclass(frozen=True)
class Difference:
    """From one run to another.

    Attributes
    ----------
    first, second : Entry
    cells : tuple of CellChange
        Worst news first.
    same : int
        Cells that did not change.
    new, gone, altered : tuple of str
        Scenes only in the second run, only in the first, and with another hash.
    renamed : tuple of (str, str)
        Old and new name of scenes with the same hash.
    origin : tuple of (str, str, str)
        What differs in where the runs came from: the fact, before and after.
    """

    first: Entry
    second: Entry
    cells: tuple[CellChange, ...]
    same: int
    new: tuple[str, ...]
    gone: tuple[str, ...]
    renamed: tuple[tuple[str, str], ...]
    altered: tuple[str, ...]
    origin: tuple[tuple[str, str, str], ...]

    @property
    def counts(self) -> dict[Kind, int]:
        """Number of cells of each kind."""
        found = [cell.kind for cell in self.cells]
        return {kind: found.count(kind) for kind in KINDS}

    @property
    def notable(self) -> tuple[CellChange, ...]:
        """The cells worth a line: of a scene that is wholly new or gone only what fails."""
        whole = {*self.new, *self.gone}
        return tuple(
            cell
            for cell in self.cells
            if cell.name[0] not in whole or (cell.after is not None and _fails(cell.after))
        )

    @property
    def regressions(self) -> int:
        """Number of cells that fail, or have no answer, and did better before."""
        return sum(cell.regression for cell in self.cells)


def difference(first: Entry, second: Entry) -> Difference:
    """What changed from the first run to the second."""
    old = {scene.name: scene.sha256 for scene in first.scenes}
    new = {scene.name: scene.sha256 for scene in second.scenes}
    by_hash = {sha: name for name, sha in old.items() if name not in new}
    renamed = {
        by_hash[sha]: name for name, sha in new.items() if name not in old and sha in by_hash
    }
    before: dict[CellName, Check] = {}
    for cell in first.cells():
        scene, reference, quantity = cell.name
        before[renamed.get(scene, scene), reference, quantity] = cell.check
    after = {cell.name: cell.check for cell in second.cells()}
    names = list(dict.fromkeys([*after, *before]))
    compared = [_change(name, before.get(name), after.get(name)) for name in names]
    changed = [change for change in compared if change is not None]
    return Difference(
        first=first,
        second=second,
        cells=tuple(sorted(changed, key=_order)),
        same=len(names) - len(changed),
        new=tuple(n for n in new if n not in old and n not in renamed.values()),
        gone=tuple(n for n in old if n not in new and n not in renamed),
        renamed=tuple(renamed.items()),
        altered=tuple(n for n in new if old.get(n, new[n]) != new[n]),
        origin=tuple(_origin(first, second)),
    )


def _fails(check: Check) -> bool:
    return check.state in ("failed", *UNANSWERED)


def _order(cell: CellChange) -> tuple[int, int]:
    """Worst news first, then as the rays go; scenes and references stay in their order."""
    quantity = cell.name[2]
    place = list(QUANTITIES).index(quantity) if quantity in QUANTITIES else len(QUANTITIES)
    return list(KINDS).index(cell.kind), place


def _change(name: CellName, before: Check | None, after: Check | None) -> CellChange | None:
    """How a cell changed; None where it shows the same as before."""
    if before is None or after is None:
        return CellChange(name, "new" if before is None else "gone", before, after)
    kind: Kind
    if before.state != after.state:
        kind = _kind_of(before.state, after.state)
    elif figure(before) != figure(after):
        was_so, is_so = ((c.wrong, c.ratio or 0.0) for c in (before, after))
        kind = "higher" if is_so > was_so else "lower" if is_so < was_so else "changed"
    elif share(before.certain, before.pixels) != share(after.certain, after.pixels):
        kind = "changed"
    else:
        return None
    return CellChange(name, kind, before, after)


def _kind_of(before: State, after: State) -> Kind:
    """Which way a state went: a failure that is no longer compared has not become better."""
    was, now = _BADNESS[before], _BADNESS[after]
    if now > was:
        return "worse"
    return "better" if now < was and after in COMPARED else "changed"


def _origin(first: Entry, second: Entry) -> Iterator[tuple[str, str, str]]:
    facts = [_facts(entry) for entry in (first, second)]
    for name in dict.fromkeys([*facts[0], *facts[1]]):
        was, now = (each.get(name, "–") for each in facts)
        if was != now:
            yield name, was, now


def _facts(entry: Entry) -> dict[str, str]:
    commit = (entry.commit or "none")[:10] + (" with local changes" if entry.dirty else "")
    programs = {name: ", ".join(ran) or "no answer" for name, ran in entry.programs.items()}
    return {
        "commit": commit, "judged": entry.judged or "minirt",
        **entry.versions, "system": entry.system, "processor": entry.cpu, **programs,
    }  # fmt: skip
