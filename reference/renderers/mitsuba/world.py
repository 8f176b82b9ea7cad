"""Load a scene into Mitsuba, and run a function over all pixels of its image."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from converters.mitsuba.scene import scene_to_dict
from converters.placement import Placement
from minirt.scene import Scene
from minirt.vectors import Floats
from reference.renderers.mitsuba.llvm import VARIABLE, find_llvm
from reference.renderers.mitsuba.trace import World


def start(variant: str) -> tuple[Any, Any]:
    """Import Mitsuba and drjit with a variant set. An abort in here cannot be caught.

    drjit loads its LLVM library once, together with Mitsuba's first variant, whichever that is. An
    unsuitable library would remain when the same process starts a vectorised variant later.
    """
    library = find_llvm()
    if library is not None:
        os.environ[VARIABLE] = str(library)
    mi, dr = importlib.import_module("mitsuba"), importlib.import_module("drjit")
    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Error)
    return mi, dr


def load_world(mi: Any, dr: Any, scene: Scene, folder: Path, placement: Placement) -> World:
    """Load a scene; its meshes are written to `folder` on the way."""
    description = scene_to_dict(scene, folder, placement)
    sensor = description["sensor"]
    sensor["to_world"] = mi.ScalarTransform4d(sensor["to_world"])
    loaded = mi.load_dict(description, optimize=False)
    direction = np.array(description["light"]["direction"])
    return World(
        mi=mi,
        dr=dr,
        scene=loaded,
        sensor=loaded.sensors()[0],
        to_light=_opaque_vector(mi, dr, (-direction).tolist()),
        mirror=mi.load_dict(
            {"type": "twosided", "bsdf": {"type": "conductor", "material": "none"}}
        ),
        glasses=_glasses(mi, dr, scene),
    )


def run(world: World, function: Callable[..., list[Any]], inputs: Sequence[Floats]) -> Floats:
    """Call a function of `reference.renderers.mitsuba.trace` for every column of its inputs.

    Parameters
    ----------
    function
        Takes (world, *inputs), each one number (or array) per row of `inputs`.
    inputs : sequence of (n,) float64

    Returns
    -------
    (columns, n) float64
    """
    if not world.dr.is_jit_v(world.mi.Float):
        rows = [function(world, *map(float, column)) for column in zip(*inputs, strict=True)]
        return np.array(rows, dtype=np.float64).T
    answers = function(world, *(world.mi.Float(row.astype(np.float32)) for row in inputs))
    world.dr.eval(answers)
    width = len(inputs[0])
    return np.stack([np.broadcast_to(np.asarray(a).astype(np.float64), width) for a in answers])


def _opaque_vector(mi: Any, dr: Any, values: list[float]) -> Any:
    """A vector that is a kernel's data, not of its code: other values need no compilation."""
    if not dr.is_jit_v(mi.Float):
        return mi.Vector3f(values)
    return mi.Vector3f(*(dr.opaque(mi.Float, value) for value in values))


def _glasses(mi: Any, dr: Any, scene: Scene) -> list[tuple[Any, Callable[[Any, Any], Any]]]:
    """A smooth dielectric for each index of refraction, and which objects have it."""
    indices = [scene.materials[thing.material].ior for thing in scene.objects]
    glasses = []
    for ior in sorted({index for index in indices if index is not None}):
        glass = mi.load_dict({"type": "dielectric", "int_ior": ior, "ext_ior": 1.0})
        glasses.append((glass, _membership(mi, dr, [index == ior for index in indices])))
    return glasses


def _membership(mi: Any, dr: Any, members: list[bool]) -> Callable[[Any, Any], Any]:
    """``uses(object, active)`` for numbers or arrays of objects."""
    if not dr.is_jit_v(mi.Float):
        return lambda number, active: active and members[number]
    table = mi.UInt32(np.array(members, dtype=np.uint32))
    return lambda number, active: dr.gather(mi.UInt32, table, number, active) == 1
