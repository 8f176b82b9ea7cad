"""A scene as Wavefront OBJ: ``scene.obj`` with ``scene.mtl``, for any program that reads triangles.

Every coordinate keeps all its digits; triangles, polygons and meshes are unchanged, degenerate
faces included. A sphere is a polyhedron within 0.2 % of its radius (`converters.tessellate`), or as
near as `TRIANGLE_BUDGET` allows where there are many; it has a smoothing group. Materials keep
Phong's numbers, whose names MTL shares: Ka, Kd, Ks, Ns. `illum` says whether the material is a
mirror or glass; of k_r and k_t only k_t is written: ``d`` is 1 − 0.8·k_t, so that clear glass stays
visible.

OBJ has no camera and no light. Both are comments in the first lines, as JSON of the scene file, so
that nothing is lost.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

from converters.atomic import atomic_folder, require_replaceable
from converters.tessellate import TRIANGLES, icosphere_within
from minirt.scene import Material, Object, Scene, Sphere
from minirt.vectors import Floats, Ints

#: Largest distance of a sphere's triangles from it, over its radius.
CHORD_ERROR = 2e-3
#: Most triangles of all spheres together, by which `CHORD_ERROR` grows where there are many.
TRIANGLE_BUDGET = 500_000
#: The files of an export.
EXPORTED = ("scene.obj", "scene.mtl")


def export_obj(scene: Scene, folder: Path) -> None:
    """Write ``scene.obj`` and ``scene.mtl``; the folder appears whole or not at all.

    An earlier export in its place is replaced.

    Raises
    ------
    InputError
        The folder holds other files or cannot be written.
    """
    require_replaceable(folder, EXPORTED)
    with atomic_folder(folder) as staging:
        with (staging / "scene.obj").open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(_obj_lines(scene))
        text = "".join(map(_material, _material_names(scene).values(), scene.materials.values()))
        (staging / "scene.mtl").write_text(text, encoding="utf-8", newline="\n")


def _obj_lines(scene: Scene) -> Iterator[str]:
    materials = _material_names(scene)
    yield f"# minirt: {json.dumps(scene.name)}\n"
    yield f"# screen {json.dumps(asdict(scene.screen))}\n"
    light = {"direction": scene.light_direction, "color": scene.light_color}
    yield f"# light {json.dumps(light)}\n"
    yield "mtllib scene.mtl\n"
    bound = _chord_error(scene)
    first = 1
    for number, thing in enumerate(scene.objects):
        vertices, faces = _triangles(thing, bound)
        yield f"o {_word(number, thing.name)}\nusemtl {materials[thing.material]}\n"
        yield f"s {number + 1 if isinstance(thing, Sphere) else 'off'}\n"
        yield from (f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist())
        yield from (f"f {a} {b} {c}\n" for a, b, c in (faces + first).tolist())
        first += len(vertices)


def _chord_error(scene: Scene) -> float:
    spheres = sum(isinstance(thing, Sphere) for thing in scene.objects)
    return max(CHORD_ERROR, spheres * TRIANGLES / TRIANGLE_BUDGET)


def _triangles(thing: Object, bound: float) -> tuple[Floats, Ints]:
    if not isinstance(thing, Sphere):
        return thing.vertices, thing.faces
    icosphere = icosphere_within(bound)
    return icosphere.around(thing.center, thing.radius), icosphere.faces


def _material_names(scene: Scene) -> dict[str, str]:
    return {name: _word(number, name) for number, name in enumerate(scene.materials)}


def _word(number: int, name: str) -> str:
    """A unique name without spaces: the number, then the letters and digits of the name."""
    return f"{number}_{re.sub('[^0-9A-Za-z]+', '_', name)[:100]}"


def _material(name: str, material: Material) -> str:
    passing = material.transmittance
    lines = [
        f"newmtl {name}",
        "Ka " + _rgb(material.ambient),
        "Kd " + _rgb(material.diffuse),
        "Ks " + _rgb(material.specular),
        f"Ns {min(material.shininess, 1000)}",
        f"illum {6 if passing else 3 if material.reflectance else 2}",
    ]
    if material.ior is not None:
        lines.append(f"Ni {material.ior!r}")
    return "\n".join([*lines, f"d {1 - 0.8 * passing!r}", "", ""])


def _rgb(color: tuple[float, float, float]) -> str:
    return " ".join(map(repr, color))
