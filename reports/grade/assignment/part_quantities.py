"""The quantities that show each rule, and those by which a part of a rubric is judged."""

from __future__ import annotations

from functools import cache

from minirt.quantities import QUANTITIES, STAGES, Stage
from reference.mutants import CATALOGUE
from reference.traceability import TRACED, trace_rules
from reports.grade.assignment.rubric import Part

#: The kinds of objects that a rule is about, for rules that are not about all of them.
OBJECT_KINDS: dict[str, tuple[str, ...]] = {
    "S8": ("sphere",),
    "S9": ("triangle", "polygon", "mesh"),
    "S10": ("polygon",),
    "S11": ("polygon",),
}


@cache
def quantities_of(rule: str) -> tuple[str, ...]:
    """The quantities that show a rule: its own, and those in which known mistakes show first."""
    (trace,) = (each for each in trace_rules(()) if each.rule == rule)
    own = set(trace.quantities)
    for stage in {mutant.stage for mutant in CATALOGUE.values() if mutant.rule == rule}:
        there = {name for name, q in QUANTITIES.items() if q.stage == stage}
        if not own & there:
            common = {
                name for name in there if not OBJECT_KINDS.keys() >= set(QUANTITIES[name].rules)
            }
            own |= common or there
    return tuple(name for name in QUANTITIES if name in own)


def known_rule(rule: str) -> bool:
    """Whether a part of a rubric can be about a rule."""
    return rule in TRACED


def quantities_judged(part: Part, asked: tuple[str, ...]) -> tuple[str, ...]:
    """The quantities that a part is judged by, of those that are asked for."""
    if part.rules:
        wanted = {name for rule in part.rules for name in quantities_of(rule)}
    else:
        stages: tuple[Stage, ...] = part.stages or STAGES
        wanted = {name for name, q in QUANTITIES.items() if q.stage in stages}
    return tuple(name for name in asked if name in wanted)
