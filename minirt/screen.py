"""S1–S3, S5: the virtual screen and the ray of each pixel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from minirt.vectors import Floats, Index, column, divided


@dataclass(frozen=True)
class VirtualScreen:
    """S1: the viewing frame and the screen in its plane n = ν.

    Attributes
    ----------
    P0 : tuple of 3 float
        The observer, in modelling coordinates.
    u, v, n : tuple of 3 float
        Orthonormal axes: horizontal, vertical, normal of the view plane. Either handedness.
    nu : float
        ν ≠ 0 of either sign: the screen lies at P0 + ν·n.
    l, r, b, t : float
        Bounds of the screen in scene units, l < r and b < t; it need not be centred.
    nx, ny : int
        Columns and rows of pixels; pixels need not be square.
    """

    P0: tuple[float, float, float]
    u: tuple[float, float, float]
    v: tuple[float, float, float]
    n: tuple[float, float, float]
    nu: float
    l: float
    r: float
    b: float
    t: float
    nx: int
    ny: int


class ViewFrame(NamedTuple):
    """S1: axes as columns (3, 1), and the plane n = ν they are measured to."""

    u: Floats
    v: Floats
    n: Floats
    nu: float


def view_frame(screen: VirtualScreen) -> ViewFrame:
    """The observer's axes and the plane of the screen. Source: S1."""
    return ViewFrame(column(screen.u), column(screen.v), column(screen.n), screen.nu)


def pixel_center(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
    """Centre of virtual pixel (i, j) in the view plane; j = 0 is the BOTTOM row.

    Parameters
    ----------
    i, j : (n,) float64
        Column 0…nx−1 and row 0…ny−1, counted from the lower left corner.

    Returns
    -------
    u_s, v_s : (n,) float64
        Viewing coordinates in scene units.

    Source: S2, equation (1).
    """
    u_s = screen.l + (screen.r - screen.l) / screen.nx * (i + 0.5)
    v_s = screen.b + (screen.t - screen.b) / screen.ny * (j + 0.5)
    return u_s, v_s


def model_from_view(frame: ViewFrame, u_s: Floats, v_s: Floats) -> Floats:
    """The vector P − P0 of a point (u_s, v_s, ν) of the screen, in modelling coordinates.

    The change-of-frame matrix has the axes as its columns and P0 as its translation. The
    translation is left out, since S5 subtracts P0 again: adding it first would cost the digits
    of a screen that is small beside its distance from the origin.

    Returns
    -------
    (3, n) float64

    Source: S3.
    """
    return frame.u * u_s + frame.v * v_s + frame.n * frame.nu


def ray_direction(P_minus_P0: Floats) -> Floats:
    """d = P − P0, not normalised, so that t = 1 at the screen. Source: S5, equation (2)."""
    return P_minus_P0


def point_at(P0: Floats, d: Floats, t: Floats) -> Floats:
    """r(t) = P0 + t·d. Source: S5, equation (2)."""
    return P0 + t * d


def depth_of(t: Floats, nu: float) -> Floats:
    """t·|ν|: the hit's distance along the view axis. Source: S5."""
    return t * abs(nu)


def distance_of(t: Floats, d_length: Floats) -> Floats:
    """t·‖d‖: the hit's Euclidean distance from the observer. Source: S5."""
    return t * d_length


def image_pixels(screen: VirtualScreen, pixels: Index) -> tuple[Floats, Floats]:
    """Columns and slide rows (i, j) of pixels (n,), counted along rows from the top left."""
    row, column_ = divided(pixels, screen.nx)
    return column_.astype(np.float64), (screen.ny - 1 - row).astype(np.float64)
