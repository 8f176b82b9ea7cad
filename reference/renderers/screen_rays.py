"""Lengths of the slides' rays, which turn a renderer's distance into their parameter t."""

from __future__ import annotations

import numpy as np

from minirt.screen import VirtualScreen, image_pixels, pixel_center
from minirt.vectors import Floats


def direction_lengths(screen: VirtualScreen) -> Floats:
    """‖d‖ of every pixel's ray, (ny·nx,) float64, top row first: t is distance over this."""
    u_s, v_s = pixel_center(screen, *image_pixels(screen, 0, screen.nx * screen.ny))
    return np.sqrt(u_s * u_s + v_s * v_s + screen.nu * screen.nu)
