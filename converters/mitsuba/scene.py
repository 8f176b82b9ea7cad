"""A scene for Mitsuba 3: a plain nested dict, or a folder for Mitsuba's own command.

Nothing here imports Mitsuba. What it cannot express exactly is listed with the materials
(`converters.mitsuba.materials`). Besides, a background that is not black becomes a `constant`
emitter, which also lights the objects, and a shadow colour has no counterpart.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from converters.atomic import atomic_folder, require_replaceable
from converters.mitsuba.materials import Description, material_to_dict, rgb
from converters.mitsuba.ply import write_ply
from converters.mitsuba.xml import scene_xml
from converters.placement import IDENTITY, Placement
from minirt.errors import InputError
from minirt.scene import Object, Scene, Sphere
from minirt.screen import VirtualScreen
from minirt.vectors import norm

#: Clipping planes of a scene whose extent lies in [1, 64]: no ray of it is clipped.
NEAR, FAR = 2.0**-20, 2.0**20
#: The files of an export, and the picture that its command renders.
EXPORTED = ("scene.xml", "object_*.ply", "scene.exr")


def scene_to_dict(scene: Scene, folder: Path, placement: Placement = IDENTITY) -> Description:
    """The scene as a nested dict for ``mitsuba.load_dict``, its meshes as PLY files in `folder`.

    Every value is a str, bool, int, float, list or dict; only the camera's ``to_world`` needs
    ``mitsuba.ScalarTransform4f(rows)`` made of its 4 rows. Object number k of the scene has the
    key `object_key(k)`; objects come last and in order.

    Parameters
    ----------
    scene : Scene
    folder : Path
        Exists.
    placement : Placement
        From scene coordinates to Mitsuba's.

    Returns
    -------
    dict

    Raises
    ------
    InputError
        The camera cannot be expressed: see `unsupported_camera`.
    """
    reason = unsupported_camera(scene.screen)
    if reason:
        raise InputError(reason, where=f"scene {scene.name!r}: screen")
    names = {name: f"material_{k:06d}" for k, name in enumerate(scene.materials)}
    return {
        "type": "scene",
        # the fast mode lets rays pass through the edge that two triangles share
        "embree_use_robust_intersections": True,
        "integrator": {"type": "path", "max_depth": scene.max_depth + 2, "rr_depth": 1_000_000},
        "sensor": _sensor(scene, placement),
        "light": _light(scene),
        **_background(scene),
        **{names[name]: material_to_dict(m) for name, m in scene.materials.items()},
        **{
            object_key(k): _shape(thing, k, names[thing.material], folder, placement)
            for k, thing in enumerate(scene.objects)
        },
    }


def object_key(number: int) -> str:
    """The key and id of an object; sorting the ids keeps the scene's order."""
    return f"object_{number:06d}"


def export_mitsuba(
    scene: Scene,
    folder: Path,
    placement: Placement = IDENTITY,
    integrator: Description | None = None,
) -> None:
    """Write ``scene.xml`` and PLY files that ``mitsuba -m scalar_rgb scene.xml`` renders as is.

    The folder appears whole or not at all; an earlier export in its place is replaced.

    Parameters
    ----------
    folder : Path
    integrator : dict, optional
        Instead of the path tracer.

    Raises
    ------
    InputError
        The camera cannot be expressed, or the folder holds other files or cannot be written.
    """
    require_replaceable(folder, EXPORTED)
    with atomic_folder(folder) as staging:
        description = scene_to_dict(scene, staging, placement)
        if integrator is not None:
            description["integrator"] = integrator
        (staging / "scene.xml").write_text(scene_xml(description), encoding="utf-8")


def unsupported_camera(screen: VirtualScreen) -> str | None:
    """Why Mitsuba's perspective camera cannot be this screen; None where it can.

    Its pixels are square. A deviation below float32's rounding, 2⁻²⁴, is not one.
    """
    width, height = (screen.r - screen.l) / screen.nx, (screen.t - screen.b) / screen.ny
    if abs(width - height) > 2.0**-24 * height:
        return "Mitsuba's camera has square pixels only"
    return None


def near_clip(scene: Scene, placement: Placement) -> float:
    """The camera's near plane in Mitsuba's coordinates: its rays start there."""
    return NEAR * _magnitude(scene, placement)


def _magnitude(scene: Scene, placement: Placement) -> float:
    """The scale of a placed scene outside [1, 64], as a power of two; 1 within."""
    extent = placement.length(scene.extent)
    return 2.0 ** math.frexp(extent)[1] if not 1 <= extent <= 64 else 1.0


def _sensor(scene: Scene, placement: Placement) -> Description:
    screen = scene.screen
    width, height = screen.r - screen.l, screen.t - screen.b
    return {
        "type": "perspective",
        "fov_axis": "x",
        "fov": math.degrees(2 * math.atan2(width, 2 * abs(screen.nu))),
        "principal_point_offset_x": (screen.l + screen.r) / 2 / width,
        "principal_point_offset_y": -(screen.b + screen.t) / 2 / height,
        "near_clip": near_clip(scene, placement),
        "far_clip": FAR * _magnitude(scene, placement),
        "to_world": _camera_rows(screen, placement),
        "sampler": {"type": "stratified", "sample_count": 1, "jitter": False},
        "film": {
            "type": "hdrfilm",
            "width": screen.nx,
            "height": screen.ny,
            "pixel_format": "rgba",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
    }


def _camera_rows(screen: VirtualScreen, placement: Placement) -> list[list[float]]:
    """Mitsuba's camera looks along +z with +x to the left: columns −u, v, sign(ν)·n and P0."""
    forward = math.copysign(1.0, screen.nu) * np.array(screen.n)
    origin = placement.points(np.array(screen.P0))
    columns = np.stack((-np.array(screen.u), np.array(screen.v), forward, origin), axis=1)
    rows: list[list[float]] = columns.tolist()
    return [*rows, [0.0, 0.0, 0.0, 1.0]]


def _light(scene: Scene) -> Description:
    """Irradiance π·color: a Lambertian surface then reflects diffuse · color · cos θ."""
    direction = np.array(scene.light_direction)
    direction = direction / np.abs(direction).max()  # no overflow in the length
    r, g, b = (math.pi * channel for channel in scene.light_color)
    return {
        "type": "directional",
        "direction": (direction / norm(direction)).tolist(),
        "irradiance": rgb((r, g, b)),
    }


def _background(scene: Scene) -> dict[str, Any]:
    if not any(scene.background):
        return {}
    return {"background": {"type": "constant", "radiance": rgb(scene.background)}}


def _shape(
    thing: Object, number: int, material: str, folder: Path, placement: Placement
) -> Description:
    bsdf = {"type": "ref", "id": material}
    if isinstance(thing, Sphere):
        return {
            "type": "sphere",
            "center": placement.points(thing.center).tolist(),
            "radius": placement.length(thing.radius),
            "bsdf": bsdf,
        }
    path = folder / f"{object_key(number)}.ply"
    write_ply(path, placement.points(thing.vertices), thing.faces, number)
    return {"type": "ply", "filename": str(path), "face_normals": True, "bsdf": bsdf}
