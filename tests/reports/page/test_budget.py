"""Which arrays a page holds when there is not room for all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reports.page.arrays import pack
from reports.page.budget import arrays_within
from reports.page.close_up import CloseUp, Kept
from reports.page.pictures import Span

RNG = np.random.default_rng(3)


def kept(rounded: bool) -> Kept:
    noise = pack(RNG.random((40, 40)), rounded=rounded)
    return Kept(noise, noise, noise, None, Span(np.zeros(1), np.ones(1)))


ROUNDED, EXACT = kept(True), kept(False)
CLOSE = CloseUp(arrays={"t": ROUNDED, "color": ROUNDED}, exact={"t": EXACT, "color": EXACT})
#: A reference whose colours are exact in float32.
HALF = replace(CLOSE, exact={"t": EXACT})
MORE = EXACT.size - ROUNDED.size


def test_with_room_everything_is_exact() -> None:
    assert MORE > 0
    assert arrays_within([CLOSE, HALF]) == [CLOSE.exact, {"t": EXACT, "color": ROUNDED}]


def test_every_scene_has_its_arrays_before_any_is_exact() -> None:
    assert arrays_within([CLOSE] * 3, 6 * ROUNDED.size) == [CLOSE.arrays] * 3


def test_what_fails_first_is_exact_first_in_every_scene() -> None:
    chosen = arrays_within([CLOSE] * 2, 4 * ROUNDED.size + 3 * MORE)
    assert chosen == [CLOSE.exact, {"t": EXACT, "color": ROUNDED}]


def test_a_scene_without_room_has_none() -> None:
    assert arrays_within([CLOSE, CloseUp(), CLOSE], 2 * ROUNDED.size) == [CLOSE.arrays, {}, {}]
