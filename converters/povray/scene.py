"""A scene in POV-Ray 3.7's language: one text that renders alone, in the slides' own colours.

Nothing here starts POV-Ray. It is a Whitted tracer in double precision with analytic spheres, so
everything is exact up to rounding: the camera (`converters.povray.shapes`), the materials
(`converters.povray.materials`), the indices of refraction (`converters.povray.media`), and

- shadow (S12): a transparent object has `no_shadow`, and an opaque twin in the same place that
  only shadow rays hit, neither the camera's nor reflected or refracted ones;
- depth (S7): POV-Ray counts the primary ray, so its `max_trace_level` is max_depth + 1;
- no light but the scene's: `ambient` is 0 everywhere, a material's own radiance is `emission`.

What it cannot express is listed by `unsupported_colors`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from converters.atomic import atomic_file
from converters.placement import Placement
from converters.povray.materials import Color, material_texture, unsupported_material
from converters.povray.media import transparent_bodies
from converters.povray.shapes import (
    camera,
    clip_regions,
    comment,
    parallel_light,
    pieces,
    povray_placement,
    vector,
)
from minirt.scene import Scene

_HEADER = """// {name}
// {about}
// 1 scene unit is {scale!r} here, and the origin is the scene's {center}.
// povray +I{{this file}} +W{nx} +H{ny} -A File_Gamma=1.0"""


def povray_scene(scene: Scene, exposure: float = 1.0) -> str:
    """The scene as POV-Ray's text.

    Parameters
    ----------
    scene : Scene
    exposure : float
        Factor on the light and on emission: image files hold values up to 1.
    """
    placement = povray_placement(scene)
    light = tuple(exposure * channel for channel in scene.light_color)
    background = vector([exposure * channel for channel in scene.background])
    return "\n".join(
        [
            *preamble(scene, placement, scene.max_depth + 1),
            f"background {{ rgb {background} }}",
            parallel_light(scene, placement, light),
            *_materials(scene, exposure),
            *_opaque(scene, placement),
            *_transparent(scene, placement),
            "",
        ]
    )


def preamble(scene: Scene, placement: Placement, levels: int) -> list[str]:
    """The beginning of every text: settings without any light of POV-Ray's own, and the camera.

    `levels` counts generations of rays, the primary one included.
    """
    s = scene.screen
    header = _HEADER.format(
        name=_line(scene.name), about=_line(scene.about), scale=placement.scale,
        center=list(placement.center), nx=s.nx, ny=s.ny,
    )  # fmt: skip
    settings = f"assumed_gamma 1 max_trace_level {levels} adc_bailout 0"
    return [
        header,
        *(f"// not exact: {_line(reason)}" for reason in unsupported_colors(scene)),
        "#version 3.7;",
        f"global_settings {{ {settings} }}",
        "#default { finish { ambient 0 diffuse 0 } }",
        *clip_regions(scene, placement),
        camera(scene, placement),
    ]


def export_povray(scene: Scene, path: Path) -> None:
    """Write one ``.pov`` that renders alone; the file appears whole or not at all.

    Raises
    ------
    InputError
        It cannot be written.
    """
    with atomic_file(path) as staging:
        staging.write_text(povray_scene(scene), encoding="utf-8")


def unsupported_colors(scene: Scene) -> list[str]:
    """Why POV-Ray's colours cannot be the slides' in this scene; empty where they can."""
    used = dict.fromkeys(thing.material for thing in scene.objects)
    found = [
        (name, unsupported_material(scene.materials[name], scene.light_color, scene.shadow_color))
        for name in used
    ]
    return [f"material {name!r}: {reason}" for name, reason in found if reason]


def brightest(scene: Scene) -> float:
    """A bound on every channel of the scene's colours, which are convex combinations of these."""
    colors = [scene.background, scene.shadow_color or (0.0, 0.0, 0.0)]
    light = np.array(scene.light_color)
    for thing in scene.objects:
        m = scene.materials[thing.material]
        colors.append(m.ambient + light * (np.array(m.diffuse) + np.array(m.specular)))
    return float(np.max(colors))


def _line(text: str) -> str:
    """Any text as one line that a comment can hold."""
    return " ".join(text.split())[:300]


def _materials(scene: Scene, exposure: float) -> list[str]:
    """A declared texture for each material that is used, by its number."""
    used = {thing.material for thing in scene.objects}
    light: Color = scene.light_color
    return [
        f"#declare Material_{k} =\n  "
        + material_texture(material, light, scene.shadow_color, exposure)
        for k, (name, material) in enumerate(scene.materials.items())
        if name in used
    ]


def _opaque(scene: Scene, placement: Placement) -> list[str]:
    lines = []
    for number, thing in enumerate(scene.objects):
        if scene.material_of(number).transmittance == 0:
            lines += [comment(number, thing)]
            lines += pieces(scene, number, placement, _MaterialTexture(scene))
    return lines


def _transparent(scene: Scene, placement: Placement) -> list[str]:
    """Bodies, each a union whose parts inherit one interior, with their twins that cast shadows."""
    lines = []
    for body in transparent_bodies(scene):
        lines.append("union {")
        for number in body.objects:
            thing = scene.objects[number]
            lines += [comment(number, thing)]
            lines += pieces(scene, number, placement, _MaterialTexture(scene), "no_shadow")
        lines += [f"  interior {{ ior {body.index!r} }}", "}"]
        for number in body.objects:
            twin = pieces(scene, number, placement, _shadow_texture, "no_image no_reflection")
            lines += ["// its shadow", *twin]
    return lines


class _MaterialTexture:
    """The texture of every face of an object: its material's."""

    def __init__(self, scene: Scene) -> None:
        number = {name: k for k, name in enumerate(scene.materials)}
        self.numbers = [number[thing.material] for thing in scene.objects]

    def __call__(self, number: int, face: int) -> str:
        return f"texture {{ Material_{self.numbers[number]} }}"


def _shadow_texture(number: int, face: int) -> str:
    """The texture of an object that only casts shadows."""
    return "texture { pigment { rgb 0 } }"
