"""Fuzzing: scenes that are always the same, and failures that become small."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

import minirt
from minirt import load_scene
from minirt.scene import Scene
from reference.fuzz.campaign import (
    CAMPAIGN_FLOOR,
    Campaign,
    CampaignOptions,
    drawn_scene,
    run_campaign,
)
from reference.fuzz.candidates import rounded, roundings, windows, without_objects
from reference.fuzz.placements import PLACEMENTS
from reference.fuzz.scenes import mesh_folder, scene_document
from reference.fuzz.shrink import shrink
from reference.fuzz.transform import transformed
from reference.fuzz.trial import TrialWorkers
from tests.helpers.fake_references import (
    Aborting,
    Honest,
    InsideOut,
    Missing,
    Silent,
    Transparent,
    Undeclared,
)
from tests.helpers.tiers import tiered

DRAWN = 120


@cache
def drawn() -> tuple[dict[str, Any], ...]:
    return tuple(scene_document(3, number) for number in range(DRAWN))


@cache
def loaded() -> tuple[Scene, ...]:
    return tuple(load_scene(document, folder=mesh_folder()) for document in drawn())


@pytest.fixture(scope="module")
def workers() -> Iterator[TrialWorkers]:
    with TrialWorkers() as workers:
        yield workers


def forty_objects() -> Scene:
    """39 spheres over a floor; the one in the middle is called odd."""
    spheres = [
        {
            "type": "sphere", "name": "odd" if k == 19 else f"ball-{k}", "material": f"m{k % 3}",
            "center": [0.93 * (k % 8) - 3.3, 0.617 + 0.01 * k, 0.931 * (k // 8) - 2.0],
            "radius": 0.31 + 0.001 * k,
        }
        for k in range(39)
    ]  # fmt: skip
    floor = [[-9.1, 0.0, 9.3], [9.2, 0.0, 9.4], [9.0, 0.0, -9.2], [-9.3, 0.0, -9.1]]
    return load_scene(
        {
            "minirt": 1,
            "name": "forty",
            "screen": {
                "look_at": {
                    "eye": [0.3, 7.2, 6.1], "target": [0.1, 0, 0], "up": [0, 1, 0], "fov_y": 50,
                },
                "nx": 64,
                "ny": 48,
            },
            "light": {"direction": [-0.31, -1.7, -0.23], "color": [1.0, 0.9, 0.8]},
            "materials": {f"m{k}": {"diffuse": [0.1 * k + 0.123, 0.5, 0.5]} for k in range(3)},
            "objects": [*spheres, {"type": "polygon", "material": "m0", "vertices": floor}],
        }
    )  # fmt: skip


@pytest.mark.full
def test_scene_of_a_seed_is_the_same_in_every_process() -> None:
    code = (
        "import json, sys, reports.cli.main, reference.verify.run\n"
        "from reference.fuzz.scenes import scene_document\n"
        "print(json.dumps([scene_document(3, k) for k in (110, 2)]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == [drawn()[110], drawn()[2]]


def test_scenes_of_a_campaign_differ_and_so_do_those_of_another() -> None:
    texts = {json.dumps(document | {"name": ""}) for document in drawn()}
    others = {json.dumps(scene_document(4, number) | {"name": ""}) for number in range(5)}
    assert len(texts | others) == DRAWN + 5


def test_all_kinds_and_placements_occur() -> None:
    things = [thing for scene in loaded() for thing in scene.objects]
    kinds = Counter(thing.type for thing in things)
    placements = Counter(thing.name.split("-")[0] for thing in things)
    assert set(kinds) == {"sphere", "triangle", "polygon", "mesh"}
    assert set(placements) == set(PLACEMENTS)
    assert min(kinds.values()) >= 15
    assert min(placements.values()) >= 25


def test_all_materials_and_screens_occur() -> None:
    materials = [m for scene in loaded() for m in scene.materials.values()]
    assert sum(m.transmittance > 0 for m in materials) >= 20
    assert sum(m.reflectance > 0 and m.ior is None for m in materials) >= 20
    screens = [scene.screen for scene in loaded()]
    hands = Counter(float(np.linalg.det([s.u, s.v, s.n])) > 0 for s in screens)
    signs = Counter(s.nu > 0 for s in screens)
    assert min(*hands.values(), *signs.values()) >= 40
    sides = [((s.r - s.l) / s.nx) / ((s.t - s.b) / s.ny) for s in screens]
    assert sum(abs(side - 1) > 1e-6 for side in sides) >= 5


def test_scales_span_many_orders_of_magnitude() -> None:
    extents = [scene.extent for scene in loaded()]
    assert max(extents) / min(extents) > 1e9


def test_moved_scene_has_the_same_image() -> None:
    document = drawn()[5]
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    there = load_scene(transformed(document, turn, 2.0, np.zeros(3)), folder=mesh_folder())
    ours, theirs = (minirt.render(scene) for scene in (loaded()[5], there))
    assert (ours["object"] == theirs["object"]).mean() > 0.999
    assert ours["hit"].any()
    depth = ours["depth"], theirs["depth"] / 2
    both = np.isfinite(depth[0]) & np.isfinite(depth[1])
    np.testing.assert_allclose(depth[0][both], depth[1][both], rtol=1e-6)


def test_window_keeps_the_ray_of_its_pixel() -> None:
    scene = forty_objects()
    whole = minirt.render(scene)
    sizes = []
    for document in windows(scene.to_dict(), 63, 20):
        small = load_scene(document)
        sizes.append(small.screen.nx)
        ray = minirt.render(small, quantities=["ray"])["ray"]
        off = np.abs(ray - whole["ray"][20, 63]).max(axis=2)
        assert off.min() < 1e-14
    assert sizes == [1, 2, 4, 8]


def test_dropping_objects_drops_their_materials() -> None:
    left = without_objects(forty_objects().to_dict(), 1, 39)
    assert [entry["name"] for entry in left["objects"]] == ["ball-0"]
    assert list(left["materials"]) == ["m0"]


def test_rounding_reaches_single_numbers() -> None:
    document = without_objects(forty_objects().to_dict(), 1, 39)
    tried = [rounding(document) for rounding in roundings(document)]
    radii = {each["objects"][0]["center"][0] for each in tried}
    assert radii >= {-3.3, -3.0}
    assert rounded([0.0, -123.4, 7], 2) == [0.0, -120.0, 7]


@pytest.mark.parametrize(
    ("reference", "stage", "objects"),
    tiered(
        [(InsideOut(only="odd"), "normal", 1), (Transparent(only="odd"), "shadow", 2)],
        lambda case: case[1] == "normal",
    ),
)
def test_a_planted_fault_shrinks(
    reference: InsideOut | Transparent, stage: str, objects: int, workers: TrialWorkers
) -> None:
    scene = forty_objects()
    trial = workers.trial(scene, reference)
    assert (trial.state, trial.stage) == ("failed", stage)
    small = shrink(scene, trial, partial(workers.trial, reference=reference), 60)
    assert len(scene.objects) == 40
    assert len(small.scene.objects) == objects
    assert "odd" in {thing.name for thing in small.scene.objects}
    assert small.scene.screen.nx <= 8
    assert small.scene.screen.ny <= 8
    assert small.seconds < 60
    assert (small.trial.state, small.trial.stage) == ("failed", stage)
    again = workers.trial(small.scene, reference)
    assert again == small.trial
    assert workers.trial(small.scene, Honest()).state == "passed"
    assert len(small.scene.canonical_json) < len(scene.canonical_json) / 4


@cache
def honest() -> Campaign:
    return run_campaign(5, [Honest(), Missing()], CampaignOptions(60))


@pytest.mark.full
def test_an_honest_subject_raises_no_alarm() -> None:
    assert honest().failures == ()
    assert honest().unjudged == ()
    assert (honest().scenes, honest().compared, honest().unsupported) == (60, 60, 0)


@pytest.mark.full
def test_enough_pixels_are_certain_and_a_missing_reference_is_named() -> None:
    assert CAMPAIGN_FLOOR <= honest().certain_share <= 1
    assert not honest().vague
    assert dict(honest().missing).keys() == {"missing"}


def test_a_campaign_that_certifies_little_is_vague() -> None:
    assert Campaign(1, certain=89, judged=100).vague
    assert not Campaign(1, certain=90, judged=100).vague


def test_a_crash_and_silence_are_told_apart(workers: TrialWorkers) -> None:
    scene = drawn_scene(3, 0)
    crash, silence = workers.trials(scene, [Aborting(), Silent()])
    assert (crash.state, crash.stage) == ("failed", "crashed")
    assert "LLVM ERROR" in crash.output
    assert silence.state == "not supported"


def test_why_a_scene_was_not_judged_is_said_once(workers: TrialWorkers) -> None:
    found = run_campaign(3, [Undeclared(), Undeclared("twin")], CampaignOptions(2), workers=workers)
    assert (found.scenes, found.compared, found.failures) == (2, 0, ())
    why = "minirt itself failed: ValueError: no error is known"
    assert [reason.partition(": ")[2] for reason in found.unjudged] == [why, why]


def test_time_ends_a_campaign(workers: TrialWorkers) -> None:
    found = run_campaign(3, [Honest()], CampaignOptions(1000, 0.5), workers=workers)
    assert 1 <= found.scenes < 100
