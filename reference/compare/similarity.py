"""Structural similarity (SSIM) of whole pictures, besides the checks of each pixel.

It is never enough: on 65,536 pixels, 360 clustered wrong ones still score above 0.99. But a picture
that passes every pixel check and looks different would show a gap in those checks, so the floors of
the similarity must hold too.

Source: Z. Wang et al. 2004, doi:10.1109/TIP.2003.819861.
"""

from __future__ import annotations

import numpy as np

from minirt.frame import Frame
from minirt.vectors import Floats

#: Least structural similarity by quantity. A picture whose only differences are uncertain pixels
#: stays above: 1 % of scattered one-pixel differences cost about 0.05 at worst.
SSIM_FLOOR = {"hit": 0.95, "depth": 0.95, "shadow": 0.95}

#: The share of uncertain pixels for which those floors are chosen.
_UNCERTAIN = 0.01

#: The least range of depths, in tolerances, that is stretched to black and white. Noise of half a
#: tolerance, σ = 1/400 of that range, then costs σ²/(σ² + 0.03²) < 1 % of the similarity.
_FLAT = 200.0

#: Side of the window in pixels, scikit-image's default; smaller images have no SSIM.
_WINDOW = 7


def ssim_floor(name: str, uncertain: float) -> float:
    """Least structural similarity of a picture of which a share of pixels is uncertain.

    Beyond 1 % each uncertain pixel may cost all 49 windows that contain it.
    """
    return max(0.0, SSIM_FLOOR[name] - _WINDOW**2 * max(0.0, uncertain - _UNCERTAIN))


def ssim_of(name: str, ours: Frame, theirs: Frame, grain: float) -> float | None:
    """Mean structural similarity of one quantity's pictures, or None where it has none.

    Masks are taken as 0 and 1 (½ where nothing is hit, for shadows). Depth is normalised over
    the union of both hits, with the background at the far value.

    Parameters
    ----------
    name : str
    ours, theirs : Frame
    grain : float
        The usual tolerance of a pixel, in the quantity's unit: depths that differ by a few of these
        only, as on a wall that faces the observer, make a uniform picture.
    """
    if name not in SSIM_FLOOR or min(ours.size) < _WINDOW:
        return None
    from skimage.metrics import structural_similarity

    if name == "depth":
        pictures = _depths(ours["depth"], theirs["depth"], _FLAT * grain)
    elif name == "shadow":
        pictures = tuple(_shade(frame["shadow"]) for frame in (ours, theirs))
    else:
        pictures = tuple(frame["hit"].astype(np.float64) for frame in (ours, theirs))
    return float(structural_similarity(*pictures, win_size=_WINDOW, data_range=1.0))


def _shade(shadow: np.ndarray[tuple[int, int], np.dtype[np.int8]]) -> Floats:
    return np.where(shadow < 0, 0.5, 1.0 - shadow)


def _depths(ours: Floats, theirs: Floats, least: float) -> tuple[Floats, ...]:
    seen = np.concatenate([d[np.isfinite(d)] for d in (ours, theirs)])
    if not seen.size:
        return np.zeros(ours.shape), np.zeros(ours.shape)
    near, far = float(seen.min()), float(seen.max())
    span = max(far - near, least) or 1.0
    return tuple(
        np.where(np.isfinite(d), (np.where(np.isfinite(d), d, far) - near) / span, 1.0)
        for d in (ours, theirs)
    )
