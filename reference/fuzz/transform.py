"""Rotate, scale and translate a scene document as a whole: the image stays the same."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from minirt.vectors import Floats
from reference.fuzz.placements import Document, numbers


def transformed(document: Document, turn: Floats, scale: float, shift: Floats) -> Document:
    """A copy in which each point p is at scale·turn·p + shift.

    Parameters
    ----------
    document : dict
        A scene in the slides' form.
    turn : (3, 3) float64
        A rotation.
    scale : float
        More than 0.
    shift : (3,) float64
    """
    new = copy.deepcopy(document)

    def placed(point: Any) -> list[float]:
        return numbers(scale * (turn @ np.array(point)) + shift)

    screen = new["screen"]
    screen["P0"] = placed(screen["P0"])
    screen |= {axis: numbers(turn @ np.array(screen[axis])) for axis in "uvn"}
    screen |= {name: screen[name] * scale for name in ("nu", "l", "r", "b", "t")}
    new["light"]["direction"] = numbers(turn @ np.array(new["light"]["direction"]))
    if new.get("epsilon") is not None:
        new["epsilon"] *= scale
    for entry in new["objects"]:
        if entry["type"] == "sphere":
            entry |= {"center": placed(entry["center"]), "radius": entry["radius"] * scale}
        elif entry["type"] == "mesh":
            entry["transform"] = _transformed(np.array(entry["transform"]), turn, scale, shift)
        else:
            entry["vertices"] = [placed(vertex) for vertex in entry["vertices"]]
    return new


def _transformed(matrix: Floats, turn: Floats, scale: float, shift: Floats) -> list[list[float]]:
    top = scale * (turn @ matrix[:3])
    top[:, 3] += shift
    return [*(numbers(row) for row in top), [0.0, 0.0, 0.0, 1.0]]
