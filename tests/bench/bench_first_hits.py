"""First hits of primary rays, everybody on the same scenes: `make bench`."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bench_cases import CASES, SPHERES, count, scene_of
from bench_tracers import TRACERS, Tracer, some

import minirt

#: Rays whose t may differ from minirt's by more than single precision: those along edges.
_STRAY = 0.01


@pytest.mark.parametrize("tracer", TRACERS)
@pytest.mark.parametrize("case", CASES)
def test_first_hits(case: str, tracer: str, benchmark: Any) -> None:
    who = TRACERS[tracer]
    _skip_unless_it_can(who, case, tracer)
    scene = scene_of(case)
    rays = min(who.rays, scene.screen.nx * scene.screen.ny)
    trace = who.prepare(scene, rays)
    answer = benchmark.pedantic(trace, rounds=3, warmup_rounds=1)
    benchmark.extra_info.update(case=case, tracer=tracer, rays=rays, primitives=count(case))
    if answer is not None:
        expected = minirt.render(scene, quantities="t")["t"].ravel()[slice(*some(scene, rays))]
        near = np.isclose(answer, expected, rtol=1e-4, equal_nan=True)
        assert near.mean() > 1 - _STRAY


def _skip_unless_it_can(who: Tracer, case: str, name: str) -> None:
    lacking = who.lacking()
    if lacking:
        pytest.skip(f"{name}: {lacking}")
    most = who.most_spheres if case in SPHERES else who.most_triangles
    if count(case) > most:
        pytest.skip(f"{name}: at most {most:,} primitives of this kind")
