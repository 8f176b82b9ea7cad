"""What a worker process makes of a comparison while its arrays are at hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from minirt.vectors import Bools
from reference.compare.check import Check
from reference.verify.results import Evidence
from reports.page.close_up import CloseUp, close_up_of
from reports.page.pictures import (
    agreement_png,
    has_scale,
    picture_span,
    ratio_png,
    shrink_factor,
    shrunk,
    value_png,
)

#: Largest sides, in pixels, of a passing quantity's pictures, and of a failing one's.
THUMBNAIL = (128, 96)
FULL = (512, 512)


@dataclass(frozen=True)
class Pictures:
    """One quantity of one scene against one reference, as PNG files.

    Attributes
    ----------
    ours, theirs, ratio : bytes
        Values on one scale, and error over tolerance.
    width, height : int
        Of each picture, in pixels.
    factor : int
        Pixels of the image to one of the pictures, each way.
    low, high : float or None
        What the ends of the scale stand for, where it is one of lengths.
    clipped : bool
        Whether larger values than `high` occur.
    """

    ours: bytes
    theirs: bytes
    ratio: bytes
    width: int
    height: int
    factor: int
    low: float | None
    high: float | None
    clipped: bool


@dataclass(frozen=True)
class Seen:
    """One scene against one reference, as the page shows it.

    Attributes
    ----------
    pictures : dict of str to Pictures
        By quantity, of every quantity that was compared.
    close : CloseUp
        What the inspector shows.
    """

    pictures: dict[str, Pictures]
    close: CloseUp


@dataclass(frozen=True)
class Agreement:
    """How many references confirm each pixel of a quantity, as a PNG file of some size."""

    png: bytes
    width: int
    height: int


def agreement_of(agree: NDArray[np.int64], differ: Bools) -> Agreement:
    """A thumbnail of who agrees where. A `Draw`."""
    ny, nx = agree.shape
    factor = shrink_factor(nx, ny, THUMBNAIL)
    png = agreement_png(agree, differ, factor)
    return Agreement(png, -(-nx // factor), -(-ny // factor))


def digest_of(evidence: Evidence) -> Seen:
    """Pictures, and all that the inspector shows. A `Digest`."""
    pictures = {
        check.quantity: _draw(check, evidence)
        for check in evidence.comparison.checks
        if check.quantity in evidence.comparison.ratio
    }
    return Seen(pictures, close_up_of(evidence))


def _draw(check: Check, evidence: Evidence) -> Pictures:
    name = check.quantity
    ours, theirs = evidence.ours[name], evidence.theirs[name]
    ny, nx = evidence.ours.size
    factor = shrink_factor(nx, ny, FULL if deserves_full(check) else THUMBNAIL)
    scaled = has_scale(name)
    span = picture_span(name, ours, theirs)
    small = shrunk(ours, factor)
    return Pictures(
        ours=value_png(name, small, span),
        theirs=value_png(name, shrunk(theirs, factor), span),
        ratio=ratio_png(evidence.comparison.ratio[name], factor),
        width=small.shape[1],
        height=small.shape[0],
        factor=factor,
        low=float(span.low[0]) if scaled else None,
        high=float(span.high[0]) if scaled else None,
        clipped=span.clipped,
    )


def deserves_full(check: Check) -> bool:
    """A failing quantity is shown pixel by pixel, unless an earlier stage is the one to look at."""
    return check.state == "failed" and (check.first_wrong > 0 or check.wrong == 0)
