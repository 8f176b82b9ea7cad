"""Shrinking candidates: simpler versions of a scene document, the largest step first.

A candidate need not be a valid scene.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from minirt.scene import Facets, Scene
from reference.fuzz.placements import Document, numbers
from reference.fuzz.transform import transformed

#: Significant digits to which numbers are rounded, the fewest first.
DIGITS = (1, 2, 3, 4, 6, 9, 12)
#: Sides of the windows to which an image is cropped, in pixels.
SIDES = (1, 2, 4, 8)
#: The simplest value of each property of a material.
_SIMPLEST_MATERIAL: dict[str, Any] = {
    "ambient": [0.0, 0.0, 0.0], "diffuse": [0.8, 0.8, 0.8], "specular": [0.0, 0.0, 0.0],
    "shininess": 1, "transmittance": 0.0, "reflectance": 0.0, "ior": None, "alpha": 1.0,
}  # fmt: skip
#: The simplest value of each property of a scene.
_SIMPLEST_SCENE: dict[str, Any] = {
    "about": "", "proves": "", "failure_means": "", "rules": [], "floor": None,
    "background": [0.0, 0.0, 0.0], "shadow_color": None, "epsilon": None,
}  # fmt: skip


def windows(document: Document, column: int, row: int) -> Iterator[Document]:
    """Crop the screen along pixel borders to a window around a pixel, which keeps its ray.

    Parameters
    ----------
    column, row : int
        From the left, and from the TOP.
    """
    screen = document["screen"]
    nx, ny, j = screen["nx"], screen["ny"], screen["ny"] - 1 - row
    for side in SIDES:
        if side >= nx and side >= ny:
            return
        i0, i1 = _around(column, side, nx)
        j0, j1 = _around(j, side, ny)
        across, up = (screen["r"] - screen["l"]) / nx, (screen["t"] - screen["b"]) / ny
        cut = {
            "l": screen["l"] + across * i0, "r": screen["l"] + across * i1, "nx": i1 - i0,
            "b": screen["b"] + up * j0, "t": screen["b"] + up * j1, "ny": j1 - j0,
        }  # fmt: skip
        yield document | {"screen": screen | cut}


def _around(center: int, side: int, whole: int) -> tuple[int, int]:
    low = min(max(0, center - side // 2), max(0, whole - side))
    return low, min(whole, low + side)


def without_objects(document: Document, first: int, count: int) -> Document:
    """Without `count` objects from number `first` on, and without the materials left unused."""
    objects = document["objects"][:first] + document["objects"][first + count :]
    used = {entry["material"] for entry in objects}
    materials = {n: m for n, m in document["materials"].items() if n in used}
    return document | {"objects": objects, "materials": materials or document["materials"]}


def simpler_objects(document: Document, scene: Scene) -> Iterator[Document]:
    """One mesh or polygon replaced by one of its triangles, or one object in the first material."""
    for k, thing in enumerate(scene.objects):
        if isinstance(thing, Facets) and thing.type != "triangle":
            for face in thing.faces[:64]:
                corners = [numbers(vertex) for vertex in thing.vertices[face]]
                tags = {name: document["objects"][k][name] for name in ("name", "material")}
                one = {"type": "triangle", "vertices": corners} | tags
                yield _with_object(document, k, one)
    first = document["objects"][0]["material"] if document["objects"] else ""
    for k, entry in enumerate(document["objects"]):
        if entry["material"] != first:
            new = _with_object(document, k, entry | {"material": first})
            yield without_objects(new, len(new["objects"]), 0)


def simpler_properties(document: Document) -> Iterator[Document]:
    """One property of the scene, its light or a material at its simplest value."""
    for name, value in _SIMPLEST_SCENE.items():
        if document.get(name) != value:
            yield document | {name: value}
    for depth in range(document.get("max_depth", 5)):
        yield document | {"max_depth": depth}
    white = {"color": [1.0, 1.0, 1.0]}
    if document["light"].get("color") != white["color"]:
        yield document | {"light": document["light"] | white}
    for name, material in document["materials"].items():
        for key, value in _SIMPLEST_MATERIAL.items():
            if material.get(key, value) != value:
                plain = {name: material | {key: value}}
                yield document | {"materials": document["materials"] | plain}


def simpler_positions(document: Document) -> Iterator[Document]:
    """The scene in the observer's frame with the screen at distance 1, or translated only."""
    screen = document["screen"]
    axes = np.array([screen[axis] for axis in "uvn"])
    P0, scale = np.array(screen["P0"]), 1.0 / abs(screen["nu"])
    turn = axes if np.linalg.det(axes) > 0 else np.eye(3)
    for this_turn in (turn, np.eye(3)):
        for this_scale in (scale, 1.0):
            shift = -this_scale * (this_turn @ P0)
            new = transformed(document, this_turn, this_scale, shift)
            if this_turn is turn and not (turn == np.eye(3)).all():
                rows = np.eye(3).tolist()
                new["screen"] |= dict(zip("uvn", rows, strict=True))
            new["screen"]["P0"] = [0.0, 0.0, 0.0]
            if new != document:
                yield new


def roundings(document: Document) -> Iterator[Callable[[Document], Document]]:
    """Roundings, each of one part of the document, the largest parts first.

    Apply each to the current document: the paths of its parts do not change.
    """
    objects = [("objects", k) for k in range(len(document["objects"]))]
    bounds = [("screen", name) for name in ("nu", "P0", "l", "r", "b", "t")]
    materials = [("materials", name) for name in document["materials"]]
    places: list[tuple[Any, ...]] = [("light",), *objects, *bounds, *materials]
    numbers_in = [path for place in places for path in _paths(_at(document, place), place)]
    for place in [("objects",), *places, *numbers_in]:
        for digits in DIGITS:
            yield partial(_rounded_at, place=place, digits=digits)


def rounded(value: Any, digits: int) -> Any:
    """Round every float in JSON data to some significant digits.

    Examples
    --------
    >>> rounded({"center": [0.12345, 2.0], "type": "sphere"}, 2)
    {'center': [0.12, 2.0], 'type': 'sphere'}
    """
    if isinstance(value, float):
        return float(f"{value:.{digits - 1}e}")
    if isinstance(value, list):
        return [rounded(each, digits) for each in value]
    if isinstance(value, dict):
        return {key: rounded(each, digits) for key, each in value.items()}
    return value


def _with_object(document: Document, k: int, entry: Document) -> Document:
    objects = list(document["objects"])
    objects[k] = entry
    return document | {"objects": objects}


def _paths(value: Any, place: tuple[Any, ...]) -> Iterator[tuple[Any, ...]]:
    """The paths of the floats within a value."""
    if isinstance(value, float):
        yield place
    elif isinstance(value, dict | list):
        inner = value.items() if isinstance(value, dict) else enumerate(value)
        for key, each in inner:
            yield from _paths(each, (*place, key))


def _at(document: Document, place: tuple[Any, ...]) -> Any:
    value: Any = document
    for key in place:
        value = value[key]
    return value


def _rounded_at(document: Document, place: tuple[Any, ...], digits: int) -> Document:
    new = copy.deepcopy(document)
    parent = _at(new, place[:-1])
    parent[place[-1]] = rounded(parent[place[-1]], digits)
    return new
