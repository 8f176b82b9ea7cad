"""How rays leave: the lecture's way. A harness hands over another way to see what would move."""

from __future__ import annotations

from minirt.trace import Hits
from minirt.vectors import Floats


class Launch:
    """The lecture's way: from P0 itself, and from the surface point itself beyond ε."""

    def primary(self, P0: Floats, d: Floats) -> Floats:
        """Origins (3, n) of primary rays that the rules start at P0 along d."""
        return P0

    def secondary(
        self, M: Floats, s: Floats, direction: Floats, t0: float
    ) -> tuple[Floats, float]:
        """Origins (3, n) and t0 of rays that the rules start at M beyond t0.

        Parameters
        ----------
        M, s, direction : (3, n) float64
            Surface points, their unit geometric normals, unit directions of the new rays.
        t0 : float
            A length.
        """
        return M, t0

    def optical_normal(self, s: Floats, hits: Hits) -> Floats:
        """The unit normal (3, n) that light is reflected and refracted by."""
        return s


#: The lecture's way.
SLIDES_LAUNCH = Launch()
