"""The table of quantities: what a frame can hold, of which type and kind, and of which rule.

Everything that names a quantity (files, comparisons, reports, documentation) takes it from here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

Kind = Literal["discrete", "ratio", "length", "direction", "colour"]
Stage = Literal[
    "ray", "hit", "object", "t", "normal",
    "shadow", "reflection", "refraction", "secondary", "colour",
]  # fmt: skip

#: Causal order: a wrong pixel is attributed to the first of these stages in which it is wrong.
STAGES: tuple[Stage, ...] = (
    "ray", "hit", "object", "t", "normal",
    "shadow", "reflection", "refraction", "secondary", "colour",
)  # fmt: skip


@dataclass(frozen=True)
class Quantity:
    """One quantity of an image; arrays are (ny, nx) or (ny, nx, 3), row 0 at the top.

    Attributes
    ----------
    name : str
    dtype : str
        NumPy's name of the element type.
    components : int
        1, 2 or 3; the length of the last axis, which is absent for 1.
    kind : str
        discrete, ratio, length, direction or colour: decides how two values are compared.
    miss : float
        The value of pixels to which the quantity does not apply.
    rules : tuple of str
        The lecture's rules it belongs to.
    stage : str
        Its place in the causal order, one of `STAGES`.
    channels : tuple of str
        Its channel names in an OpenEXR file.
    about : str
        Its meaning, in words.
    """

    name: str
    dtype: str
    components: int
    kind: Kind
    miss: float
    rules: tuple[str, ...]
    stage: Stage
    channels: tuple[str, ...]
    about: str

    @property
    def discrete(self) -> bool:
        """Whether values are compared for equality."""
        return self.kind == "discrete"

    def shape(self, ny: int, nx: int) -> tuple[int, ...]:
        """Shape of its array in an image of ny rows and nx columns."""
        return (ny, nx) if self.components == 1 else (ny, nx, self.components)

    def missing(self, ny: int, nx: int) -> np.ndarray[Any, Any]:
        """An array of its type and shape that holds `miss` everywhere."""
        return np.full(self.shape(ny, nx), self.miss, dtype=self.dtype)


def _q(
    name: str, dtype: str, kind: Kind, miss: float, rules: str, stage: Stage, about: str,
    components: int = 1, channels: tuple[str, ...] = (),
) -> Quantity:  # fmt: skip
    if not channels:
        suffixes = {1: ("",), 2: (".x", ".y"), 3: (".x", ".y", ".z")}[components]
        channels = tuple(name + suffix for suffix in suffixes)
    return Quantity(
        name, dtype, components, kind, miss, tuple(rules.split()), stage, channels, about
    )


_INF, _NAN = float("inf"), float("nan")

QUANTITIES: dict[str, Quantity] = {
    q.name: q
    for q in (
        _q("ray", "float64", "direction", _NAN, "S1 S2 S3 S5", "ray",
           "unit direction d/‖d‖ of the pixel's ray; given at every pixel", 3),
        _q("hit", "bool", "discrete", 0, "S4 S6", "hit", "whether the pixel's ray meets an object"),
        _q("object", "int32", "discrete", -1, "S4", "object",
           "index of the first object met, in the scene's order"),
        _q("triangle", "int32", "discrete", -1, "S9 S11", "object",
           "face within the object (mesh face, fan triangle); 0 for a sphere"),
        _q("t", "float64", "ratio", _INF, "S5 S8 S9 S10", "t",
           "the ray's parameter at the hit: 1 at the virtual screen"),
        _q("depth", "float64", "length", _INF, "S5", "t",
           "t·|ν|: distance along the view axis, what a z-buffer calls z", channels=("Z",)),
        _q("distance", "float64", "length", _INF, "S5", "t",
           "t·‖d‖: Euclidean distance from the observer"),
        _q("position", "float64", "length", _NAN, "S5", "t",
           "the point hit, in modelling coordinates", 3),
        _q("barycentric", "float64", "ratio", _NAN, "S9", "t",
           "(β, γ) within the triangle hit; absent on spheres", 2),
        _q("normal", "float64", "direction", _NAN, "S8 S9 S10", "normal",
           "unit geometric normal on the outside, not turned to the viewer", 3),
        _q("shadow", "int8", "discrete", -1, "S12", "shadow", "1 in shadow, 0 lit"),
        _q("reflection", "float64", "direction", _NAN, "S14", "reflection",
           "unit direction ρ of the reflected ray, at every hit", 3),
        _q("reflection_object", "int32", "discrete", -1, "S14", "secondary",
           "object that the reflected ray meets"),
        _q("reflection_t", "float64", "length", _INF, "S14", "secondary",
           "distance along the reflected ray to what it meets"),
        _q("tir", "int8", "discrete", -1, "S16", "refraction",
           "1 total internal reflection, 0 not, −1 where the material has no index"),
        _q("refraction", "float64", "direction", _NAN, "S15 S16", "refraction",
           "unit direction ϱ of the refracted ray, where the material has an index", 3),
        _q("refraction_object", "int32", "discrete", -1, "S16", "secondary",
           "object that the refracted ray meets"),
        _q("refraction_t", "float64", "length", _INF, "S16", "secondary",
           "distance along the refracted ray to what it meets"),
        _q("color", "float64", "colour", _NAN, "S7 S13", "colour",
           "linear RGB of the pixel; the background where nothing is hit", 3, ("R", "G", "B")),
        _q("alpha", "float64", "colour", 0, "S4", "colour",
           "the material's α; 0 where nothing is hit", channels=("A",)),
    )
}  # fmt: skip
