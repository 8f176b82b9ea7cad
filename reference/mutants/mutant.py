"""A mutant: the lecture's algorithm with one mistake in it, traced pixel by pixel."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from minirt.frame import Frame
from minirt.quantities import Stage
from minirt.render import (
    Tile,
    blank_frame,
    chosen_quantities,
    fill,
    frame_meta,
    trace_pixels,
)
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene
from minirt.vectors import Index
from minirt.whitted import Whitted

#: Changes finished values of some pixels, (n,) or (3, n) each, where they are given.
Change = Callable[[Scene, Index, Tile], Tile]

#: Quantities that a `Change` needs to know which values to change.
_ALWAYS = ("hit",)


@dataclass(frozen=True, eq=False)
class Mutant:
    """One wrong version of the lecture's algorithm.

    Attributes
    ----------
    name : str
        In kebab-case.
    rule : str
        S1…S16: the rule that it breaks.
    mistake : str
        A clause that completes "agrees with rule S2 …": "without the half pixel".
    sentence : str
        Why the wrong version looks right, or how one comes to write it.
    stage : str
        The first stage, in causal order, that it really breaks.
    rules : Rules
        The lecture's rules, with the mistake in one of them.
    scene : callable
        Changes the scene before it is rendered; the identity if the mistake is elsewhere.
    change : callable or None
        Changes the finished values.
    """

    name: str
    rule: str
    mistake: str
    sentence: str
    stage: Stage
    rules: Rules = SLIDES
    scene: Callable[[Scene], Scene] = lambda scene: scene
    change: Change | None = None

    def render(self, scene: Scene, quantities: str | Iterable[str] | None = None) -> Frame:
        """The mutant's frame of a scene: all quantities, or some."""
        names = chosen_quantities(quantities)
        count = scene.screen.nx * scene.screen.ny
        arrays = blank_frame(scene, names)
        pixels = np.arange(count)
        fill(arrays, pixels, self.trace(scene, pixels, names))
        return Frame(arrays, frame_meta(scene))

    def trace(self, scene: Scene, pixels: Index, quantities: Iterable[str]) -> Tile:
        """Some pixels' values in some quantities.

        Parameters
        ----------
        scene : Scene
        pixels : (n,) intp
            Counted along the image's rows from the top left.
        quantities : iterable of str

        Returns
        -------
        dict of str to (n,) or (k, n) array
        """
        names = tuple(quantities)
        whitted = Whitted(self.scene(scene), self.rules)
        with np.errstate(all="ignore"):  # a wrong rule may overflow
            tile = trace_pixels(whitted, pixels, frozenset((*names, *_ALWAYS)))
        tile = {name: tile[name] for name in {*names, *_ALWAYS}}
        if self.change is not None:
            tile = tile | self.change(scene, pixels, tile)
        return {name: tile[name] for name in names}
