"""One pixel in space: the virtual screen, the rays that it is made of, and the objects' edges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from minirt.explain.pixel import Explanation
from minirt.explain.steps import Value
from minirt.scene import Facets, Scene, Sphere
from minirt.screen import VirtualScreen

Point = tuple[float, ...]

#: Edges that are drawn of one object at most; of a finer one every k-th is.
_MOST_EDGES = 400


@dataclass(frozen=True)
class Line:
    """A ray, or a normal, of the picture.

    Attributes
    ----------
    kind : str
        ray, normal, shadow, reflected or refracted.
    start, direction : tuple of 3 float
        The direction is a unit vector.
    length : float or None
        Distance to what it meets; None where it meets nothing.
    meets : str
        What it meets, in words; empty for a normal.
    """

    kind: str
    start: Point
    direction: Point
    length: float | None
    meets: str


def lines_of(scene: Scene, explanation: Explanation) -> tuple[Line, ...]:
    """The rays of an explanation, in its order."""
    steps = {step.title: step.values for step in explanation.steps}
    ray = steps["the ray"]
    hit = steps["the first object hit"]
    point = steps.get("the point")
    reach = None if point is None else _float(point["distance"])
    lines = [
        Line("ray", _vector(ray["P0"]), _vector(ray["ray"]), reach, _met(scene, hit, "object"))
    ]
    if point is None:
        return tuple(lines)
    M = _vector(point["position"])
    lines.append(Line("normal", M, _vector(steps["the normal"]["normal"]), None, ""))
    shadow, length = steps["the shadow ray"], None
    to_light = _vector(shadow["-l"])
    if shadow["shadow"]:
        length = _float(shadow["t"])
    lines.append(Line("shadow", M, to_light, length, _met(scene, shadow, "object", "the light")))
    for kind, title, name in (
        ("reflected", "the reflected ray", "reflection"),
        ("refracted", "the refracted ray", "refraction"),
    ):
        values = steps.get(title)
        if values is not None and np.isfinite(_vector(values[name])).all():
            far = _float(values[f"{name}_t"])
            meets = _met(scene, values, f"{name}_object")
            reach = far if np.isfinite(far) else None
            lines.append(Line(kind, M, _vector(values[name]), reach, meets))
    return tuple(lines)


def _float(value: Value) -> float:
    assert isinstance(value, int | float)  # noqa: S101 - of the steps' own making
    return float(value)


def _vector(value: Value) -> Point:
    assert isinstance(value, tuple)  # noqa: S101 - of the steps' own making
    return value


def _met(scene: Scene, values: Mapping[str, Value], name: str, none: str = "nothing") -> str:
    index = int(_float(values[name]))
    return none if index < 0 else f"object {index} '{scene.objects[index].name}'"


def surroundings(scene: Scene) -> dict[str, Any]:
    """The observer, the virtual screen's corners and the objects, as JSON data."""
    return {
        "P0": list(scene.screen.P0),
        "screen": [list(corner) for corner in _corners(scene.screen)],
        "objects": [_drawn(scene, thing) for thing in scene.objects],
    }


def _corners(screen: VirtualScreen) -> Sequence[Point]:
    """The virtual screen's corners, once around."""
    u, v, n, P0 = (np.array(getattr(screen, name)) for name in ("u", "v", "n", "P0"))
    around = (
        (screen.l, screen.b),
        (screen.r, screen.b),
        (screen.r, screen.t),
        (screen.l, screen.t),
    )
    return [tuple((P0 + x * u + y * v + screen.nu * n).tolist()) for x, y in around]


def _drawn(scene: Scene, thing: Sphere | Facets) -> dict[str, Any]:
    material = scene.materials[thing.material]
    entry: dict[str, Any] = {
        "name": thing.name,
        "type": thing.type,
        "color": [min(1.0, a + d) for a, d in zip(material.ambient, material.diffuse, strict=True)],
    }
    if isinstance(thing, Sphere):
        return entry | {"center": thing.center.tolist(), "radius": thing.radius}
    edges = _edges(thing)
    step = -(-len(edges) // _MOST_EDGES)
    shown = edges[::step] if step else edges
    used, places = np.unique(shown, return_inverse=True)
    return entry | {
        "vertices": [[float(f"{x:.6g}") for x in vertex] for vertex in thing.vertices[used]],
        "edges": places.reshape(-1, 2).tolist(),
        "left out": len(edges) - len(shown),
    }


def _edges(thing: Facets) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Vertex pairs, each once; of a polygon those around it, without its fan's."""
    faces = thing.faces.astype(np.int64)
    if thing.type == "polygon":
        around = np.arange(len(thing.vertices))
        return np.stack((around, np.roll(around, -1)), axis=1)
    pairs = np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]))
    return np.unique(np.sort(pairs, axis=1), axis=0)
