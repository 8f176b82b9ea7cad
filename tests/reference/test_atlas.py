"""minirt against its references on the atlas: one test a scene, reference and size of the image.

And against exact arithmetic: one test a scene and size.

Small images of the whole atlas and a few scenes at full size belong to the fast tier, the whole
atlas at full size to the rest. ``pytest -k 'glass and refraction'`` chooses by the name of a scene,
a reference or a quantity. References named in ``MINIRT_REQUIRE`` must be here.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np
import pytest

from converters.mitsuba.scene import unsupported_camera
from minirt import load_scene
from minirt.quantities import QUANTITIES
from minirt.scene_file.atlas import atlas_names
from reference.compare.check import Check, without_answer
from reference.exact.condition import BOUND
from reference.exact.sampling import SAMPLE
from reference.registry import REFERENCES
from reference.traceability import trace_rules
from tests.helpers.atlas_verdicts import (
    BY_SIZE,
    FULL,
    NAMES,
    REQUIRED,
    SCALAR,
    SMALL,
    USED,
    Verdicts,
    shared_verdicts,
)

#: On so small an image a rasteriser leaves fewer pixels certain than the floor asks for: these
#: scenes are all outlines. The fast tier compares them at full size.
TOO_FINE = {("nested-glass", "pyrender"), ("thousand-spheres", "pyrender")}
#: The scenes that the fast tier compares at full size.
FULL_IN_THE_FAST_TIER = {"nested-glass", "thousand-spheres", "glass-ball"}
#: The least share of the judged values that exact arithmetic must decide.
DECIDED = 0.97

BEYOND_THE_FIRST_HIT = {
    "shadow", "reflection", "reflection_object", "reflection_t",
    "tir", "refraction", "refraction_object", "refraction_t",
}  # fmt: skip
#: Every reason for which a quantity may stay uncompared, and the quantities it may stand for.
REASONS: dict[str, set[str]] = {
    r"Mitsuba's camera has square pixels only": set(NAMES),
    r"Mitsuba's aov integrator follows no ray beyond the first hit": BEYOND_THE_FIRST_HIT,
    r"Mitsuba's aov integrator has no channel for the ray": {"ray"},
    r"Mitsuba's aov integrator gives no colour of its own": {"color"},
    r"Mitsuba's materials have no α: its own alpha says whether anything was hit": {"alpha"},
    r"in Mitsuba a background that is not black lights the objects": {"color"},
    r"Mitsuba has no colour of shadows": {"color"},
    r"Mitsuba's radiance is the slides' for pure diffuse and pure mirrors only, not for '[^;]*'": {
        "color"
    },
    r"a rasteriser gives the object and the depth of each pixel": (
        set(NAMES) - {"hit", "object", "depth"}
    ),
    r"Embree has no camera: the rays are minirt's own": {"ray"},
    r"Embree does not shade": {"color"},
    r"Embree has no materials": {"alpha"},
    r"POV-Ray tells no directions: the positions of its hits lie along its rays": {"ray"},
    r"POV-Ray's triangles have no barycentric coordinates": {"barycentric"},
    r"POV-Ray has no α that changes nothing else": {"alpha"},
    r"the pictures drawn by POV-Ray tell of first hits: rays beyond them show in its colours": (
        BEYOND_THE_FIRST_HIT
    ),
}


def case(*words: str, scene: str, size: str) -> object:
    """A test's parameters, with its tier."""
    slow = size == FULL and scene not in FULL_IN_THE_FAST_TIER
    return pytest.param(*words, id="-".join(words), marks=[pytest.mark.full] if slow else [])


def comparisons() -> Iterator[object]:
    """A case for each scene, reference and size."""
    for scene in atlas_names():
        for size, references in BY_SIZE.items():
            for reference in references:
                if size == FULL or (scene, reference.name) not in TOO_FINE:
                    yield case(scene, reference.name, size, scene=scene, size=size)


def judgements() -> Iterator[object]:
    """A case for each scene and size."""
    for scene in atlas_names():
        for size in BY_SIZE:
            yield case(scene, size, scene=scene, size=size)


@pytest.fixture(scope="session")
def verdicts(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Verdicts]:
    """The verdict on a scene in a size; made once, whoever asks."""
    chosen = [
        (str(item.callspec.params["scene"]), str(item.callspec.params["size"]))
        for item in request.session.items
        if isinstance(item, pytest.Function) and item.originalname == test_minirt_agrees.__name__
    ]
    own = tmp_path_factory.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    with shared_verdicts(shared, tmp_path_factory.mktemp, chosen) as verdict:
        yield verdict


def test_every_required_reference_is_here() -> None:
    assert {r.name: r.missing() for r in REQUIRED if r.missing()} == {}


def test_a_reference_that_is_not_compared_says_what_brings_it() -> None:
    reasons = {name: r.missing() for name, r in REFERENCES.items()}
    assert {r.name for r in (*USED, SCALAR)} <= set(reasons)
    assert [n for n, why in reasons.items() if why and " install" not in why] == []


@pytest.mark.also_named(*NAMES)
@pytest.mark.parametrize(("scene", "reference", "size"), list(comparisons()))
def test_minirt_agrees(scene: str, reference: str, size: str, verdicts: Verdicts) -> None:
    checks = verdicts(scene, size).checks[reference]
    assert tuple(checks) == NAMES
    assert faults_of(checks.values()) == {}


def faults_of(checks: Iterable[Check]) -> dict[str, str]:
    """What is wrong, by quantity."""
    faults = {check.quantity: fault_of(check) for check in checks}
    return {quantity: fault for quantity, fault in faults.items() if fault}


def fault_of(check: Check) -> str:
    """What is wrong with the check of one quantity; empty where nothing is."""
    if check.state == "not supported":
        return "" if is_documented(check) else f"not documented: {check.reason}"
    if check.state != "passed":
        return f"{check.state}: {check.reason}; the worst: {check.worst}"
    if check.pixels <= 0 or check.wrong != 0:
        return f"{check.wrong} of {check.pixels} pixels are wrong"
    if check.certain < check.floor * check.pixels:
        return f"{check.certain} of {check.pixels} pixels are certain, the floor is {check.floor}"
    if check.quantity in ("hit", "depth", "shadow") and not is_similar(check):
        return f"the similarity is {check.ssim}, its floor {check.ssim_floor}"
    return "" if is_parallel(check) else f"an angle is too wide: {check.worst}"


def is_similar(check: Check) -> bool:
    """Whether the structural similarity of the two pictures reaches its floor."""
    return (
        check.ssim is not None and check.ssim_floor is not None and check.ssim >= check.ssim_floor
    )


def is_parallel(check: Check) -> bool:
    """Whether the worst of two directions are within the angle that the tolerance allows."""
    if QUANTITIES[check.quantity].kind != "direction" or check.worst is None:
        return True
    return angle(check.worst.ours, check.worst.theirs) <= largest_angle(check.worst.tolerance)


@pytest.mark.parametrize(("scene", "size"), list(judgements()))
def test_minirt_has_every_answer_that_is_certain(
    scene: str, size: str, verdicts: Verdicts, record_property: Callable[[str, object], None]
) -> None:
    """By exact arithmetic, at a sample of the pixels and at those where references are farthest."""
    judgement = verdicts(scene, size).judgement
    assert judgement.pixels >= SAMPLE
    assert judgement.convictions == ()
    for count in judgement.counts:
        assert count.agreed == count.decided >= 0, count
        # of a small image some quantities have a few dozen values only: all are taken together
        assert size == SMALL or count.decided >= DECIDED * count.judged, count
        assert count.ulps is None or count.ulps <= BOUND
    decided = sum(count.decided for count in judgement.counts)
    assert decided >= DECIDED * sum(count.judged for count in judgement.counts)
    worst = judgement.worst
    record_property("ulps", worst and worst.ulps)
    assert (worst is None) == (scene == "nothing-hit")
    # t errs by some half ulp of its condition in all; more would be news
    assert worst is None or worst.ulps is None or worst.ulps < 1


@pytest.mark.parametrize("size", [SMALL, pytest.param(FULL, marks=pytest.mark.full)])
def test_every_rule_is_shown_by_two_scenes_and_two_references(
    size: str, verdicts: Verdicts
) -> None:
    passed = [
        (scene, reference, quantity)
        for scene in atlas_names()
        for reference, checks in verdicts(scene, size).checks.items()
        for quantity, check in checks.items()
        if check.state == "passed" and check.compared
    ]
    traced = trace_rules([load_scene(f"atlas:{name}") for name in atlas_names()], passed)
    assert [row.rule for row in traced][:16] == [f"S{k}" for k in range(1, 17)]
    assert {row.rule: row.scenes for row in traced if len(row.scenes) < 2} == {}
    compared = {row.rule: {who for who, n in row.compared.items() if n >= 2} for row in traced}
    assert {rule: who for rule, who in compared.items() if len(who) < 2} == {}


def test_every_quantity_that_fails_is_listed() -> None:
    crashed = without_answer(["hit", "depth"], "crashed", "by signal 6")
    excused = without_answer(["ray"], "not supported", "Embree has no camera: the rays are "
                             "minirt's own")  # fmt: skip
    unknown = without_answer(["color"], "not supported", "not today")
    assert faults_of((*crashed, *excused, *unknown)) == {
        "hit": "crashed: by signal 6; the worst: None",
        "depth": "crashed: by signal 6; the worst: None",
        "color": "not documented: not today",
    }


def is_documented(check: Check) -> bool:
    """Whether each of the reasons is one of those above."""
    return all(
        any(re.fullmatch(p, reason) and check.quantity in names for p, names in REASONS.items())
        for reason in check.reason.split("; ")
    )


def angle(first: Sequence[float], second: Sequence[float]) -> float:
    """Between two vectors, in radians; 0 where neither is one. Well conditioned at 0."""
    a, b = (np.array(v) / math.hypot(*v) for v in (first, second))
    if np.isnan(a).all() and np.isnan(b).all():
        return 0.0
    return 2 * math.atan2(math.dist(a, b), math.dist(a, -b))


def largest_angle(tolerance: float) -> float:
    """The widest angle between a unit vector and one that lies within a distance of it."""
    return math.asin(min(tolerance, 1.0))


def test_only_the_scene_made_for_it_is_beyond_mitsubas_camera() -> None:
    beyond = [n for n in atlas_names() if unsupported_camera(load_scene(f"atlas:{n}").screen)]
    assert beyond == ["non-square-pixels"]


@pytest.mark.parametrize(
    ("quantity", "reason"),
    [
        ("hit", "Mitsuba's aov integrator follows no ray beyond the first hit"),
        ("barycentric", "Mitsuba's aov integrator follows no ray beyond the first hit"),
        ("depth", "Mitsuba's aov integrator gives no colour of its own"),
        ("color", "Mitsuba has no colour of shadows; not today"),
        ("color", ""),
        ("shadow", "not today"),
    ],
)
def test_an_excuse_that_is_not_documented_is_none(quantity: str, reason: str) -> None:
    (check,) = without_answer([quantity], "not supported", reason)
    assert not is_documented(check)


def test_an_angle_is_told_from_the_tolerance_that_forbids_it() -> None:
    tilted = [math.sin(1e-5), 0.0, math.cos(1e-5)]
    assert angle([0.0, 0.0, 2.0], tilted) == pytest.approx(1e-5, rel=1e-9)
    assert angle([0.0, 0.0, 1.0], tilted) > largest_angle(9.9e-6)
    assert angle([0.0, 0.0, 1.0], tilted) < largest_angle(1.01e-5)
