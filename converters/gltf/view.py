"""The screen as glTF's camera, the light as KHR_lights_punctual's, and the nodes that hold them.

Source: glTF 2.0 specification, section 3.10 (cameras); the extension KHR_lights_punctual.
"""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np

from converters.gltf.materials import Description
from minirt.scene import Scene
from minirt.screen import VirtualScreen
from minirt.vectors import Floats, cross, unit

#: The camera's near plane over the scene's extent.
_NEAR = 2.0**-10


def camera(scene: Scene) -> Description:
    """The centred camera that just contains the screen; the screen itself under ``extras``."""
    screen = scene.screen
    width, height = max(-screen.l, screen.r), max(-screen.b, screen.t)
    return {
        "type": "perspective",
        "perspective": {
            "yfov": 2 * math.atan2(height, abs(screen.nu)),
            "aspectRatio": width / height,
            "znear": _NEAR * scene.extent,
        },
        "extras": {"screen": asdict(screen)},
    }


def camera_node(screen: VirtualScreen) -> Description:
    """The camera's node: it looks along −z, x to the right, y up, in a right-handed frame."""
    z = -math.copysign(1.0, screen.nu) * np.array(screen.n)
    y = np.array(screen.v)
    return {"name": "screen", "camera": 0, "matrix": _matrix(cross(y, z), y, z, screen.P0)}


def light(color: tuple[float, float, float]) -> Description:
    """The light, π times the colour: a Lambertian surface then reflects diffuse · color · cos θ."""
    brightest = max(color) or 1.0
    return {
        "type": "directional",
        "color": [channel / brightest for channel in color],
        "intensity": math.pi * max(color),
    }


def light_node(scene: Scene) -> Description:
    """The light's node: a directional light shines along its −z."""
    l = np.array(scene.light_direction)
    z = -unit(l / np.abs(l).max())  # no overflow in the length
    x = _sideways(z)
    return {
        "name": "light",
        "matrix": _matrix(x, cross(z, x), z, scene.screen.P0),
        "extensions": {"KHR_lights_punctual": {"light": 0}},
    }


def _sideways(z: Floats) -> Floats:
    """A unit vector perpendicular to the unit vector z."""
    axis = np.zeros(3)
    axis[np.abs(z).argmin()] = 1.0
    return unit(cross(axis, z))


def _matrix(x: Floats, y: Floats, z: Floats, origin: tuple[float, float, float]) -> list[float]:
    """A node's matrix, column by column."""
    columns = (*((*axis.tolist(), 0.0) for axis in (x, y, z)), (*origin, 1.0))
    return [value for column in columns for value in column]
