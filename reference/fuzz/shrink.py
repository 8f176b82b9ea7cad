"""Shrink a failing scene to the simplest one that fails in the same first stage."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from minirt import load_scene
from minirt.errors import MinirtError
from minirt.scene import Scene
from reference.fuzz.candidates import (
    roundings,
    simpler_objects,
    simpler_positions,
    simpler_properties,
    windows,
    without_objects,
)
from reference.fuzz.placements import Document
from reference.fuzz.trial import Trial

#: Tries a scene by the reference that fails.
Try = Callable[[Scene], Trial]


@dataclass(frozen=True, eq=False)
class Shrunk:
    """The result of shrinking a scene.

    Attributes
    ----------
    scene : Scene
        The smallest found that still fails in the same first stage.
    trial : Trial
        How it fails.
    tried : int
        Number of scenes that were tried.
    seconds : float
    """

    scene: Scene
    trial: Trial
    tried: int
    seconds: float


def shrink(scene: Scene, trial: Trial, try_scene: Try, seconds: float = 60.0) -> Shrunk:
    """Simplify a failing scene as long as it fails in the same first stage.

    Parameters
    ----------
    scene : Scene
    trial : Trial
        How it fails.
    try_scene : callable
        Tries a candidate; called many times.
    seconds : float
        After which the smallest scene so far is returned.
    """
    start = time.perf_counter()
    shrinking = _Shrinking(scene, trial, try_scene, start + seconds)
    before: Document = {}
    while shrinking.document != before and not shrinking.late():
        before = shrinking.document
        shrinking.round()
    return Shrunk(shrinking.scene, shrinking.trial, shrinking.tried, time.perf_counter() - start)


class _Shrinking:
    """The smallest scene so far, and the steps that try to make it smaller."""

    def __init__(self, scene: Scene, trial: Trial, try_scene: Try, deadline: float) -> None:
        self.scene, self.trial = scene, trial
        self.document, self.folder = scene.to_dict(), scene.folder
        self._try, self._deadline = try_scene, deadline
        self.tried = 0

    def late(self) -> bool:
        """Whether the time is used up."""
        return time.perf_counter() > self._deadline

    def round(self) -> None:
        """Apply every step once; the image first, since a small one is fast to try."""
        self._accept_first(lambda: windows(self.document, self.trial.column, self.trial.row))
        self._drop_objects()
        self._accept_repeatedly(lambda: simpler_objects(self.document, self.scene))
        self._accept_repeatedly(lambda: simpler_properties(self.document))
        self._accept_first(lambda: simpler_positions(self.document))
        for rounding in roundings(self.document):
            self._accept(rounding(self.document))

    def _accept(self, candidate: Document) -> bool:
        """Accept a candidate if it loads and fails in the same first stage."""
        if candidate == self.document or self.late():
            return False
        try:
            scene = load_scene(candidate, folder=self.folder)
        except MinirtError:
            return False
        self.tried += 1
        trial = self._try(scene)
        if trial.state != "failed" or trial.stage != self.trial.stage:
            return False
        self.scene, self.trial, self.document = scene, trial, candidate
        return True

    def _accept_first(self, candidates: Callable[[], Iterable[Document]]) -> bool:
        return any(self._accept(candidate) for candidate in candidates())

    def _accept_repeatedly(self, candidates: Callable[[], Iterable[Document]]) -> None:
        """Go on from each accepted candidate, until none is accepted."""
        while not self.late() and self._accept_first(candidates):
            pass

    def _drop_objects(self) -> None:
        """Delta debugging: halves, then quarters, down to single objects."""
        count = len(self.document["objects"])
        while count:
            first = max(0, len(self.document["objects"]) - count)
            while True:
                self._accept(without_objects(self.document, first, count))
                if first == 0:
                    break
                first = max(0, first - count)
            count //= 2
