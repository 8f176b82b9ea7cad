"""S4, S12–S16: the points that rays hit, and the rays that leave from there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from minirt.hits import RayHits
from minirt.rays import Rays
from minirt.shading import Surfaces
from minirt.vectors import Bools, Floats, Index, take


@dataclass(frozen=True, eq=False)
class Points:
    """Surface points that rays have hit.

    Attributes
    ----------
    rays : (n,) intp
        Which of the rays they belong to.
    M, delta : (3, n) float64
        The points, and the unit directions of the rays that arrived.
    normal : (3, n) float64
        Unit geometric normal on the outside.
    s : (3, n) float64
        The s of S13–S16, by which light is reflected and refracted: the same normal.
    hits : RayHits
    material : Surfaces
    """

    rays: Index
    M: Floats
    delta: Floats
    normal: Floats
    s: Floats
    hits: RayHits
    material: Surfaces

    def take(self, index: Index) -> Points:
        """Some of the points."""
        return Points(
            self.rays[index],
            take(self.M, index),
            take(self.delta, index),
            take(self.normal, index),
            take(self.s, index),
            self.hits.take(index),
            self.material.take(index),
        )

    @property
    def refractive(self) -> Index:
        """Numbers of the points whose material has an index."""
        return np.flatnonzero(~np.isnan(self.material.ior))


@dataclass(frozen=True, eq=False)
class Branch:
    """Rays that leave from points: origin and unit direction (3, n), and what they meet.

    `length` is the distance from the point itself to what is met, wherever the ray was started.
    """

    origin: Floats
    direction: Floats
    hits: RayHits
    length: Floats

    @property
    def rays(self) -> Rays:
        """The rays themselves."""
        return Rays.of(self.origin, self.direction)

    def take(self, index: Index) -> Branch:
        """Some of the rays."""
        return Branch(
            take(self.origin, index),
            take(self.direction, index),
            self.hits.take(index),
            self.length[index],
        )


@dataclass(frozen=True, eq=False)
class SecondaryRays:
    """Secondary rays of points that have been traced already; None where they have not.

    Attributes
    ----------
    dark : (n,) bool
        Whether each point is in shadow.
    reflected : Branch
        Of every point.
    refracted : Branch
        Of the points whose material has an index, in their order.
    """

    dark: Bools | None = None
    reflected: Branch | None = None
    refracted: Branch | None = None


#: No secondary rays at all.
NOTHING_TRACED = SecondaryRays()
