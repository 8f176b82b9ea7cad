"""Pictures that encode what POV-Ray knows of each pixel in the integers of a 16-bit PNG.

Every texture here is emissive and opaque, so that a colour is one exact code: POV-Ray computes
colours in float32, whose rounding stays below 2⁻⁸ of a step of 1/65535.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from converters.placement import Placement, reach
from converters.povray.scene import preamble
from converters.povray.shapes import FaceTexture, parallel_light, pieces, vector
from minirt.scene import Scene, Sphere
from minirt.vectors import Bools, Floats, Ints

#: Largest code of a 16-bit PNG.
WHITE = 65535
#: Base of the two digits in which a position is encoded: codes stay below a half.
BASE = 2**15
#: The code that is added where the light arrives.
_LIT = 2**14
#: Codes of the two sides of a surface.
_OUTSIDE, _INSIDE = 1, 2


@dataclass(frozen=True)
class Grid:
    """The grid in which positions are encoded: low + span · k / BASE²."""

    low: Floats
    span: float

    @classmethod
    def of(cls, scene: Scene, placement: Placement) -> Grid:
        """A cube around every object, its side a power of two."""
        bounds = np.zeros((2, 3)) if scene.bounds is None else placement.points(scene.bounds)
        span = 2.0 ** math.frexp(1.25 * float((bounds[1] - bounds[0]).max()) + 2.0**-20)[1]
        return cls(bounds.mean(axis=0) - span / 2, span)

    def position(self, high: Ints, low: Ints) -> Floats:
        """Positions (n, 3), in POV-Ray's coordinates, from digits (n, 3): middles of steps."""
        steps = high.astype(np.float64) * BASE + low + 0.5
        position: Floats = self.low + steps * (self.span / BASE**2)
        return position

    @property
    def step(self) -> float:
        """Length of a step, in POV-Ray's units."""
        return self.span / BASE**2


def pictures(scene: Scene, placement: Placement, grid: Grid) -> dict[str, str]:
    """The texts of the four pictures, by their names."""
    plain = _shapes(scene, placement, lambda *_: "texture { Plain }")
    more = {
        "where-1": [_where(grid, 1)],
        "where-2": [_where(grid, 2)],
        "normal": _normal(reach(scene, placement)),
    }
    first = preamble(scene, placement, levels=1)  # no reflected or refracted rays
    texts = {name: [*first, *lines, *plain, ""] for name, lines in more.items()}
    texts["what"] = [*first, *_what(scene, placement), ""]
    return {name: "\n".join(lines) for name, lines in texts.items()}


def _what(scene: Scene, placement: Placement) -> list[str]:
    """Red and green: number of the face among all faces, plus 1; blue: its side, and the light.

    With brilliance 0 a lit surface is equally bright from every angle and on both sides, so that
    blue shows only whether it is lit.
    """
    white = (0.0, 0.0, 1.0)
    light = parallel_light(scene, placement, white)
    return [light, *_shapes(scene, placement, _Numbered(scene))]


def _where(grid: Grid, digit: int) -> str:
    """Red, green, blue: digit 1 or 2 of x, y, z, in the steps of a grid."""
    axes = []
    for axis, low, tint in zip("xyz", grid.low.tolist(), np.eye(3) * 3, strict=True):
        value = f"({axis} - ({low!r})) * {BASE / grid.span!r}"
        if digit == 2:
            value = f"({value} - floor({value})) * {BASE}"
        ramp = f"color_map {{ [0 rgb 0] [1 rgb {vector(tint)}] }}"
        axes.append(f"    [1 function {{ floor({value}) / {WHITE} }} {ramp}]")
    pigment = "\n".join(["average pigment_map {", *axes, "  }"])
    return f"#declare Plain = texture {{ pigment {{ {pigment} }} finish {{ emission 1 }} }}"


def _normal(coordinate: float) -> list[str]:
    """Red, green, blue: (1 + n)/2 of the normal turned to the viewer.

    Six lights without shadows, far beyond the largest coordinate: for each axis a positive light
    along it and a negative one against it.
    """
    lights = [
        f"light_source {{ {vector(4 * s * coordinate * axis)}, rgb {vector(s * axis)} "
        "parallel point_at <0, 0, 0> shadowless }"
        for axis in np.eye(3)
        for s in (1.0, -1.0)
    ]
    texture = "texture { pigment { rgb 1 } finish { emission 0.5 diffuse 0.5 } }"
    return [*lights, f"#declare Plain = {texture}"]


def read_what(scene: Scene, codes: Ints) -> tuple[Ints, Ints, Bools, Bools]:
    """Object and face (n,), −1 for a miss; whether its outside is seen; whether it is lit."""
    number = codes[:, 0].astype(np.int64) + 2**16 * codes[:, 1].astype(np.int64) - 1
    first = np.append(_first_faces(scene), 0)
    thing = (np.searchsorted(first[:-1], number, side="right") - 1).astype(np.int32)
    face = np.where(number < 0, -1, number - first[thing]).astype(np.int32)
    lit = codes[:, 2] >= _LIT
    return thing, face, codes[:, 2] - _LIT * lit == _OUTSIDE, lit


def read_normal(codes: Ints, outside: Bools) -> Floats:
    """Geometric normals (n, 3) from the codes of those turned to the viewer."""
    turned = 2.0 * codes.astype(np.float64) / WHITE - 1.0
    normal: Floats = np.where(outside[:, None], turned, -turned)
    return normal


def _first_faces(scene: Scene) -> Ints:
    """Number of each object's first face among all faces."""
    counts = [1 if isinstance(thing, Sphere) else len(thing.faces) for thing in scene.objects]
    return np.concatenate([[0], np.cumsum(counts)])[:-1].astype(np.int64)


class _Numbered:
    """The texture that encodes a face by its index among all faces, and its side."""

    def __init__(self, scene: Scene) -> None:
        self.first = _first_faces(scene).tolist()

    def __call__(self, number: int, face: int) -> str:
        code = self.first[number] + face + 1
        return " ".join(
            f"{kind} {{ pigment {{ rgb 1 }} finish {{ emission "
            f"rgb <{code % 2**16}, {code // 2**16}, {side}> / {WHITE} "
            f"diffuse {_LIT / WHITE!r}, {_LIT / WHITE!r} brilliance 0 }} }}"
            for kind, side in (("texture", _OUTSIDE), ("interior_texture", _INSIDE))
        )


def _shapes(scene: Scene, placement: Placement, texture: FaceTexture) -> list[str]:
    numbers = range(len(scene.objects))
    return [piece for k in numbers for piece in pieces(scene, k, placement, texture)]
