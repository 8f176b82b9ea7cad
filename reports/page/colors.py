"""The colours of pictures, and their legends: sRGB palettes that never rely on hue alone."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from minirt.quantities import QUANTITIES
from minirt.vectors import Floats

Bytes = NDArray[np.uint8]


def palette(*codes: str) -> Bytes:
    """Colours (n, 3) from hexadecimal codes."""
    return np.array([list(bytes.fromhex(code)) for code in codes], dtype=np.uint8)


#: Where a quantity has no value.
NOTHING = palette("dfe2e7")[0]

#: Values −1, 0, 1 of a mask: no value, no, yes.
MASKS: dict[str, Bytes] = {
    "hit": palette("dfe2e7", "dfe2e7", "2f6fb5"),
    "shadow": palette("dfe2e7", "ffd873", "26365c"),
    "tir": palette("dfe2e7", "7fb6dd", "7a3b00"),
}

#: Words for those values; none where the value needs none.
MASK_WORDS: dict[str, tuple[str, str, str]] = {
    "hit": ("", "nothing hit", "hit"),
    "shadow": ("nothing hit", "lit", "in shadow"),
    "tir": ("no index", "goes through", "totally reflected"),
}

#: Objects and faces, repeated after twelve; neighbours differ in lightness too.
CATEGORIES = palette(
    "0072b2", "f0b83c", "1b4d3e", "e08bb4", "56b4e9", "8c3b12",
    "9bd3ae", "4b2a7b", "d55e00", "c9c3f0", "00735c", "f4e27a",
)  # fmt: skip

#: The first wrong stage of a pixel, in causal order: neighbours differ in hue and lightness.
STAGE_COLORS = palette(
    "4b2a7b", "e08bb4", "1b4d3e", "9bd3ae", "0072b2",
    "f4e27a", "00735c", "d55e00", "8c3b12", "c9c3f0",
)  # fmt: skip

#: Upper bounds of error over tolerance in each of the bands below; what is more is in the last.
BOUNDS: tuple[float, ...] = (0.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 16.0)

#: Colours of the bands, in steps of 10 of CIE lightness, 14 at the tolerance: blue, then orange.
BANDS = palette(
    "0a1826", "102e48", "18446e", "205c93", "2975bb",
    "e37a18", "eca452", "f6ca8c", "fff2d6",
)  # fmt: skip

#: Signed error over tolerance, from too small to too large: in steps of 16.5 of CIE lightness from
#: the light middle, which is no error, to blue and to orange.
DIVERGING = palette(
    "004986", "0072bf", "319ae0", "9ac4ef", "eeeeee", "e7b597", "cb8252", "a1551d", "6c3203",
)  # fmt: skip

#: The two stripes of the hatching over uncertain pixels, and the line around wrong ones.
HATCH = palette("8d9096", "b9bcc2")
RING = palette("ff6a13")

#: How many sources confirm a pixel, 0…5 and more: in steps of 12 of CIE lightness.
SOURCES = palette("3a2418", "5b4a33", "6f7350", "7aa07a", "9fcdb0", "e2f3e6")

#: Ten colours of equal perceived distance; matplotlib's viridis, which is in the public domain.
_VIRIDIS = palette(
    "440154",
    "482878",
    "3e4989",
    "31688e",
    "26828e",
    "1f9e89",
    "35b779",
    "6ece58",
    "b5de2b",
    "fde725",
)


def viridis(levels: int) -> Bytes:
    """Colours (levels, 3) from dark violet to light yellow."""
    at = np.linspace(0, len(_VIRIDIS) - 1, levels)
    knots = np.arange(len(_VIRIDIS))
    channels = [np.interp(at, knots, _VIRIDIS[:, k]) for k in range(3)]
    return np.rint(np.stack(channels, axis=1)).astype(np.uint8)


def band_of(ratio: Floats) -> NDArray[np.intp]:
    """Number of the band that error over tolerance falls in."""
    return np.searchsorted(np.array(BOUNDS), ratio, side="left")


def css(color: Any) -> str:
    """A colour (3,) as CSS writes it."""
    return "#" + bytes(color).hex()


def legend_of(name: str) -> list[tuple[str, str]]:
    """Colours with what they stand for; empty where a scale or a sentence says it."""
    if name in MASKS:
        return [
            (css(c), word) for c, word in zip(MASKS[name], MASK_WORDS[name], strict=True) if word
        ]
    if QUANTITIES[name].discrete:
        first = [(css(CATEGORIES[k]), f"{k}") for k in range(4)]
        return [(css(NOTHING), "none"), *first, ("", "… again from 12")]
    return []


def band_legend() -> list[tuple[str, str, bool]]:
    """Bands of error over tolerance: colour, upper bound, and whether it is beyond 1."""
    words = [str(Fraction(bound)) for bound in BOUNDS] + ["∞"]
    beyond = [bound > 1 for bound in BOUNDS] + [True]
    return [(css(color), word, out) for color, word, out in zip(BANDS, words, beyond, strict=True)]
