"""Traceability: which scenes, quantities and references test each rule."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from minirt.quantities import QUANTITIES
from minirt.rules import Rules
from minirt.scene import Scene
from reference.verify.results import SceneResult

#: The rules that a run has to test, and the two departures that change an image.
TRACED = (*(f"S{k}" for k in range(1, 17)), "E1", "E2")
#: The quantities that test the departures, which no quantity names, and the camera, whose rays
#: also show in what they hit.
_JUDGED_BY = {"E1": ("refraction",), "E2": ("tir",)} | dict.fromkeys(
    ("S1", "S2", "S3"), ("ray", "hit")
)
#: References that are given minirt's own rays do not test the camera.
_WITHOUT_CAMERA = {rule: frozenset({"embree"}) for rule in ("S1", "S2", "S3")}

#: A scene, a reference and a quantity that was compared and passed.
Passed = tuple[str, str, str]


@dataclass(frozen=True)
class RuleTrace:
    """What tests one rule.

    Attributes
    ----------
    rule : str
    functions : tuple of str
        The entries of `minirt.rules.Rules` that are this rule.
    quantities : tuple of str
        The quantities that test it.
    scenes : tuple of str
        Scenes that state that they exercise it.
    compared : dict of str to int
        By reference: the number of those scenes that it confirmed in one of those quantities, at
        pixels with a value.
    checked : dict of str to int
        By quantity: the number of those scenes on which a reference confirmed it, at such pixels.
    """

    rule: str
    functions: tuple[str, ...]
    quantities: tuple[str, ...]
    scenes: tuple[str, ...]
    compared: dict[str, int]
    checked: dict[str, int]


def without_camera(rule: str, reference: str) -> bool:
    """Whether a reference does not test a rule, because it is given minirt's own rays."""
    return reference in _WITHOUT_CAMERA.get(rule, frozenset())


def trace_rules(scenes: Sequence[Scene], passed: Iterable[Passed] = ()) -> tuple[RuleTrace, ...]:
    """One row for each rule, S1–S16, E1 and E2; `passed` is what a run has really compared."""
    every = frozenset(passed)
    return tuple(_trace(rule, scenes, every) for rule in TRACED)


def passed_in(results: Iterable[SceneResult]) -> Iterable[Passed]:
    """What a run has compared: checks that passed on at least one pixel with a value."""
    for result in results:
        for answer in result.references:
            for check in answer.checks:
                if check.state == "passed" and check.compared:
                    yield result.scene.name, answer.reference, check.quantity


def _trace(rule: str, scenes: Sequence[Scene], passed: frozenset[Passed]) -> RuleTrace:
    listed = tuple(scene.name for scene in scenes if rule in scene.rules)
    quantities = _JUDGED_BY.get(rule) or tuple(
        q.name for q in QUANTITIES.values() if rule in q.rules
    )
    cells = [
        (scene, who, quantity)
        for scene, who, quantity in passed
        if scene in listed and quantity in quantities and not without_camera(rule, who)
    ]
    confirmed = {(who, scene) for scene, who, _ in cells}
    shown = {(quantity, scene) for scene, _, quantity in cells}
    return RuleTrace(
        rule,
        tuple(f.name for f in dataclasses.fields(Rules) if f.metadata["rule"] == rule),
        quantities,
        listed,
        {who: sum(w == who for w, _ in confirmed) for who in sorted({w for w, _ in confirmed})},
        {name: sum(q == name for q, _ in shown) for name in quantities},
    )
