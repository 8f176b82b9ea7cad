"""A scene on which an ε ten times too large shows: a leaf at five ε above a floor.

The observer looks at the floor from below, so that each point that the leaf shades is seen. A
shadow ray from there meets the leaf at 5ε/cos θ, θ < 60° being the light's slant: between 5ε and
10ε.
"""

from __future__ import annotations

from typing import Any

_EPSILON = 1e-4
_LEAF = 5 * _EPSILON
_GRAY = {"ambient": [0.1, 0.1, 0.1], "diffuse": [0.7, 0.7, 0.7]}


def _square(name: str, half: float, y: float) -> dict[str, Any]:
    corners = [[-half, y, half], [half, y, half], [half, y, -half], [-half, y, -half]]
    return {"type": "polygon", "name": name, "material": "gray", "vertices": corners}


THIN_GAP: dict[str, Any] = {
    "minirt": 1,
    "name": "thin-gap",
    "about": "a leaf at five ε above a floor that is seen from below",
    "proves": "that shadow rays start at ε and not at ten times as much",
    "failure_means": "that ε is too large",
    "rules": ["S12"],
    "screen": {
        "look_at": {"eye": [0.3, -5, 0.4], "target": [0, 0, 0], "up": [0, 0, 1], "fov_y": 40},
        "nx": 64,
        "ny": 48,
    },
    "light": {"direction": [-0.5, -1, -0.3]},
    "epsilon": _EPSILON,
    "materials": {"gray": _GRAY},
    "objects": [_square("floor", 2, 0), _square("leaf", 1, _LEAF)],
}
