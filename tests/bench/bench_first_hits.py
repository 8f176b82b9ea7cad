"""First hits and whole images, everybody on the same scenes: `make bench`."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import minirt
from minirt.vectors import Floats
from tests.bench.bench_cases import (
    BALLS,
    CASES,
    IMAGES,
    INCOHERENT,
    SPHERES,
    count,
    incoherent_rays,
    scene_of,
)
from tests.bench.bench_timing import timed
from tests.bench.bench_tracers import TRACERS, Tracer, some

#: Rays whose t may differ from minirt's by more than single precision: those along edges.
_STRAY = 0.01

_EVERYBODY = pytest.mark.parametrize("tracer", TRACERS)


@_EVERYBODY
@pytest.mark.parametrize("case", CASES)
def test_first_hits(case: str, tracer: str, benchmark: Any) -> None:
    who = TRACERS[tracer]
    _skip_unless_it_can(who, case, tracer)
    scene = scene_of(case)
    rays = min(max(who.rays, who.pairs // count(case)), scene.screen.nx * scene.screen.ny)
    answer = timed(benchmark, who.prepare(scene, rays))
    kind = "spheres" if case in SPHERES else "triangles" if case in BALLS else "mesh"
    _note(benchmark, case, tracer, kind, rays, count(case))
    expected = minirt.render(scene, quantities="t")["t"].ravel()[some(scene, rays)]
    _judge(answer, expected)


@_EVERYBODY
def test_incoherent_rays(tracer: str, benchmark: Any) -> None:
    who, scene = TRACERS[tracer], scene_of(INCOHERENT)
    _skip_unless_it_can(who, INCOHERENT, tracer)
    if who.shoot is None:
        pytest.skip(f"{tracer}: takes no rays that are not an image's")
    rays = min(who.rays, 100_000)
    P0, d = (np.ascontiguousarray(each.T) for each in incoherent_rays(scene, rays))
    first_hits = who.shoot(scene)
    answer = timed(benchmark, first_hits, P0, d)
    _note(benchmark, "mesh, 82k, no order", tracer, "incoherent", rays, count(INCOHERENT))
    _judge(answer, minirt.RT(scene, P0.T, d.T).t)


@_EVERYBODY
@pytest.mark.parametrize("case", IMAGES)
def test_whole_images(case: str, tracer: str, benchmark: Any) -> None:
    who, scene = TRACERS[tracer], scene_of(case)
    _skip_unless_it_can(who, case, tracer)
    if who.draw is None:
        pytest.skip(f"{tracer}: does not shade by these rules")
    timed(benchmark, who.draw(scene))
    pixels = scene.screen.nx * scene.screen.ny
    _note(benchmark, case, tracer, "image", pixels, count(case))


def _note(benchmark: Any, case: str, tracer: str, kind: str, rays: int, primitives: int) -> None:
    benchmark.extra_info.update(
        case=case, tracer=tracer, kind=kind, rays=rays, primitives=primitives
    )


def _judge(answer: Floats | None, expected: Floats) -> None:
    """Whoever tells lengths tells the right ones."""
    if answer is not None:
        near = np.isclose(answer, expected, rtol=1e-4, equal_nan=True)
        assert near.mean() > 1 - _STRAY


def _skip_unless_it_can(who: Tracer, case: str, name: str) -> None:
    lacking = who.lacking()
    if lacking:
        pytest.skip(f"{name}: {lacking}")
    most = who.most_spheres if case in SPHERES else who.most_triangles
    if count(case) > most:
        pytest.skip(f"{name}: at most {most:,} primitives of this kind")
