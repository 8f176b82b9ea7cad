"""A hash of every face that a pixel's whole tree of rays has hit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from minirt.hits import RayHits
from minirt.points import NOTHING_TRACED, Branch, Points, SecondaryRays
from minirt.rays import Rays
from minirt.render import Tile, quantities_at
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene
from minirt.vectors import Bools, Floats, Index
from minirt.whitted import Whitted

#: The name of a path's signature among a tile's quantities.
SIGNATURE = "signature"

Signature = NDArray[np.uint64]
_PRIME = np.uint64(1099511628211)  # multiplier of the 64-bit FNV hash
_SALT = np.uint64(0x9E3779B9)  # so that a zero changes the hash too


class SignedPaths(Whitted):
    """The lecture's algorithm with a hash of every discrete answer that leads to a ray's colour.

    Two rays with the same signature hit the same faces, with the same shadows, along their whole
    tree of reflected and refracted rays.

    Attributes
    ----------
    signature : (n,) uint64
        Of the rays whose colour was computed last.
    """

    def __init__(self, scene: Scene, rules: Rules = SLIDES) -> None:
        super().__init__(scene, rules)
        self.signature: Signature = np.zeros(0, dtype=np.uint64)
        self._path = self.signature  # of the points whose colour is being computed

    def signed_tile(self, rays: Rays, hits: RayHits, wanted: frozenset[str]) -> Tile:
        """The wanted quantities of the observer's rays; with the colour, the signature."""
        tile = quantities_at(self, rays, hits, wanted)
        return {**tile, SIGNATURE: self.signature} if "color" in wanted else tile

    def color_of(
        self, points: Points, n: int, generation: int = 0,
        traced: SecondaryRays = NOTHING_TRACED,
    ) -> Floats:  # fmt: skip
        """As the lecture's; starts the hash with the faces of the points."""
        outer, self._path = self._path, _mix(points.hits.object, points.hits.triangle)
        color = super().color_of(points, n, generation, traced)
        self.signature = np.full(n, generation, dtype=np.uint64)
        self.signature[points.rays] = self._path
        self._path = outer
        return color

    def shares(self, points: Points, total: Bools) -> tuple[Floats, Floats]:
        """As the lecture's; adds total reflection to the hash."""
        self._path = _mix(self._path, total)
        return super().shares(points, total)

    def branch_color(self, of: Index, branch: Branch, generation: int) -> Floats:
        """As the lecture's; adds what the branch hits to the hash."""
        color = super().branch_color(of, branch, generation)
        self._path[of] = _mix(self._path[of], self.signature)
        return color

    def local_color(self, points: Points, dark: Bools) -> Floats:
        """As the lecture's; adds the shadow to the hash."""
        self._path = _mix(self._path, dark)
        return super().local_color(points, dark)


def _mix(first: NDArray[Any], *others: NDArray[Any]) -> Signature:
    result: Signature = first.astype(np.uint64)
    for value in others:
        result = (result ^ (value.astype(np.uint64) + _SALT)) * _PRIME
    return result
