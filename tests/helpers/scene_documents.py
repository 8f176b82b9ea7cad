"""A small scene as JSON data, and ways to change it."""

from __future__ import annotations

import copy
from typing import Any

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
PENTAGRAM = [[0, 3, 0], [2, -3, 0], [-3, 1, 0], [3, 1, 0], [-2, -3, 0]]
BASE: dict[str, Any] = {
    "minirt": 1, "name": "small",
    "screen": {"P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
               "l": -1.0, "r": 1.0, "b": -1.0, "t": 1.0, "nx": 4, "ny": 4},
    "light": {"direction": [-1, -2, -1]},
    "materials": {"m": {}},
    "objects": [
        {"type": "sphere", "material": "m", "center": [0, 0, 0], "radius": 1.0},
        {"type": "polygon", "material": "m", "vertices": SQUARE},
        {"type": "triangle", "material": "m", "vertices": SQUARE[:3]},
    ],
}  # fmt: skip
LOOK_AT = {"eye": [3, 2, 5], "target": [0, 0.5, 0], "up": [0, 1, 0], "fov_y": 40}
GONE = object()


def changed(path: tuple[str | int, ...], value: Any) -> dict[str, Any]:
    """The scene with another value at a place; without the key for `GONE`."""
    document = copy.deepcopy(BASE)
    place: Any = document
    for key in path[:-1]:
        place = place[key]
    if value is GONE:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return document


def look_at(**changes: Any) -> dict[str, Any]:
    """A screen in the look-at form."""
    return {"look_at": {**LOOK_AT, **changes}, "nx": 8, "ny": 4}
