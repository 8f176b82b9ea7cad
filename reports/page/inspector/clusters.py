"""Clusters of wrong pixels, the worst pixels, and how the errors are distributed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from minirt.frame import Array
from minirt.quantities import QUANTITIES, STAGES, Stage
from minirt.vectors import Floats
from reports.page.colors import BANDS, band_of

#: Clusters and pixels that are listed of one reference on one scene; their number is always given.
MOST_LISTED = 20


@dataclass(frozen=True)
class Cluster:
    """Wrong pixels that touch, by a side or a corner, and are wrong first in the same stage.

    Attributes
    ----------
    stage : str
    size : int
        Pixels.
    left, top, right, bottom : int
        Its first and last column and row, from the left and from the TOP.
    column, row : int
        Its worst pixel; where several are equally bad, the one nearest to their middle.
    """

    stage: Stage
    size: int
    left: int
    top: int
    right: int
    bottom: int
    column: int
    row: int


@dataclass(frozen=True)
class WrongPixel:
    """A pixel, the first stage that is wrong there, and the quantity of it that is furthest off."""

    column: int
    row: int
    stage: Stage
    quantity: str
    ratio: float


def clusters_of(first_stage: Array, ratios: Mapping[str, Floats]) -> tuple[Cluster, ...]:
    """Every cluster, in the stages' causal order, the largest of each first.

    Parameters
    ----------
    first_stage : (ny, nx) int8
        Number of the first wrong stage in `STAGES`; −1 where nothing is wrong.
    ratios : dict of str to (ny, nx) float64
        Error over tolerance by quantity; NaN where it was not judged.
    """
    if (first_stage < 0).all():
        return ()
    from skimage.measure import label, regionprops  # slow to import, and most runs pass

    worst = _worst_of_stage(first_stage, ratios)[0]
    touching = regionprops(label(first_stage + 1, background=0, connectivity=2))
    found = [_cluster(region.coords, first_stage, worst) for region in touching]
    return tuple(sorted(found, key=_rank))


def _rank(cluster: Cluster) -> tuple[int, int, int, int]:
    return STAGES.index(cluster.stage), -cluster.size, cluster.top, cluster.left


def _cluster(pixels: NDArray[np.integer], first_stage: Array, worst: Floats) -> Cluster:
    rows, columns = pixels.T
    ratio = worst[rows, columns]
    candidates = np.flatnonzero(ratio == ratio.max())
    middle = pixels[candidates].mean(axis=0)
    chosen = candidates[int(((pixels[candidates] - middle) ** 2).sum(axis=1).argmin())]
    return Cluster(
        stage=STAGES[int(first_stage[rows[0], columns[0]])],
        size=len(rows),
        left=int(columns.min()),
        top=int(rows.min()),
        right=int(columns.max()),
        bottom=int(rows.max()),
        column=int(columns[chosen]),
        row=int(rows[chosen]),
    )


def worst_pixels(first_stage: Array, ratios: Mapping[str, Floats]) -> tuple[WrongPixel, ...]:
    """The `MOST_LISTED` worst pixels: by stage, then by error over tolerance, then from the top."""
    worst, names, which = _worst_of_stage(first_stage, ratios)
    rows, columns = np.nonzero(first_stage >= 0)
    order = np.lexsort((columns, rows, -worst[rows, columns], first_stage[rows, columns]))[
        :MOST_LISTED
    ]
    return tuple(
        WrongPixel(
            int(columns[k]),
            int(rows[k]),
            STAGES[int(first_stage[rows[k], columns[k]])],
            names[int(which[rows[k], columns[k]])],
            float(worst[rows[k], columns[k]]),
        )
        for k in order[:MOST_LISTED]
    )


def _worst_of_stage(
    first_stage: Array, ratios: Mapping[str, Floats]
) -> tuple[Floats, Sequence[str], NDArray[np.intp]]:
    """The largest error over tolerance in the first wrong stage, names, and whose it is."""
    names = tuple(ratios)
    here = {name: first_stage == STAGES.index(QUANTITIES[name].stage) for name in names}
    stack = np.stack([np.where(here[n] & (ratios[n] > 1), ratios[n], 0.0) for n in names])
    return stack.max(axis=0), names, stack.argmax(axis=0)


@dataclass(frozen=True)
class Histogram:
    """How the errors of one quantity are distributed.

    Attributes
    ----------
    counts : tuple of int
        Pixels in each band of error over tolerance (`colors.BOUNDS`), then those not judged.
    differences : tuple of float or None
        The largest error in each band, and among those not judged, in the quantity's own unit;
        +inf where only one of the two is a number, or they are discrete; None where no pixel is.
    """

    counts: tuple[int, ...]
    differences: tuple[float | None, ...]


def histogram(ratio: Floats, error: Floats) -> Histogram:
    """Count the pixels in each band, and find the largest error there.

    Parameters
    ----------
    ratio, error : (ny, nx) float64
        The ratio is NaN where it was not judged.
    """
    bands = np.where(np.isnan(ratio), len(BANDS), band_of(ratio))
    each = (error[bands == k] for k in range(len(BANDS) + 1))
    most = [float(some.max()) if len(some) else None for some in each]
    counts = np.bincount(bands.ravel(), minlength=len(BANDS) + 1)
    return Histogram(tuple(counts.tolist()), tuple(most))
