"""Small pictures for a student's page: ours, theirs, and the difference."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from reference.verify.results import Evidence
from reports.page.pictures import (
    Span,
    has_scale,
    ratio_png,
    shrink_factor,
    shrunk,
    span_of,
    value_png,
)

#: The pictures, and the file that names the quantity that they show.
THUMBNAILS = ("ours", "theirs", "difference")
QUANTITY_FILE = "quantity"
#: Largest sides, in pixels.
_LARGEST = (256, 192)
_UNIT = Span(np.zeros(1), np.ones(1))


def write_thumbnails(evidence: Evidence, quantity: str, folder: Path) -> None:
    """Write three small pictures of one quantity: ours, theirs, and the difference.

    Parameters
    ----------
    evidence : Evidence
    quantity : str
        The first wrong one; empty for the colour, or the last that is given.
    folder : Path
    """
    given = list(evidence.comparison.ratio)
    if not given:
        return
    name = quantity or ("color" if "color" in given else given[-1])
    ours, theirs = evidence.ours[name], evidence.theirs[name]
    factor = shrink_factor(ours.shape[1], ours.shape[0], _LARGEST)
    span = span_of(ours, theirs) if has_scale(name) or name == "position" else _UNIT
    drawn = (
        value_png(name, shrunk(ours, factor), span),
        value_png(name, shrunk(theirs, factor), span),
        ratio_png(evidence.comparison.ratio[name], factor),
    )
    for which, png in zip(THUMBNAILS, drawn, strict=True):
        (folder / f"{which}.png").write_bytes(png)
    (folder / QUANTITY_FILE).write_text(name, encoding="ascii")
