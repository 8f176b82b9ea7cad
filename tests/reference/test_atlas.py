"""minirt against its references on the atlas: one test a scene, reference and quantity.

And against exact arithmetic: one test a scene.

``pytest -k 'glass and refraction'`` runs what it says. A scene is rendered once for all its
quantities, in a child process that stays for the whole session; what came out is kept in a file,
which pytest-xdist's workers share: while one is at a scene, another goes on with the next.
References named in ``MINIRT_REQUIRE`` must be here.
"""

from __future__ import annotations

import fcntl
import math
import os
import pickle
import re
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from converters.mitsuba.scene import camera_fault
from minirt import load_scene
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from minirt.scene_file.atlas import atlas_names
from reference.compare.check import Check, without_answer
from reference.exact import Judgement
from reference.exact.choice import SAMPLE
from reference.exact.condition import BOUND
from reference.jobs.isolate import Workers
from reference.registry import REFERENCES, USUAL, choose_references
from reference.source import Reference, Unsupported
from reference.traceability import trace_rules
from reference.verify.options import TIMEOUT
from reference.verify.rendering import render_to_file
from reference.verify.scene import compare_scene


class Verdict(NamedTuple):
    """The checks of one scene, by reference and quantity, and minirt before the judge."""

    checks: dict[str, dict[str, Check]]
    judgement: Judgement


Verdicts = Callable[[str, bool], Verdict]

REQUIRED = choose_references(
    name.strip() for name in os.environ.get("MINIRT_REQUIRE", "").split(",") if name.strip()
)
#: Compared on the whole atlas, as minirt verify does.
USED = tuple(r for r in choose_references(USUAL) if r in REQUIRED or not r.missing())
#: Mitsuba's scalar variant runs pixel by pixel: some scenes, smaller.
SCALAR = choose_references(["mitsuba-scalar"])[0]
SCALAR_SCENES = ("ball-on-quad", "glass-ball", "everything", "non-square-pixels")
SCALAR_SIZE = {"nx": 64, "ny": 48}

NAMES = tuple(QUANTITIES)
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


def cells() -> Iterator[object]:
    """A case for each scene, reference and quantity; small pictures for the slow variant."""
    scalar = [SCALAR] if SCALAR in REQUIRED or not SCALAR.missing() else []
    for scene in atlas_names():
        small = scalar if scene in SCALAR_SCENES and SCALAR not in USED else []
        for reference in (*USED, *small):
            for quantity in NAMES:
                label = f"{scene}-{reference.name}-{quantity}"
                yield pytest.param(scene, reference.name, quantity, id=label)


@pytest.fixture(scope="session")
def verdicts(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Verdicts]:
    """What is found of a scene, full or small; made once."""
    chosen = dict.fromkeys(
        str(item.callspec.params["scene"])
        for item in request.session.items
        if isinstance(item, pytest.Function) and item.originalname == test_minirt_agrees.__name__
    )
    own = tmp_path_factory.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    with Workers(1) as workers:

        def kept(name: str, small: bool) -> Path:
            return shared / f"{name}-{'small' if small else 'full'}.pickle"

        def make(name: str, small: bool, wait: bool = False) -> bool:
            """Whether it is made by now: if not, another worker is at it."""
            with kept(name, small).with_suffix(".lock").open("w") as lock:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
                except BlockingIOError:
                    return False
                if not kept(name, small).exists():
                    found = compared(name, small, workers, tmp_path_factory.mktemp(name))
                    kept(name, small).write_bytes(pickle.dumps(found))
            return True

        @cache
        def of(name: str, small: bool) -> Verdict:
            for other in chosen:
                if make(name, small):
                    break
                make(other, False)  # meanwhile, what nobody has begun
            make(name, small, wait=True)
            result: Verdict = pickle.loads(kept(name, small).read_bytes())  # noqa: S301 - this file's own
            return result

        yield of


def compared(name: str, small: bool, workers: Workers, folder: Path) -> Verdict:
    """Render and judge one scene, or a small picture of it with the slow variant."""
    scene = load_scene(f"atlas:{name}")
    if not small:
        return judged(scene, USED, workers, folder)
    document = scene.to_dict()
    document["screen"] |= SCALAR_SIZE
    return judged(load_scene(document, scene.folder), (SCALAR,), workers, folder)


def judged(
    scene: Scene, references: tuple[Reference, ...], workers: Workers, folder: Path
) -> Verdict:
    answers, checks = [], {}
    for reference in references:
        room = folder / reference.name
        room.mkdir()
        outcome = workers.submit(TIMEOUT, render_to_file, reference, scene, room).outcome()
        if outcome.state == "done":
            answers.append((reference, outcome.value))
        elif isinstance(outcome.value, Unsupported):
            checks[reference.name] = without_answer(NAMES, "not supported", str(outcome.value))
        else:
            reason = f"{outcome.reason}\n{outcome.output}"
            checks[reference.name] = without_answer(NAMES, "crashed", reason)
    verdict = compare_scene(scene, answers)
    checks |= {name: found.checks for name, found in verdict.references.items()}
    by_quantity = {
        name: {check.quantity: check for check in found} for name, found in checks.items()
    }
    return Verdict(by_quantity, verdict.judgement)


def test_every_required_reference_is_here() -> None:
    assert {r.name: r.missing() for r in REQUIRED if r.missing()} == {}


def test_a_reference_that_is_not_compared_says_what_brings_it() -> None:
    reasons = {name: r.missing() for name, r in REFERENCES.items()}
    assert {r.name for r in (*USED, SCALAR)} <= set(reasons)
    assert [n for n, why in reasons.items() if why and " install" not in why] == []


@pytest.mark.parametrize(("scene", "reference", "quantity"), list(cells()))
def test_minirt_agrees(scene: str, reference: str, quantity: str, verdicts: Verdicts) -> None:
    small = reference == SCALAR.name and SCALAR not in USED
    check = verdicts(scene, small).checks[reference][quantity]
    if check.state == "not supported":
        assert is_documented(check), check.reason
        return
    assert check.state == "passed", f"{check.reason}\n{check.worst}"
    assert check.pixels > 0
    assert check.wrong == 0
    assert check.certain >= check.floor * check.pixels
    if quantity in ("hit", "depth", "shadow"):
        assert check.ssim is not None
        assert check.ssim_floor is not None
        assert check.ssim >= check.ssim_floor
    if QUANTITIES[quantity].kind == "direction" and check.worst is not None:
        assert angle(check.worst.ours, check.worst.theirs) <= largest_angle(check.worst.tolerance)


@pytest.mark.parametrize("name", atlas_names())
def test_minirt_has_every_answer_that_is_certain(
    name: str, verdicts: Verdicts, record_property: Callable[[str, object], None]
) -> None:
    """By exact arithmetic, at a sample of the pixels and at those where references are farthest."""
    judgement = verdicts(name, False).judgement
    assert judgement.pixels >= SAMPLE
    assert judgement.convictions == ()
    for count in judgement.counts:
        assert count.agreed == count.decided >= 0.97 * count.judged, count
        assert count.ulps is None or count.ulps <= BOUND
    worst = judgement.worst
    record_property("ulps", worst and worst.ulps)
    assert (worst is None) == (name == "nothing-hit")
    # t errs by some half ulp of its condition in all; more would be news
    assert worst is None or worst.ulps is None or worst.ulps < 1


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
    beyond = [n for n in atlas_names() if camera_fault(load_scene(f"atlas:{n}").screen)]
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


def test_every_rule_is_shown_by_two_scenes_and_two_references(verdicts: Verdicts) -> None:
    passed = [
        (scene, reference, quantity)
        for scene in atlas_names()
        for reference, checks in verdicts(scene, False).checks.items()
        for quantity, check in checks.items()
        if check.state == "passed" and check.compared
    ]
    traced = trace_rules([load_scene(f"atlas:{name}") for name in atlas_names()], passed)
    assert [row.rule for row in traced][:16] == [f"S{k}" for k in range(1, 17)]
    assert {row.rule: row.scenes for row in traced if len(row.scenes) < 2} == {}
    compared = {row.rule: {who for who, n in row.compared.items() if n >= 2} for row in traced}
    assert {rule: who for rule, who in compared.items() if len(who) < 2} == {}
