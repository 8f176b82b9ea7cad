"""Random scene documents of all shapes, materials and screens, fixed by seed and number."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

from minirt.vectors import Floats
from reference.fuzz.placements import (
    PLACEMENTS,
    Document,
    direction,
    numbers,
    point,
    unit,
)
from reference.fuzz.seeded_draw import draw_one
from reference.fuzz.transform import transformed

#: Distance between the seeds of two campaigns: more than the number of scenes of any campaign.
_STRIDE = 2**32
#: Powers of ten by which a scene is scaled.
SCALES = (-6.0, 6.0)
_SHARE = st.floats(0, 1)


def scene_document(seed: int, number: int) -> Document:
    """Scene `number` of a campaign, as the dict of its JSON; its meshes are in `mesh_folder`.

    Examples
    --------
    >>> scene_document(7, 0) == scene_document(7, 0)
    True
    """
    drawn = draw_one(documents(), seed * _STRIDE + number)
    return drawn | {"name": f"fuzz-{seed}-{number}"}


def mesh_folder() -> Path:
    """The folder with the meshes of drawn scenes: the atlas."""
    return Path(str(resources.files("minirt").joinpath("atlas")))


@st.composite
def documents(draw: st.DrawFn) -> Document:
    """Scenes of 1–7 groups of objects in a box of side 4, scaled and translated as a whole."""
    screen = _screen(draw)
    materials = {f"m{k}": _material(draw) for k in range(draw(st.integers(1, 4)))}
    document: Document = {
        "minirt": 1,
        "name": "fuzz",
        "screen": screen,
        "light": {"direction": numbers(direction(draw)), "color": _color(draw, 0.2, 1)},
        "background": _color(draw, 0, 0.5),
        "shadow_color": _color(draw, 0, 0.3) if draw(st.integers(0, 3)) == 0 else None,
        "max_depth": draw(st.integers(0, 4)),
        "materials": materials,
        "objects": _objects(draw, screen, sorted(materials)),
    }
    scale, shift = 1.0, np.zeros(3)
    if draw(st.booleans()):
        scale = 10.0 ** draw(st.floats(*SCALES))
    if draw(st.integers(0, 3)) == 0:
        shift = scale * 10.0 ** draw(st.floats(0, 2)) * direction(draw)
    return transformed(document, np.eye(3), scale, shift)


def _objects(draw: st.DrawFn, screen: Document, materials: list[str]) -> list[Document]:
    objects: list[Document] = []
    for _ in range(draw(st.integers(1, 7))):
        placement = draw(st.sampled_from(["free", "free", *PLACEMENTS]))
        for entry in PLACEMENTS[placement](draw, screen):
            tags = {
                "name": f"{placement}-{len(objects)}",
                "material": draw(st.sampled_from(materials)),
            }
            objects.append(entry | tags)
    return objects


def _screen(draw: st.DrawFn) -> Document:
    """Either handedness, either sign of ν, on and off the axis; one in eight not square pixels."""
    inside = draw(st.integers(0, 7)) == 0
    eye = direction(draw) * draw(st.floats(0, 1) if inside else st.floats(4, 9))
    n = _view_direction(eye, 0.25 * point(draw))
    u = unit(np.cross(_not_along(n, direction(draw)), n))
    v = np.cross(n, u) * draw(st.sampled_from([-1.0, 1.0]))
    nu = -draw(st.floats(0.3, 2))
    if draw(st.booleans()):
        n, nu = -n, -nu
    nx, ny = draw(st.sampled_from([32, 40, 48, 64])), draw(st.sampled_from([24, 32, 36, 48]))
    side = abs(nu) * draw(st.floats(0.4, 1.4)) / nx
    high = side * (draw(st.floats(0.5, 2)) if draw(st.integers(0, 7)) == 0 else 1.0)
    left = (-0.5 + draw(st.floats(-0.2, 0.2))) * side * nx
    bottom = (-0.5 + draw(st.floats(-0.2, 0.2))) * high * ny
    return {
        "P0": numbers(eye), "u": numbers(u), "v": numbers(unit(v)), "n": numbers(n), "nu": nu,
        "l": left, "r": left + side * nx, "b": bottom, "t": bottom + high * ny,
        "nx": nx, "ny": ny,
    }  # fmt: skip


def _view_direction(eye: Floats, target: Floats) -> Floats:
    """The unit vector from the target to the eye; the z axis where they are the same."""
    away = eye - target
    return unit(away) if float(away @ away) > 1e-6 else np.array([0.0, 0.0, 1.0])


def _not_along(n: Floats, other: Floats) -> Floats:
    """A vector that is not along n: the other, or an axis."""
    axis = np.zeros(3)
    axis[int(np.abs(n).argmin())] = 1.0
    return other if abs(float(n @ other)) < 0.99 else axis


def _material(draw: st.DrawFn) -> dict[str, Any]:
    material: dict[str, Any] = {
        "ambient": _color(draw, 0, 0.1),
        "diffuse": _color(draw, 0, 0.9),
        "specular": _color(draw, 0, 0.5),
        "shininess": draw(st.integers(1, 60)),
    }
    kind = draw(st.sampled_from(["dull", "mirror", "index", "glass"]))
    if kind == "mirror":
        material["reflectance"] = 0.1 + 0.9 * draw(_SHARE)
    if kind in ("index", "glass"):
        material["ior"] = draw(st.one_of(st.floats(0.5, 2.5), st.sampled_from([1.0, 1.5])))
    if kind == "glass":
        material["transmittance"] = 0.1 + 0.5 * draw(_SHARE)
        material["reflectance"] = 0.4 * draw(_SHARE)
    return material


def _color(draw: st.DrawFn, low: float, high: float) -> list[float]:
    return [draw(st.floats(low, high)) for _ in range(3)]
