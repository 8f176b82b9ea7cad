"""Who seems to have copied: reported to staff, and never a matter of marks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import combinations

from reports.grade.judging.judge import MarkSheet
from reports.grade.record import Copy, Student
from reports.results.words import count, listed

#: The share of the frames, of whoever gave fewer, that must be the same.
_ENOUGH = 0.5


def find_copies(students: Sequence[Student]) -> tuple[Copy, ...]:
    """Frames with the same numbers to the last bit, and output that does not heed its scene."""
    return (*_identical(students), *_references(students), *_unchanging(students))


def _identical(students: Sequence[Student]) -> Iterator[Copy]:
    by_hash: dict[tuple[str, str], list[str]] = defaultdict(list)
    given: dict[str, int] = {}
    for student in students:
        given[student.name] = sum(result.state == "judged" for result in student.public)
        for result in student.public:
            if result.numbers:
                by_hash[result.scene, result.numbers].append(student.name)
    shared: dict[tuple[str, str], list[str]] = defaultdict(list)
    for (scene, _), names in by_hash.items():
        for pair in combinations(sorted(names), 2):
            shared[pair].append(scene)
    pairs = {
        pair: scenes
        for pair, scenes in shared.items()
        if len(scenes) >= _ENOUGH * min(given[name] for name in pair)
    }
    for group in _groups(pairs):
        scenes = sorted({s for pair, found in pairs.items() if pair[0] in group for s in found})
        yield Copy(
            kind="identical", students=tuple(group), scenes=tuple(scenes),
            sentence=f"{listed(group)} share the same numbers, bit for bit, on "
            f"{count(len(scenes), 'scene')}",
        )  # fmt: skip


def _groups(pairs: dict[tuple[str, str], list[str]]) -> list[list[str]]:
    """Students who are linked by pairs, each group in order."""
    leader: dict[str, str] = {}

    def of(name: str) -> str:
        while leader.setdefault(name, name) != name:
            name = leader[name]
        return name

    for first, second in sorted(pairs):
        leader[of(second)] = of(first)
    groups: dict[str, list[str]] = defaultdict(list)
    for name in sorted(leader):
        groups[of(name)].append(name)
    return list(groups.values())


def _references(students: Sequence[Student]) -> Iterator[Copy]:
    for student in students:
        own = [result.scene for result in student.results if result.ours]
        judged = sum(result.state == "judged" for result in student.results)
        if own and len(own) >= _ENOUGH * judged:
            scenes = tuple(sorted(set(own)))
            yield Copy(
                kind="reference", students=(student.name,), scenes=scenes,
                sentence=f"{student.name} has minirt's own numbers, bit for bit, in "
                f"{len(own)} of {count(judged, 'frame')}: a pack's, or minirt itself",
            )  # fmt: skip


def _unchanging(students: Sequence[Student]) -> Iterator[Copy]:
    for student in students:
        same: dict[str, list[MarkSheet]] = defaultdict(list)
        for result in student.results:
            if result.numbers:
                same[result.numbers].append(result)
        for results in same.values():
            if len(results) > 1 and any(result.wrong for result in results):
                variants = any(result.number for result in results)
                names = sorted({result.scene for result in results})
                what = "a scene and its hidden variant" if len(names) == 1 else listed(names)
                yield Copy(
                    kind="unchanging", students=(student.name,), scenes=tuple(names),
                    sentence=f"{student.name} gives the same numbers for {what}"
                    + (": it does not read its scene" if variants else ""),
                )  # fmt: skip
