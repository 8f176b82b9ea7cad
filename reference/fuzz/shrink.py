"""From a scene that fails to the smallest and roundest that fails in the same first stage."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from minirt import load_scene
from minirt.errors import MinirtError
from minirt.scene import Scene
from reference.fuzz.bench import Trial
from reference.fuzz.placements import Document
from reference.fuzz.simpler import (
    plainer_objects,
    plainer_places,
    plainer_properties,
    rounder_numbers,
    windows,
    without_objects,
)

#: Says how a scene ends before the reference that it fails against.
Ask = Callable[[Scene], Trial]


@dataclass(frozen=True, eq=False)
class Shrunk:
    """What is left of a scene.

    Attributes
    ----------
    scene : Scene
        The smallest found that still fails in the same first stage.
    trial : Trial
        How it fails.
    asked : int
        Scenes that were tried on the way.
    seconds : float
    """

    scene: Scene
    trial: Trial
    asked: int
    seconds: float


def shrink(scene: Scene, trial: Trial, ask: Ask, seconds: float = 60.0) -> Shrunk:
    """Make a failing scene smaller as long as it fails in the same first stage.

    Parameters
    ----------
    scene : Scene
    trial : Trial
        How it fails.
    ask : callable
        How a smaller scene ends; called many times.
    seconds : float
        After which what has been reached is the answer.
    """
    start = time.perf_counter()
    shrinking = _Shrinking(scene, trial, ask, start + seconds)
    before: Document = {}
    while shrinking.document != before and not shrinking.late():
        before = shrinking.document
        shrinking.round()
    return Shrunk(shrinking.scene, shrinking.trial, shrinking.asked, time.perf_counter() - start)


class _Shrinking:
    """The smallest scene so far, and the steps that try to make it smaller."""

    def __init__(self, scene: Scene, trial: Trial, ask: Ask, deadline: float) -> None:
        self.scene, self.trial = scene, trial
        self.document, self.folder = scene.to_dict(), scene.folder
        self._ask, self._deadline = ask, deadline
        self.asked = 0

    def late(self) -> bool:
        """Whether the time is used up."""
        return time.perf_counter() > self._deadline

    def round(self) -> None:
        """Every step once; the image first, since a small one is quick to try."""
        self._first_kept(lambda: windows(self.document, self.trial.column, self.trial.row))
        self._drop_objects()
        self._each_kept(lambda: plainer_objects(self.document, self.scene))
        self._each_kept(lambda: plainer_properties(self.document))
        self._first_kept(lambda: plainer_places(self.document))
        for rounding in rounder_numbers(self.document):
            self._keep(rounding(self.document))

    def _keep(self, candidate: Document) -> bool:
        """Take a candidate where it loads and fails in the same first stage."""
        if candidate == self.document or self.late():
            return False
        try:
            scene = load_scene(candidate, folder=self.folder)
        except MinirtError:
            return False
        self.asked += 1
        trial = self._ask(scene)
        if trial.state != "failed" or trial.stage != self.trial.stage:
            return False
        self.scene, self.trial, self.document = scene, trial, candidate
        return True

    def _first_kept(self, candidates: Callable[[], Iterable[Document]]) -> bool:
        return any(self._keep(candidate) for candidate in candidates())

    def _each_kept(self, candidates: Callable[[], Iterable[Document]]) -> None:
        """Go on from each candidate that is kept, until none is."""
        while not self.late() and self._first_kept(candidates):
            pass

    def _drop_objects(self) -> None:
        """Delta debugging: halves, then quarters, down to single objects."""
        count = len(self.document["objects"])
        while count:
            first = max(0, len(self.document["objects"]) - count)
            while True:
                self._keep(without_objects(self.document, first, count))
                if first == 0:
                    break
                first = max(0, first - count)
            count //= 2
