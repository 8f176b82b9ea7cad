"""Camera, light and shapes in POV-Ray's scene language, every number a float64's shortest text."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator

import numpy as np

from converters.placement import Placement, reach
from minirt.scene import Object, Scene, Sphere
from minirt.vectors import Floats, norm

#: The texture of a face, from the object's number and the face's.
FaceTexture = Callable[[int, int], str]

#: What is clipped by Nowhere is never hit: boxes that only enlarge a bounding box (see `piece`).
_NOWHERE = "#declare Nowhere = box { -1e9, 1e9 inverse }"
#: What is clipped by Elsewhere excludes the observer's own place. Otherwise POV-Ray would count the
#: spheres around the observer as media from the start, in an undefined order; it finds no hits so
#: near anyway.
_ELSEWHERE = "#declare Elsewhere = sphere {{ {observer}, 1e-5 inverse }}"


def povray_placement(scene: Scene) -> Placement:
    """The placement of a scene in POV-Ray's coordinates: its extent falls within [2048, 4096).

    POV-Ray's tolerances are absolute: secondary rays ignore hits nearer than 1e-3 and chords of
    spheres below 2e-5, and rays end at 1e7. At this size they are below 5e-7 of the extent, less
    than minirt's own ε. Where the scene is far from the origin, its middle becomes the origin, so
    that the observer and the objects keep their precision.
    """
    exponent = math.frexp(scene.extent)[1]  # extent = m · 2**exponent, ½ ≤ m < 1
    placement = Placement(2.0 ** (12 - exponent))
    if reach(scene, placement) <= 2 * placement.length(scene.extent):
        return placement
    corners = [np.array(scene.screen.P0), *([] if scene.bounds is None else scene.bounds)]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    x, y, z = (0.5 * low + 0.5 * high).tolist()
    return Placement(placement.scale, (x, y, z))


def vector(values: Floats | tuple[float, ...] | list[float]) -> str:
    """``<x, y, z>``, each number with all its digits."""
    return "<" + ", ".join(repr(float(value)) for value in values) + ">"


def clip_regions(scene: Scene, placement: Placement) -> list[str]:
    """The two regions that shapes are clipped by."""
    observer = vector(placement.points(np.array(scene.screen.P0)))
    return [_NOWHERE, _ELSEWHERE.format(observer=observer)]


def camera(scene: Scene, placement: Placement) -> str:
    """S1 and S2: the screen's edges are the camera's vectors, also off-axis or with other pixels.

    POV-Ray's pixel centres lie at ½, its row 0 at the top. The vectors are scaled by a power of
    two, since it refuses short ones.
    """
    s = scene.screen
    u, v, n = (np.array(axis) for axis in (s.u, s.v, s.n))
    middle = (s.l + s.r) / 2 * u + (s.b + s.t) / 2 * v + s.nu * n
    right, up = (s.r - s.l) * u, (s.t - s.b) * v
    unit = 2.0 ** -math.frexp(float(np.abs(np.stack([middle, right, up])).max()))[1]
    lines = [
        f"  location {vector(placement.points(np.array(s.P0)))}",
        *(f"  {k} {vector(unit * a)}" for k, a in zip(("direction", "right", "up"),
                                                      (middle, right, up), strict=True)),
    ]  # fmt: skip
    return "\n".join(["camera {", "  perspective", *lines, "}"])


def parallel_light(scene: Scene, placement: Placement, color: tuple[float, ...]) -> str:
    """S12's light: POV-Ray's shadow rays to it are parallel, and end beyond every object.

    Parameters
    ----------
    scene : Scene
    placement : Placement
    color : tuple of 3 float
        The light's, with the exposure.
    """
    l = np.array(scene.light_direction)
    l = l / np.abs(l).max()  # no overflow in the length
    away = -4 * reach(scene, placement) / float(np.sqrt((l * l).sum())) * l
    return f"light_source {{ {vector(away)}, rgb {vector(color)} parallel point_at <0, 0, 0> }}"


def comment(number: int, thing: Object) -> str:
    """A comment that names an object: one short line of ASCII, whatever the name contains."""
    return f"// object {number}: {thing.type} {json.dumps(thing.name)[:60]}"


def pieces(
    scene: Scene, number: int, placement: Placement, texture: FaceTexture, modifiers: str = ""
) -> Iterator[str]:
    """Object `number` of a scene as pieces that POV-Ray can each bound by a box.

    Triangles are written a, c, b: POV-Ray's normal is then ours. Its own `mesh` would round
    vertices to float32. A degenerate triangle, which is never hit, is left out.

    Parameters
    ----------
    scene : Scene
    number : int
    placement : Placement
    texture : function
        From the numbers of object and face to a texture.
    modifiers : str
        Of every piece, for example ``no_shadow``.
    """
    thing = scene.objects[number]
    if isinstance(thing, Sphere):
        center, radius = placement.points(thing.center), placement.length(thing.radius)
        inside = float(norm(thing.center - np.array(scene.screen.P0))) < thing.radius
        clip = " clipped_by { object { Elsewhere } }" if inside else ""
        shape = f"sphere {{ {vector(center)}, {radius!r} {texture(number, 0)}{clip} }}"
        yield piece([shape], center - radius, center + radius, modifiers)
        return
    corners = placement.points(thing.vertices)[thing.faces]
    real = np.flatnonzero((thing.edge_normals != 0).any(axis=0))
    shapes = [
        "triangle { " + ", ".join(map(vector, corners[k][[0, 2, 1]])) + f" {texture(number, k)} }}"
        for k in real.tolist()
    ]
    if thing.type == "polygon":
        yield piece(shapes, corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), modifiers)
        return
    for k, shape in zip(real.tolist(), shapes, strict=True):
        yield piece([shape], corners[k].min(axis=0), corners[k].max(axis=0), modifiers)


def piece(shapes: list[str], low: Floats, high: Floats, modifiers: str = "") -> str:
    """Shapes that share a bounding box a little larger than they are.

    POV-Ray keeps and tests bounding boxes in float32: a shape would stick out of its own by up to a
    few 2⁻²⁴ of the coordinates, which are at most √3 · 8192. A box that is never hit joins the
    shapes and adds a margin of 2⁻⁶; a union's parts are not tested against boxes of their own.

    Parameters
    ----------
    shapes : list of str
    low, high : (3,) float64
        Corners of their bounding box, in POV-Ray's coordinates.
    modifiers : str
        Of the union.
    """
    room = f"box {{ {vector(low - 2.0**-6)}, {vector(high + 2.0**-6)} "
    room += "clipped_by { object { Nowhere } } }"
    return "\n  ".join(["union {", room, *shapes, f"split_union off {modifiers}".rstrip()]) + "\n}"
