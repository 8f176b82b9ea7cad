"""The scenes on which mutants are run: small images of the atlas, and one made for ε.

Each process traces a scene once, and once measures its stability under float64's rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from minirt import load_scene
from minirt.frame import Frame
from minirt.scene import Scene
from reference.compare.comparison import Comparison, compare
from reference.compare.stability import Exact, Stability, exact_answer, stability_of
from reference.source import Declared

#: Columns and rows of the pictures.
SIZE = (48, 36)

#: The atlas scenes that the mutants are run on. They have also off-axis screens, another
#: handedness, ν of either sign and not 1, pixels that are not square, an observer inside
#: a sphere and inside glass, polygons of many corners, objects behind the observer,
#: mirrors, total reflection, a closed mesh of 5,000 triangles.
SCENES = (
    "ball-on-quad", "alpha", "left-handed-frame", "negative-nu", "non-square-pixels",
    "behind-the-observer", "pentagon-and-octagon", "inside-a-sphere", "inside-glass",
    "snells-window", "closed-mesh",
)  # fmt: skip

_EPSILON = 1e-4
_GRAY = {"ambient": [0.1, 0.1, 0.1], "diffuse": [0.7, 0.7, 0.7]}


def _square(name: str, half: float, y: float) -> dict[str, Any]:
    corners = [[-half, y, half], [half, y, half], [half, y, -half], [-half, y, -half]]
    return {"type": "polygon", "name": name, "material": "gray", "vertices": corners}


#: An ε ten times too large shows here: a leaf lies five ε above a floor. The observer sees the
#: floor from below, so that each point in the leaf's shadow is visible. A shadow ray from there
#: meets the leaf at 5ε/cos θ, where θ < 60° is the slant of the light: between 5ε and 10ε.
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
    "objects": [_square("floor", 2, 0), _square("leaf", 1, 5 * _EPSILON)],
}


@dataclass(frozen=True, eq=False)
class MeasuredScene:
    """A scene with minirt's own answer and its stability under float64's rounding."""

    scene: Scene
    exact: Exact
    stability: Stability

    def compare(self, frame: Frame, pictures: bool = False) -> Comparison:
        """Compare a frame with minirt's pixel by pixel, which must suffice; or as pictures too."""
        return compare(self.scene, self.exact.frame, self.stability, frame, {}, pictures=pictures)


def reduced(scene: Scene, size: tuple[int, int] = SIZE) -> Scene:
    """The same scene in fewer, larger pixels."""
    document = scene.to_dict()
    document["screen"] |= {"nx": size[0], "ny": size[1]}
    return load_scene(document, folder=scene.folder)


def float64_rounding(scene: Scene) -> Declared:
    """The error of a renderer in float64: 256 roundings of 2⁻⁵² at the scale of the scene."""
    delta = 2.0**-44 * scene.extent
    return Declared(delta, 0.0, 2.0**-44, 2.0**-44, None, "256 roundings of 2⁻⁵²")


def measured_scene(scene: Scene) -> MeasuredScene:
    """Trace a scene and measure its stability, once for all mutants."""
    exact = exact_answer(scene)
    return MeasuredScene(scene, exact, stability_of(exact, float64_rounding(scene)))


@cache
def measured_atlas_scene(name: str) -> MeasuredScene:
    """A scene of the atlas in the matrix's size, measured once in each process."""
    return measured_scene(reduced(load_scene(f"atlas:{name}")))


@cache
def matrix_scenes() -> tuple[MeasuredScene, ...]:
    """The scenes of the matrix, measured once in each process."""
    return (*map(measured_atlas_scene, SCENES), measured_scene(load_scene(THIN_GAP)))
