"""Wrong versions of S1–S3 and S5: the screen, the pixels' centres, the ray of each."""

from __future__ import annotations

import numpy as np

from minirt.rules import SLIDES
from minirt.screen import ViewFrame, VirtualScreen
from minirt.vectors import Floats, column, cross, norm, unit
from reference.mutants.mutant import Mutant


def _screen_in_front(screen: VirtualScreen) -> ViewFrame:
    return SLIDES.view_frame(screen)._replace(nu=abs(screen.nu))


def _right_handed(screen: VirtualScreen) -> ViewFrame:
    frame = SLIDES.view_frame(screen)
    return frame._replace(u=cross(frame.v, frame.n))


def _axes_exchanged(screen: VirtualScreen) -> ViewFrame:
    frame = SLIDES.view_frame(screen)
    return frame._replace(u=frame.v, v=frame.u)


def _centred(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
    u_s, v_s = SLIDES.pixel_center(screen, i, j)
    return u_s - (screen.l + screen.r) / 2, v_s - (screen.b + screen.t) / 2


def _corner(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
    u_s = screen.l + (screen.r - screen.l) / screen.nx * i
    v_s = screen.b + (screen.t - screen.b) / screen.ny * j
    return u_s, v_s


def _corner_in_v(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
    return SLIDES.pixel_center(screen, i, j)[0], _corner(screen, i, j)[1]


def _rows_from_top(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
    return SLIDES.pixel_center(screen, i, screen.ny - 1 - j)


def _columns_from_right(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
    return SLIDES.pixel_center(screen, screen.nx - 1 - i, j)


def _border_to_border(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
    u_s = screen.l + (screen.r - screen.l) / max(1, screen.nx - 1) * i
    v_s = screen.b + (screen.t - screen.b) / max(1, screen.ny - 1) * j
    return u_s, v_s


def _square(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
    u_s, _ = SLIDES.pixel_center(screen, i, j)
    side = (screen.r - screen.l) / screen.nx
    return u_s, (screen.b + screen.t) / 2 + side * (j + 0.5 - screen.ny / 2)


def _transposed(frame: ViewFrame, u_s: Floats, v_s: Floats) -> Floats:
    matrix = np.concatenate([frame.u, frame.v, frame.n], axis=1).T
    x, y, z = (matrix[:, k : k + 1] for k in range(3))
    return x * u_s + y * v_s + z * frame.nu


def _axis_for_normal(frame: ViewFrame, u_s: Floats, v_s: Floats) -> Floats:
    return frame.u * u_s + frame.v * v_s + column([0, 0, 1]) * frame.nu


def _origin_kept(screen: VirtualScreen) -> ViewFrame:
    """n·ν becomes n·ν + P0, so that the direction is P."""
    frame = SLIDES.view_frame(screen)
    return frame._replace(n=frame.n + column(screen.P0) / frame.nu)


def _in_float32(P_minus_P0: Floats) -> Floats:
    return P_minus_P0.astype(np.float32).astype(np.float64)


def _beyond_unit(P0: Floats, d: Floats, t: Floats) -> Floats:
    return P0 + t * unit(d)


def _signed_depth(t: Floats, nu: float) -> Floats:
    return t * nu


def _depth_is_t(t: Floats, nu: float) -> Floats:
    return t


def _distance_of_unit(t: Floats, d_length: Floats) -> Floats:
    return t


def _normalised(P_minus_P0: Floats) -> Floats:
    return P_minus_P0 / norm(P_minus_P0)


MUTANTS = (
    Mutant("nu-without-sign", "S1", "with |ν| in the place of ν",
           "A screen 'in front' feels like a positive distance, but n may point to the viewer.",
           "ray", SLIDES.replace(view_frame=_screen_in_front)),
    Mutant("left-handed-frame-mirrored", "S1", "with u computed as v × n",
           "It is the same u in every right-handed frame, and a mirrored one in the others.",
           "ray", SLIDES.replace(view_frame=_right_handed)),
    Mutant("axes-exchanged", "S1", "with u and v exchanged",
           "Rows come before columns in an array's indices, and not in the viewing frame.",
           "ray", SLIDES.replace(view_frame=_axes_exchanged)),
    Mutant("screen-centred", "S1", "with the screen centred on the view axis",
           "A field of view and an aspect ratio describe only screens with l = −r and b = −t.",
           "ray", SLIDES.replace(pixel_center=_centred)),
    Mutant("no-half-pixel", "S2", "without the half pixel",
           "The ray goes through the pixel's lower left corner: i in the place of i + ½.",
           "ray", SLIDES.replace(pixel_center=_corner)),
    Mutant("no-half-pixel-vertically", "S2", "without the half pixel in v",
           "One of the two ½ was forgotten; the picture moves by half a row only.",
           "ray", SLIDES.replace(pixel_center=_corner_in_v)),
    Mutant("rows-from-top", "S2", "with row j counted from the top",
           "Image files count rows from the top; the slide's j = 0 is the bottom.",
           "ray", SLIDES.replace(pixel_center=_rows_from_top)),
    Mutant("columns-from-right", "S2", "with column i counted from the right",
           "A camera that looks along its +z axis sees the picture mirrored.",
           "ray", SLIDES.replace(pixel_center=_columns_from_right)),
    Mutant("pixels-border-to-border", "S2", "with centres spread from border to border",
           "linspace(l, r, nx) divides by nx − 1 and puts the outer centres on the border.",
           "ray", SLIDES.replace(pixel_center=_border_to_border)),
    Mutant("pixels-square", "S2", "with a row as high as a column is wide",
           "One pixel size was computed, from r − l, and used in both directions.",
           "ray", SLIDES.replace(pixel_center=_square)),
    Mutant("frame-matrix-transposed", "S3", "with the change-of-frame matrix transposed",
           "The axes became the matrix's rows: that is the change from modelling to viewing.",
           "ray", SLIDES.replace(model_from_view=_transposed)),
    Mutant("axis-z-for-n", "S3", "with the z axis in the place of n",
           "It is right for the observer who looks along z, as in a first example.",
           "ray", SLIDES.replace(model_from_view=_axis_for_normal)),
    Mutant("origin-not-subtracted", "S5", "with d = P in the place of P − P0",
           "It is right for the observer in the origin, as in a first example.",
           "ray", SLIDES.replace(view_frame=_origin_kept)),
    Mutant("direction-in-float32", "S5", "with d rounded to float32",
           "One array of the default type of a graphics card, among others of float64.",
           "ray", SLIDES.replace(ray_direction=_in_float32)),
    Mutant("direction-normalised", "S5", "with d normalised and t kept",
           "t becomes the distance, and is no longer 1 at the virtual screen.",
           "t", SLIDES.replace(ray_direction=_normalised)),
    Mutant("point-along-unit-direction", "S5", "with r(t) = P0 + t·d/‖d‖",
           "t was found with d and is used with the unit direction.",
           "t", SLIDES.replace(point_at=_beyond_unit)),
    Mutant("depth-with-sign-of-nu", "S5", "with depth t·ν in the place of t·|ν|",
           "It is the coordinate along n, which is negative in front of most cameras.",
           "t", SLIDES.replace(depth_of=_signed_depth)),
    Mutant("depth-is-t", "S5", "with t given as the depth",
           "They are the same where the screen is at distance 1.",
           "t", SLIDES.replace(depth_of=_depth_is_t)),
    Mutant("distance-is-t", "S5", "with t given as the distance",
           "They are the same where d is a unit vector, and here it is not.",
           "t", SLIDES.replace(distance_of=_distance_of_unit)),
)  # fmt: skip
