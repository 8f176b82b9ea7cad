"""The shapes of surfaces, and what slender triangles do to a renderer in single precision."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.geometry import Geometry
from minirt.hits import RayHits
from minirt.scene import Scene
from reference.compare.surfaces import Surfaces
from reference.jobs.isolate import Workers
from reference.renderers.mitsuba.source import MitsubaReference
from reference.verify.options import Options
from reference.verify.rendering import render_to_file
from reference.verify.scene import compare_scene
from tests.helpers.tiers import tiered

LENGTHS = ("t", "depth", "distance", "position")


def scene_of(objects: list[dict[str, Any]]) -> Scene:
    screen = {
        "P0": [0, 0, 8], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
        "l": -0.5, "r": 0.5, "b": -0.375, "t": 0.375, "nx": 128, "ny": 96,
    }  # fmt: skip
    return minirt.load_scene({
        "minirt": 1, "name": "test", "screen": screen, "light": {"direction": [-1, -2, -3]},
        "materials": {"paint": {}}, "objects": [each | {"material": "paint"} for each in objects],
    })  # fmt: skip


def slivers(seed: int) -> Scene:
    """120 triangles some six long and between 1e-5 and 1e-2 high."""
    rng = np.random.default_rng(seed)
    objects = []
    for _ in range(120):
        middle, half, aside = rng.normal(size=(3, 3)) * [[1], [3], [10 ** rng.uniform(-5, -2)]]
        third = middle + half * rng.uniform(-1, 1) + aside
        vertices = np.stack((middle - half, middle + half, third)).tolist()
        objects.append({"type": "triangle", "vertices": vertices})
    return scene_of(objects)


@pytest.fixture(scope="module")
def workers() -> Iterator[Workers]:
    """A process in which Mitsuba starts once."""
    with Workers(1) as pool:
        yield pool


@pytest.mark.parametrize("seed", tiered(range(3), lambda seed: seed == 0))
def test_mitsubas_rounding_on_slender_triangles_is_no_alarm(
    seed: int, workers: Workers, tmp_path: Path
) -> None:
    """Its t there is up to 50 times the δ that is right for other shapes."""
    scene = slivers(seed)
    mitsuba = MitsubaReference()
    outcome = workers.submit(120, render_to_file, mitsuba, scene, tmp_path).outcome()
    assert outcome.state == "done", outcome.output
    verdict = compare_scene(scene, [(mitsuba, outcome.value)], Options(LENGTHS))
    checks = verdict.references[mitsuba.name].checks
    assert [(check.quantity, check.wrong, check.worst) for check in checks if check.wrong] == []
    assert min(check.compared for check in checks) > 50


def test_the_shape_of_what_is_hit() -> None:
    scene = scene_of([
        {"type": "sphere", "center": [0, 0, 0], "radius": 2.0},
        {"type": "triangle", "vertices": [[0, 0, 0], [5, 0, 0], [0, 0.5, 0]]},
        {"type": "polygon", "vertices": [[0, 0, 0], [3, 0, 0], [3, 4, 0], [0, 4, 0]]},
    ])  # fmt: skip
    geometry = Geometry.of(scene)
    number = np.array([0, 1, 2, 2, -1], dtype=np.int32)
    face = np.array([0, 0, 0, 1, -1], dtype=np.int32)
    nan = np.full(5, np.nan)
    hits = RayHits(nan, number, face, nan, nan)
    surfaces = Surfaces.of(geometry, 10.0)
    long = np.sqrt(25.25)
    assert surfaces.levers.at(hits) == pytest.approx([2, 2.5 / long, 2.4, 2.4, np.inf])
    aspect, size = surfaces.shape(hits)
    assert aspect == pytest.approx([0, 25.25 / 2.5, 5 / 2.4, 5 / 2.4, 0])
    assert size == pytest.approx([0, long / 10, 0.5, 0.5, 0])
