"""The pixels that are relevant for a rule, and those whose error a rule can be blamed for."""

from __future__ import annotations

import numpy as np

from minirt.frame import Frame
from minirt.quantities import QUANTITIES, STAGES
from minirt.scene import Facets, Scene
from minirt.screen import view_frame
from minirt.vectors import Bools
from reference.verify.results import Evidence
from reports.grade.assignment.part_quantities import OBJECT_KINDS, quantities_of
from reports.grade.assignment.rubric import Part

#: Rules about glass: relevant where the material has a refractive index.
_GLASS_RULES = ("S15", "S16", "E1", "E2")
#: Rules about primary rays; a mistake in them also shows in whatever the rays hit.
_RAY_RULES = ("S1", "S2", "S3")
#: Components of two normals that differ by no more are the same in any precision.
_SAME_NORMAL = 0.01


def is_relevant(part: Part, scene: Scene, ours: Frame) -> bool:
    """Whether any pixel of a scene's right answer is relevant for a part."""
    return bool(relevant_pixels(part, scene, ours, ours).any())


def relevant_pixels(part: Part, scene: Scene, ours: Frame, theirs: Frame) -> Bools:
    """The pixels that are relevant for a part: all, or those of its rules' kinds of objects."""
    masks = [_rule_mask(rule, scene, ours, theirs) for rule in part.rules]
    if not masks:
        return np.ones(ours.size, dtype=np.bool_)
    return np.asarray(np.logical_or.reduce(masks))


def _rule_mask(rule: str, scene: Scene, ours: Frame, theirs: Frame) -> Bools:
    if rule in _GLASS_RULES:
        glass: Bools = ours["tir"] >= 0
        return np.asarray(glass | (theirs["tir"] >= 0)) if "tir" in theirs else glass
    if rule not in OBJECT_KINDS:
        return np.ones(ours.size, dtype=np.bool_)
    kinds = [each.type if isinstance(each, Facets) else "sphere" for each in scene.objects]
    of_kind = np.array([kind in OBJECT_KINDS[rule] for kind in kinds] + [False])
    mask: Bools = of_kind[ours["object"]]
    if "object" in theirs:
        numbers = theirs["object"]
        inside = (numbers >= 0) & (numbers < len(kinds))
        return np.asarray(mask | of_kind[np.where(inside, numbers, -1)])
    if "hit" in theirs:
        return np.asarray(mask | (theirs["hit"] & ~ours["hit"]))
    return mask


def first_wrong(part: Part, name: str, seen: Evidence) -> Bools:
    """Where a quantity is wrong, no earlier one is, and the part's rules can be blamed for it."""
    comparison = seen.comparison
    here = comparison.first_stage == STAGES.index(QUANTITIES[name].stage)
    bad: Bools = here & (comparison.ratio[name] > 1)
    if not part.rules:
        return bad
    attributable = [
        _attributable(rule, name, bad, seen) for rule in part.rules if name in quantities_of(rule)
    ]
    return np.asarray(np.logical_or.reduce(attributable))


def _attributable(rule: str, name: str, bad: Bools, seen: Evidence) -> Bools:
    """Those of the wrong pixels of a quantity that a rule can be blamed for.

    The hit map shows a mistake in the screen only where no rays are given; t and what follows from
    it show one in S6 where nothing is hit; normals show one in S3 where they are the right ones in
    viewing coordinates.
    """
    if rule in _RAY_RULES and name == "hit":
        return bad & ("ray" not in seen.comparison.ratio)
    if rule in _RAY_RULES and name == "normal":
        return _in_viewing_coordinates(bad, seen)
    if rule == "S6" and name != "hit":
        return np.asarray(bad & ~seen.ours["hit"])
    return bad


def _in_viewing_coordinates(bad: Bools, seen: Evidence) -> Bools:
    """The wrong normals, where most of them are minirt's in the observer's axes; else none."""
    axes = np.concatenate(view_frame(seen.scene.screen)[:3], axis=1)
    off = np.abs(seen.theirs["normal"] - seen.ours["normal"] @ axes).max(axis=-1)
    alike = bad & (off <= _SAME_NORMAL)
    return alike if alike.sum() > bad.sum() / 2 else np.zeros_like(bad)
