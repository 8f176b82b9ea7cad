"""What each part of a rubric is judged by: quantities, and the pixels that speak of its rules."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from minirt.frame import Frame
from minirt.quantities import QUANTITIES, STAGES, Stage
from minirt.scene import Facets, Scene
from minirt.screen import view_frame
from minirt.vectors import Bools
from reference.mutants import CATALOGUE
from reference.traceability import TRACED, trace_rules
from reference.verify.results import Evidence
from reports.grade.rubric import Part

#: The kinds of objects that a rule about one kind speaks of.
_KINDS: dict[str, tuple[str, ...]] = {
    "S8": ("sphere",),
    "S9": ("triangle", "polygon", "mesh"),
    "S10": ("polygon",),
    "S11": ("polygon",),
}
#: Rules about glass: they speak of pixels where the material has an index.
_GLASS = ("S15", "S16", "E1", "E2")
#: Rules about the rays; whatever they meet also shows a mistake in them.
_SCREEN = ("S1", "S2", "S3")
#: Components of two normals that differ by no more are the same in any precision.
_ALIKE = 0.01
#: Consequences of an earlier mistake are left out while so much of the picture is left to judge.
_LEAST_LEFT = 0.5


@dataclass(frozen=True)
class Tally:
    """The pixels of one scene that a part is judged by.

    Attributes
    ----------
    judged, right : int
        Certain pixels that speak of the part, without consequences of what was wrong before.
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


@cache
def quantities_of(rule: str) -> tuple[str, ...]:
    """What shows a rule: its own quantities, and those in which known mistakes in it show first."""
    (trace,) = (each for each in trace_rules(()) if each.rule == rule)
    own = set(trace.quantities)
    for stage in {mutant.stage for mutant in CATALOGUE.values() if mutant.rule == rule}:
        there = {name for name, q in QUANTITIES.items() if q.stage == stage}
        if not own & there:
            common = {name for name in there if not _KINDS.keys() >= set(QUANTITIES[name].rules)}
            own |= common or there
    return tuple(name for name in QUANTITIES if name in own)


def known_rule(rule: str) -> bool:
    """Whether a part can be about it."""
    return rule in TRACED


def quantities_judged(part: Part, asked: tuple[str, ...]) -> tuple[str, ...]:
    """The quantities that a part is judged by, of those that are asked for."""
    if part.rules:
        wanted = {name for rule in part.rules for name in quantities_of(rule)}
    else:
        stages: tuple[Stage, ...] = part.stages or STAGES
        wanted = {name for name, q in QUANTITIES.items() if q.stage in stages}
    return tuple(name for name in asked if name in wanted)


def charged(parts: Iterable[tuple[Part, tuple[str, ...]]], seen: Evidence) -> Bools:
    """The pixels of one scene whose first mistake is the matter of some part, (ny, nx).

    Parameters
    ----------
    parts : iterable of (Part, tuple of str)
        All of the rubric, also those that are judged on other scenes, with their quantities, from
        `quantities_judged`.
    seen : Evidence
    """
    mask = np.zeros(seen.ours.size, dtype=np.bool_)
    for part, names in parts:
        relevant = _relevant(part, seen.scene, seen.ours, seen.theirs)
        for name in names:
            if name in seen.comparison.ratio:
                mask |= relevant & _first_here(part, name, seen)
    return mask


def tally(part: Part, names: tuple[str, ...], seen: Evidence, excused: Bools) -> Tally:
    """Count the pixels of one scene for a part.

    A pixel is wrong where a quantity of the part is wrong at the pixel's first wrong stage, and
    tells of the part's rules. Where an earlier mistake is the matter of some part, the part's own
    error is a consequence and is left out of the count, as long as half of the pixels are left;
    after that consequences count as wrong. What follows from a mistake that no part is about is
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
    relevant = _relevant(part, seen.scene, seen.ours, seen.theirs)
    considered = relevant & _certain(given or names, seen)
    wrong, follows = (np.zeros(seen.ours.size, dtype=np.bool_) for _ in range(2))
    for name in given:
        later = comparison.ratio[name] > 1
        later &= comparison.first_stage < STAGES.index(QUANTITIES[name].stage)
        wrong |= _first_here(part, name, seen) | (later & ~excused)
        follows |= later & excused
    wrong &= considered
    follows &= considered & ~wrong
    all_, bad_, later_ = (int(mask.sum()) for mask in (considered, wrong, follows))
    judged = all_ - later_ if all_ - later_ >= _LEAST_LEFT * all_ else all_
    right = all_ - later_ - bad_ if given else 0
    return Tally(judged, right, len(given), len(names))


def _first_here(part: Part, name: str, seen: Evidence) -> Bools:
    """Where a quantity is wrong, no earlier one is, and that tells of the part's rules."""
    comparison = seen.comparison
    here = comparison.first_stage == STAGES.index(QUANTITIES[name].stage)
    bad: Bools = here & (comparison.ratio[name] > 1)
    if not part.rules:
        return bad
    telling = [
        _telling(rule, name, bad, seen) for rule in part.rules if name in quantities_of(rule)
    ]
    return np.asarray(np.logical_or.reduce(telling))


def _telling(rule: str, name: str, bad: Bools, seen: Evidence) -> Bools:
    """Those of the wrong pixels of a quantity that a rule can be blamed for.

    The hit map tells of the screen where no rays are given; t and what comes of it tell of S6
    where nothing is hit; normals tell of S3 where they are the right ones in viewing coordinates.
    """
    if rule in _SCREEN and name == "hit":
        return bad & ("ray" not in seen.comparison.ratio)
    if rule in _SCREEN and name == "normal":
        return _in_viewing_coordinates(bad, seen)
    if rule == "S6" and name != "hit":
        return np.asarray(bad & ~seen.ours["hit"])
    return bad


def _in_viewing_coordinates(bad: Bools, seen: Evidence) -> Bools:
    """The wrong normals, where most of them are minirt's in the observer's axes; else none."""
    axes = np.concatenate(view_frame(seen.scene.screen)[:3], axis=1)
    off = np.abs(seen.theirs["normal"] - seen.ours["normal"] @ axes).max(axis=-1)
    alike = bad & (off <= _ALIKE)
    return alike if alike.sum() > bad.sum() / 2 else np.zeros_like(bad)


def speaks_of(part: Part, scene: Scene, ours: Frame) -> bool:
    """Whether any pixel of a scene's right answer is one that the part is about."""
    return bool(_relevant(part, scene, ours, ours).any())


def _certain(names: Sequence[str], seen: Evidence) -> Bools:
    certain: Bools = np.zeros(seen.ours.size, dtype=np.bool_)
    for name in names:
        certain |= seen.stability.certain[name]
    return certain


def _relevant(part: Part, scene: Scene, ours: Frame, theirs: Frame) -> Bools:
    """The pixels that speak of a part: all, or those of its rules' kinds of objects."""
    masks = [_speaking(rule, scene, ours, theirs) for rule in part.rules]
    if not masks:
        return np.ones(ours.size, dtype=np.bool_)
    return np.asarray(np.logical_or.reduce(masks))


def _speaking(rule: str, scene: Scene, ours: Frame, theirs: Frame) -> Bools:
    if rule in _GLASS:
        glass: Bools = ours["tir"] >= 0
        return np.asarray(glass | (theirs["tir"] >= 0)) if "tir" in theirs else glass
    if rule not in _KINDS:
        return np.ones(ours.size, dtype=np.bool_)
    kinds = [each.type if isinstance(each, Facets) else "sphere" for each in scene.objects]
    of_kind = np.array([kind in _KINDS[rule] for kind in kinds] + [False])
    mask: Bools = of_kind[ours["object"]]
    if "object" in theirs:
        numbers = theirs["object"]
        inside = (numbers >= 0) & (numbers < len(kinds))
        return np.asarray(mask | of_kind[np.where(inside, numbers, -1)])
    if "hit" in theirs:
        return np.asarray(mask | (theirs["hit"] & ~ours["hit"]))
    return mask


def credit(share: float, full: float, zero: float) -> float:
    """Partial credit: 0 to 1, linear between the shares that earn nothing and everything."""
    return min(1.0, max(0.0, (share - zero) / (full - zero)))
