"""What is to be compared and how, and what a report has made while the arrays are at hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from reference.cache import Cache
from reference.compare.quorum import Draw
from reference.verify.results import Evidence

#: Seconds that a reference may take for one scene.
TIMEOUT = 300.0

#: Makes what a report shows of the evidence, while its arrays are at hand.
MakeDetails = Callable[[Evidence], Any]
#: Makes a picture of minirt's own frame, for a report.
MakeThumbnail = Callable[[Frame], Any]
#: Names what explains a failure, best first, each with a `sentence`.
Diagnose = Callable[[Evidence], tuple[Any, ...]]


@dataclass(frozen=True)
class Callbacks:
    """What is called in a child process, where the arrays are; each is picklable, or None.

    Attributes
    ----------
    details : callable or None
        Called with each `Evidence`; the answer is `ReferenceResult.details`.
    draw : callable or None
        Called with the maps of who agrees; the answer is `Quorum.drawn`.
    diagnose : callable or None
        Called with the `Evidence` of each failure; the answer is `ReferenceResult.diagnosis`.
    thumbnail : callable or None
        Called with minirt's frame of each scene; the answer is `SceneResult.thumbnail`.
    """

    details: MakeDetails | None = None
    draw: Draw | None = None
    diagnose: Diagnose | None = None
    thumbnail: MakeThumbnail | None = None


@dataclass(frozen=True)
class Options:
    """How scenes are compared.

    Attributes
    ----------
    quantities : tuple of str
        What to compare.
    required : tuple of str
        Quantities that every reference must give.
    timeout : float
        Seconds that a reference may take for one scene.
    jobs : int
        Processes of each kind, at least 1; no more are started than there is work for.
    cache : Cache or None
        Where frames and their stability are kept from run to run.
    callbacks : Callbacks
    """

    quantities: tuple[str, ...] = tuple(QUANTITIES)
    required: tuple[str, ...] = ()
    timeout: float = TIMEOUT
    jobs: int = 2
    cache: Cache | None = None
    callbacks: Callbacks = Callbacks()


#: Every quantity, none of them required, and no cache.
DEFAULTS = Options()
