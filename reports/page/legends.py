"""What the colours of a picture stand for, in words."""

from __future__ import annotations

from fractions import Fraction

from minirt.quantities import QUANTITIES
from reports.page.colors import BANDS, BOUNDS, CATEGORIES, MASK_WORDS, MASKS, NOTHING, css


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


def bands() -> list[tuple[str, str, bool]]:
    """Bands of error over tolerance: colour, upper bound, and whether it is beyond 1."""
    words = [str(Fraction(bound)) for bound in BOUNDS] + ["∞"]
    beyond = [bound > 1 for bound in BOUNDS] + [True]
    return [(css(color), word, out) for color, word, out in zip(BANDS, words, beyond, strict=True)]
