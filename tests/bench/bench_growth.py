"""What minirt's own time grows with, one thing after the other: `make bench`."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.culling import SceneIndex
from minirt.geometry import Geometry
from minirt.rays import Rays
from minirt.rules import SLIDES
from minirt.trace import RT, World
from tests.bench.bench_cases import BALLS, INCOHERENT, count, image_scene, incoherent_rays, scene_of
from tests.bench.bench_timing import timed

#: Loads and renders a scene in a process of its own, and prints the most memory that it had.
_MEMORY = """
import sys, minirt
minirt.render(minirt.load_scene(sys.argv[1]), quantities="t")
(line,) = (line for line in open("/proc/self/status") if line.startswith("VmHWM:"))
print(int(line.split()[1]) * 1024)
"""

_ONE_RAY = Rays.of(np.zeros((3, 1)), np.ones((3, 1))), np.full(1, np.inf)


def _rays(n: int) -> Callable[[], object]:
    scene = scene_of(INCOHERENT)
    P0, d = incoherent_rays(scene, n)
    world = World.of(Geometry.of(scene), SLIDES)
    return lambda: RT(world, Rays.of(P0, d))


def _depth(n: int) -> Callable[[], object]:
    document = minirt.load_scene("atlas:hall-of-mirrors").to_dict()
    scene = minirt.load_scene({**document, "max_depth": n})
    return lambda: minirt.render(scene, quantities="color")


def _pixels(n: int) -> Callable[[], object]:
    height = round((n * 3 / 4) ** 0.5)
    scene = image_scene(25, (n // height, height))
    return lambda: minirt.render(scene, quantities="color")


def _scenes(n: int) -> Callable[[], object]:
    def every() -> None:
        for seed in range(n):
            minirt.render(image_scene(25, (64, 48), seed))

    return every


def _tree(case: str) -> Callable[[], object]:
    scene = scene_of(case)

    def build() -> object:
        geometry = Geometry.of(replace(scene))  # a scene that nobody has seen yet
        (triangles,) = SceneIndex.of(geometry).kinds
        return triangles.tree, triangles.bounding_test(*_ONE_RAY, 0.0)

    return build


GROWTH: list[tuple[str, int, Callable[[], Callable[[], object]]]] = [
    *(("rays without order", n, lambda n=n: _rays(n)) for n in (1_000, 4_000, 16_000, 64_000)),
    *(("recursion depth", n, lambda n=n: _depth(n)) for n in (1, 2, 4, 8, 16)),
    *(("pixels", n, lambda n=n: _pixels(n)) for n in (3_072, 12_288, 49_152, 196_608, 786_432)),
    *(("scenes", n, lambda n=n: _scenes(n)) for n in (1, 2, 4, 8, 16)),
]  # fmt: skip


@pytest.mark.parametrize(("over", "n", "prepare"), GROWTH, ids=[f"{o}, {n}" for o, n, _ in GROWTH])
def test_growth(
    over: str, n: int, prepare: Callable[[], Callable[[], object]], benchmark: Any
) -> None:
    timed(benchmark, prepare())
    benchmark.extra_info.update(over=over, size=n)


@pytest.mark.parametrize("case", BALLS)
def test_tree(case: str, benchmark: Any) -> None:
    timed(benchmark, _tree(case))
    benchmark.extra_info.update(over="triangles, their tree built", size=count(case))


def test_memory(benchmark: Any) -> None:
    scene = scene_of(list(BALLS)[-1])
    file = scene.folder / "scene.json"
    file.write_text(scene.canonical_json, encoding="utf-8")
    command = [sys.executable, "-c", _MEMORY, str(file)]
    said = benchmark.pedantic(subprocess.check_output, (command,), {"text": True}, rounds=1)
    assert int(said) > 0
    benchmark.extra_info.update(memory=int(said))
