"""S5, S6: rays P0 + t·d, and the interval of t that counts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from minirt.vectors import Floats, Index, take


@dataclass(frozen=True, eq=False)
class Rays:
    """n rays P0 + t·d, t0 ≤ t ≤ t1.

    What all rays share is given once, as an array whose last axis is 1. Whether they share it is
    known by that alone: a copy of the arrays is traced as they are. Neighbours should follow each
    other.

    Attributes
    ----------
    P0, d : (3, n) or (3, 1) float64
        Origins and directions, of any length but 0.
    t0, t1 : (n,) or (1,) float64
    count : int
        n.

    Examples
    --------
    >>> rays = Rays.of(np.zeros((3, 1)), np.ones((3, 5)))
    >>> rays.count, rays.one_origin, rays.one_direction
    (5, True, False)
    """

    P0: Floats
    d: Floats
    t0: Floats
    t1: Floats
    count: int

    @classmethod
    def of(
        cls, P0: Floats, d: Floats, t0: Floats | float = 0.0, t1: Floats | float = np.inf
    ) -> Rays:
        """As many rays as any of the arrays has; one where all of them have one."""
        start, end = (np.atleast_1d(np.asarray(t, dtype=np.float64)) for t in (t0, t1))
        counts = {P0.shape[1], d.shape[1], len(start), len(end)} - {1}
        return cls(P0, d, start, end, max(counts) if counts else 1)

    @property
    def one_origin(self) -> bool:
        """Whether all rays leave one point."""
        return bool(self.P0.shape[1] == 1)

    @property
    def one_direction(self) -> bool:
        """Whether all rays go one way."""
        return bool(self.d.shape[1] == 1)

    @property
    def origins(self) -> Floats:
        """The origin of each ray, (3, n)."""
        return np.broadcast_to(self.P0, (3, self.count))

    @property
    def directions(self) -> Floats:
        """The direction of each ray, (3, n)."""
        return np.broadcast_to(self.d, (3, self.count))

    def interval(self, index: Index) -> tuple[Floats, Floats]:
        """t0 and t1 of some rays, (k,) each."""
        return take(self.t0[None], index)[0], take(self.t1[None], index)[0]
