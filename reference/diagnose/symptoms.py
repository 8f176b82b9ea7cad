"""Faults that show without a mutant: missing objects, and rays that hit their own surface.

Unfinished tracers have them, and many mutants agree by chance with a picture that lacks half of
its objects; so these faults are searched for first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from minirt.quantities import QUANTITIES
from minirt.scene import Facets
from minirt.vectors import Bools
from reference.verify.results import Evidence

#: Rounding to float32, and how many of its steps arithmetic in it may lose.
_U32, _STEPS = 2.0**-24, 64
#: Fewest pixels of a kind of object for its absence to count.
_FEWEST = 20
#: A secondary ray's t below this share of ε is a hit of the surface that it leaves.
_SELF_HIT = 0.5
#: The share of discrete answers that float32's rounding may change.
_CHANGED = 0.01


@dataclass(frozen=True)
class Symptom:
    """A fault that explains a failure.

    Attributes
    ----------
    name : str
    sentence : str
        A clause that follows the subject's name.
    """

    name: str
    sentence: str


def missing_or_self_hits(evidence: Evidence) -> Iterator[Symptom]:
    """Missing objects, and secondary rays that hit the surface that they leave."""
    if "hit" in evidence.comparison.ratio:
        seen, right = _hits(evidence)
        if right.any() and not seen.any():
            yield Symptom("empty", f"hits nothing, where {int(right.sum()):,} pixels should hit")
            return
        yield from _kinds_missing(evidence, seen, right)
    for branch in ("reflection", "refraction"):
        yield from _self_hits(evidence, f"{branch}_t")


def float32_arithmetic(evidence: Evidence) -> Iterator[Symptom]:
    """Errors everywhere, all of the size that float32 arithmetic causes."""
    largest = 0.0
    for name, ratio in evidence.comparison.ratio.items():
        wrong = ratio > 1
        if not wrong.any():
            continue
        if QUANTITIES[name].discrete:
            if wrong.mean() > _CHANGED:
                return
            continue
        ours, theirs = evidence.ours[name][wrong], evidence.theirs[name][wrong]
        with np.errstate(invalid="ignore"):
            size = np.maximum(np.abs(ours).max(), evidence.scene.extent * _is_length(name))
            error = np.abs(theirs - ours).reshape(len(ours), -1).max(axis=1) / max(size, 1e-300)
        largest = max(largest, float(np.median(error)))
    if 0 < largest <= _STEPS * _U32:
        yield Symptom(
            "float32",
            f"errs as arithmetic in float32 does, by {largest:.1g} of the values: if it computes "
            "in that, say --precision float32",
        )


def _is_length(name: str) -> bool:
    return QUANTITIES[name].kind == "length"


def _hits(evidence: Evidence) -> tuple[Bools, Bools]:
    """Where the subject hits something (all pixels), and where it certainly should."""
    seen = np.asarray(evidence.theirs["hit"], dtype=np.bool_)
    return seen, evidence.ours["hit"] & evidence.stability.certain["hit"]


def _kinds_missing(evidence: Evidence, seen: Bools, right: Bools) -> Iterator[Symptom]:
    """Kinds of objects that are hit nowhere although other kinds are."""
    objects = evidence.scene.objects
    kinds = np.array([thing.type if isinstance(thing, Facets) else "sphere" for thing in objects])
    is_hit = _is_hit(evidence, seen)
    first = evidence.ours["object"]
    gone, there = list[str](), list[str]()
    for kind in dict.fromkeys(kinds.tolist()):
        of_kind = right & (kinds[first] == kind) & (first >= 0)
        if of_kind.sum() >= _FEWEST:
            (there if is_hit(of_kind, kinds == kind) else gone).append(kind)
    if gone and there:
        words = " or ".join(gone)
        yield Symptom(f"no {words}", f"never meets a {words}: is that kind of object written yet?")


def _is_hit(evidence: Evidence, seen: Bools) -> Callable[[Bools, Bools], bool]:
    """Whether a kind of object is ever hit: by object numbers if given, else by `hit`."""
    if "object" in evidence.comparison.ratio:
        numbers = np.asarray(evidence.theirs["object"])
        found = np.unique(numbers[(numbers >= 0) & (numbers < len(evidence.scene.objects))])
        return lambda where, kind: bool(kind[found].any())
    return lambda where, kind: bool(seen[where].any())


def _self_hits(evidence: Evidence, name: str) -> Iterator[Symptom]:
    """Secondary rays that hit something nearer than ε allows."""
    if name not in evidence.comparison.ratio:
        return
    t, least = np.asarray(evidence.theirs[name], dtype=np.float64), evidence.scene.epsilon
    self_hit = (evidence.comparison.ratio[name] > 1) & (t < _SELF_HIT * least)
    if self_hit.sum() >= _FEWEST:
        yield Symptom(
            "self-hits",
            f"lets secondary rays meet the surface they leave ({name} {t[self_hit].max():.2g} "
            f"where ε is {least:.2g}): rule S12 starts them at ε",
        )
