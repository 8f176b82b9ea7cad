"""Which arrays a page holds when the budget does not cover all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reports.page.inspector.arrays import PackedArrays, arrays_within
from reports.page.inspector.details import Details
from reports.page.inspector.packing import pack
from reports.page.pictures import Span

RNG = np.random.default_rng(3)


def arrays(rounded: bool) -> PackedArrays:
    noise = pack(RNG.random((40, 40)), rounded=rounded)
    return PackedArrays(noise, noise, noise, None, Span(np.zeros(1), np.ones(1)))


ROUNDED, EXACT = arrays(True), arrays(False)
DETAILS = Details(arrays={"t": ROUNDED, "color": ROUNDED}, exact={"t": EXACT, "color": EXACT})
#: A reference whose colours are exact in float32.
HALF = replace(DETAILS, exact={"t": EXACT})
MORE = EXACT.size - ROUNDED.size


def test_within_the_budget_everything_is_exact() -> None:
    assert MORE > 0
    assert arrays_within([DETAILS, HALF]) == [DETAILS.exact, {"t": EXACT, "color": ROUNDED}]


def test_every_scene_has_its_arrays_before_any_is_exact() -> None:
    assert arrays_within([DETAILS] * 3, 6 * ROUNDED.size) == [DETAILS.arrays] * 3


def test_what_fails_first_is_exact_first_in_every_scene() -> None:
    chosen = arrays_within([DETAILS] * 2, 4 * ROUNDED.size + 3 * MORE)
    assert chosen == [DETAILS.exact, {"t": EXACT, "color": ROUNDED}]


def test_a_scene_beyond_the_budget_has_none() -> None:
    offered = [DETAILS, Details(), DETAILS]
    assert arrays_within(offered, 2 * ROUNDED.size) == [DETAILS.arrays, {}, {}]
