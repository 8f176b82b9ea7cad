"""FLIP: how different two pictures look to somebody who flips between them.

Like structural similarity it never suffices: measured by others, its usual threshold lets 300 to
2,900 wrong pixels of 65,536 pass. It stands beside the check of each pixel's colour.

Source: P. Andersson et al. 2020, doi:10.1145/3406183.
"""

from __future__ import annotations

import importlib.util

import numpy as np

from minirt.frame import Array, Frame
from minirt.vectors import Floats

#: Largest mean difference, of 1 at most. A picture whose only differences are uncertain pixels
#: stays below: 1 % of scattered pixels wholly wrong cost 0.059 in the picture `everything`.
FLIP_CEILING = 0.06
#: The share of uncertain pixels that this ceiling is made for, and what each further share costs.
_UNCERTAIN, _COST = 0.01, 6.0


def flip_ceiling(uncertain: float) -> float:
    """Largest mean difference of a picture of which a share of pixels is uncertain."""
    return min(1.0, FLIP_CEILING + _COST * max(0.0, uncertain - _UNCERTAIN))


def flip_of(name: str, ours: Frame, theirs: Frame) -> float | None:
    """Mean FLIP of two frames' colours, 0 where they are the same.

    None for any other quantity, and where `flip_evaluator` is not installed
    (pip install 'minirt[flip]'). Colours are what a screen shows: cut to [0, 1].
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
