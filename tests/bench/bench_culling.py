"""What each mechanism of the culling is worth: the time without it over the time with it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, TypeAlias

import numpy as np
import pytest

import minirt
from converters.placement import fitted_placement
from minirt import culling
from minirt.culling import candidates, tree
from minirt.culling.bounding_tests import BoundingTest
from minirt.culling.occlusion import OcclusionMap
from minirt.geometry import Geometry
from minirt.rays import Rays
from minirt.rules import SLIDES
from minirt.trace import RT, World
from minirt.vectors import Floats, Index
from reference.compare.stability import measure
from reference.renderers.embree.errors import declared
from tests.bench.bench_cases import GLASS, IMAGES, INCOHERENT, incoherent_rays, scene_of
from tests.bench.bench_timing import times_without

#: Switches one mechanism off.
Switch: TypeAlias = Callable[[pytest.MonkeyPatch], None]


def _without_cells(patch: pytest.MonkeyPatch) -> None:
    def every_pixel(
        index: object, nx: int, ny: int, rays_of: object
    ) -> Iterator[tuple[Index, int]]:
        return ((pixels, nx * ny) for pixels in culling.squares(nx, ny))

    patch.setattr(sys.modules["minirt.render"], "visible_pixels", every_pixel)


def _without_bounding_tests(patch: pytest.MonkeyPatch) -> None:
    def all_pass(test: BoundingTest, rays: slice, primitives: Index) -> Any:
        return np.ones((len(primitives), 1), dtype=np.bool_)

    for test in BoundingTest.__subclasses__():
        patch.setattr(test, "all_pairs", all_pass)


def _without_tree(patch: pytest.MonkeyPatch) -> None:
    def every_pair(
        tree: tree.Tree, rays: Rays, t_max: Floats, pad: float
    ) -> Iterator[tuple[Index, Index]]:
        primitives = np.unique(tree.primitives)
        for ray in range(rays.count):
            yield np.full(len(primitives), ray), primitives

    patch.setattr(candidates, "visit", every_pair)


def _without_rasteriser(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(candidates._Search, "_rasteriser", lambda search, kind, reach: None)


def _without_occlusion(patch: pytest.MonkeyPatch) -> None:
    def hides(occlusion: OcclusionMap, u: Floats, *rest: Floats) -> Any:
        return np.zeros(u.shape, dtype=np.bool_)

    patch.setattr(OcclusionMap, "hides", hides)


def _without_one_point(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(candidates, "_POINT", -1.0)


def _without_single_precision(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(tree, "precision", lambda share, pad: np.float64)


def _first_hits(case: str) -> Callable[[], object]:
    scene = scene_of(case)
    return lambda: minirt.render(scene, quantities="t")


def _image(case: str) -> Callable[[], object]:
    scene = scene_of(case)
    return lambda: minirt.render(scene, quantities="color")


def _no_order(rays: int) -> Callable[[], object]:
    scene = scene_of(INCOHERENT)
    world, some = World.of(Geometry.of(scene), SLIDES), Rays.of(*incoherent_rays(scene, rays))
    return lambda: RT(world, some)


def _stability() -> Callable[[], object]:
    scene = scene_of("mesh, 5k")
    error = declared(scene, fitted_placement(scene))
    return lambda: measure(scene, error, "hit,depth")


_NO_ORDER = f"{INCOHERENT}, no order"
#: By mechanism: how to switch it off, and the rows in which it has a part.
MECHANISMS: dict[str, tuple[Switch, dict[str, Callable[[], Callable[[], object]]]]] = {
    "image cells": (
        _without_cells,
        {case: partial(_first_hits, case) for case in ("1 sphere", "10 spheres")},
    ),
    "bounding tests": (
        _without_bounding_tests,
        {
            "10 spheres": partial(_first_hits, "10 spheres"),
            **{case: partial(_image, case) for case in IMAGES},
        },
    ),
    "tree": (_without_tree, {_NO_ORDER: partial(_no_order, 200)}),
    "float32": (
        _without_single_precision,
        {_NO_ORDER: partial(_no_order, 100_000), GLASS: partial(_image, GLASS)},
    ),
    "rasteriser": (
        _without_rasteriser,
        {
            **{c: partial(_first_hits, c) for c in ("10k spheres", "mesh, 82k", "mesh, 328k")},
            GLASS: partial(_image, GLASS),
        },
    ),
    "occlusion": (_without_occlusion, {"mesh, 1.3M": partial(_first_hits, "mesh, 1.3M")}),
    "one point": (_without_one_point, {"stability, mesh, 5k": _stability}),
}


@pytest.mark.parametrize(
    ("mechanism", "row"), [(name, row) for name, (_, rows) in MECHANISMS.items() for row in rows]
)
def test_without(mechanism: str, row: str, benchmark: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    switch, rows = MECHANISMS[mechanism]
    call = rows[row]()
    ratio = times_without(call, lambda: switch(monkeypatch), monkeypatch.undo)
    benchmark.pedantic(call, rounds=1)
    benchmark.extra_info.update(without=mechanism, row=row, ratio=ratio)
    assert ratio > 0
