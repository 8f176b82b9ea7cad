"""FLIP: the visible difference between two pictures that are shown in alternation.

Like structural similarity it is never enough: its usual threshold lets 300 to 2,900 wrong pixels of
65,536 pass. It is used besides the check of each pixel's colour.

Source: P. Andersson et al. 2020, doi:10.1145/3406183.
"""

from __future__ import annotations

import importlib.util

import numpy as np

from minirt.frame import Array, Frame
from minirt.vectors import Floats

#: Largest allowed mean difference; differences are at most 1. A picture whose only differences are
#: uncertain pixels stays below: 1 % of scattered pixels wholly wrong cost 0.059 in the picture
#: `everything`.
FLIP_CEILING = 0.06
#: The share of uncertain pixels for which this ceiling is chosen, and the cost of a further share.
_UNCERTAIN, _COST = 0.01, 6.0


def flip_ceiling(uncertain: float) -> float:
    """Largest mean difference of a picture of which a share of pixels is uncertain."""
    return min(1.0, FLIP_CEILING + _COST * max(0.0, uncertain - _UNCERTAIN))


def flip_of(name: str, ours: Frame, theirs: Frame) -> float | None:
    """Mean FLIP of two frames' colours, 0 where they are the same.

    None for any other quantity, and where `flip_evaluator` is not installed
    (pip install 'minirt[flip]'). Colours are clamped to [0, 1], as on a screen.
    """
    if name != "color" or importlib.util.find_spec("flip_evaluator") is None:
        return None
    import flip_evaluator

    pictures = [_shown(frame["color"]) for frame in (ours, theirs)]
    _, mean, _ = flip_evaluator.evaluate(*pictures, "LDR", inputsRGB=False, applyMagma=False)
    return float(mean)


def _shown(color: Array) -> Floats:
    shown: Floats = np.clip(np.nan_to_num(color), 0.0, 1.0).astype(np.float32)
    return shown
