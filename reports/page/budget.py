"""Which arrays a page holds: all scenes' before any scene's exact ones."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest

from reports.page.close_up import CloseUp, Kept

#: Bytes of all arrays of a page, before base64 adds a third: with them it stays below 25 MB.
ROOM = 15_500_000


def arrays_within(closes: Sequence[CloseUp], room: int = ROOM) -> list[dict[str, Kept]]:
    """The arrays to show of each scene and reference; none of those for which no room is left.

    Where it lasts, rounded arrays give way to exact ones: of every scene what fails first, then
    what comes next.
    """
    chosen: list[dict[str, Kept]] = []
    for close in closes:
        size = sum(kept.size for kept in close.arrays.values())
        chosen.append(dict(close.arrays) if size <= room else {})
        room -= size if size <= room else 0
    for turn in zip_longest(*(close.exact.items() for close in closes)):
        for arrays, item in zip(chosen, turn, strict=True):
            if item is None or item[0] not in arrays:
                continue
            name, exact = item
            more = exact.size - arrays[name].size
            if more <= room:
                arrays[name] = exact
                room -= more
    return chosen
