"""Scenes in POV-Ray's language: what the text says, and that the program draws it alone."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from converters.frames.images import open_image
from converters.povray.materials import material_texture, unsupported_material
from converters.povray.media import transparent_bodies
from converters.povray.scene import brightest, export_povray, povray_scene, unsupported_colors
from converters.povray.shapes import camera, povray_placement
from minirt import load_scene
from minirt.errors import InputError
from minirt.scene import Material, Scene
from minirt.screen import image_pixels, model_from_view, pixel_center, view_frame
from minirt.vectors import Floats, norm
from reference.renderers.povray.run import find_povray

SCREEN: dict[str, Any] = {
    "P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
    "l": -0.5, "r": 0.5, "b": -0.375, "t": 0.375, "nx": 64, "ny": 48,
}  # fmt: skip
MATERIALS: dict[str, dict[str, Any]] = {
    "red": {"diffuse": [0.8, 0.1, 0.3], "ambient": [0.1, 0, 0]},
    "glass": {"ior": 1.5, "transmittance": 0.9, "diffuse": [0.1, 0.2, 0.3]},
    "air": {"ior": 1 / 1.5, "transmittance": 0.9},
}
LIGHT = (0.9, 0.5, 2.0)
NUMBER = r"-?\d[\d.]*(?:e[-+]?\d+)?"


def scene(*objects: dict[str, Any], **changes: Any) -> Scene:
    document = {
        "minirt": 1, "name": "test", "screen": SCREEN, "light": {"direction": [-1, -2, -3]},
        "materials": MATERIALS, "objects": list(objects),
    }  # fmt: skip
    return load_scene(document | changes)


def ball(material: str = "red", radius: float = 1.0, center: Any = (0, 0, 0)) -> dict[str, Any]:
    return {"type": "sphere", "material": material, "center": list(center), "radius": radius}


def vectors(text: str) -> list[list[float]]:
    return [
        [float(number) for number in re.findall(NUMBER, found)]
        for found in re.findall(r"<([^<>]*)>", text)
    ]


# the camera, and where the scene stands


@pytest.mark.parametrize(
    "name",
    ["left-handed-frame", "negative-nu", "positive-nu", "non-square-pixels", "off-axis-screen",
     "ball-on-quad-millimetres", "ball-on-quad-ten-kilometres"],
)  # fmt: skip
def test_the_camera_draws_through_the_same_pixel_centres(name: str) -> None:
    loaded = load_scene(f"atlas:{name}")
    s = loaded.screen
    lines = camera(loaded, povray_placement(loaded)).splitlines()
    _, direction, right, up = (np.array(vectors(line)[0]) for line in lines[2:6])
    i, j = image_pixels(s, np.arange(s.nx * s.ny))
    x, y = (i + 0.5) / s.nx - 0.5, (j + 0.5) / s.ny - 0.5
    theirs = direction[:, None] + x * right[:, None] + y * up[:, None]
    ours = model_from_view(view_frame(s), *pixel_center(s, i, j))
    assert ours.shape == (3, s.nx * s.ny)
    # a dozen roundings of numbers up to the screen's largest coordinate, over ‖d‖ ≥ |ν|
    assert norm(theirs / norm(theirs) - ours / norm(ours)).max() < 16 * 2.0**-53 * 4


@pytest.mark.parametrize("size", [1e-6, 0.03, 1.0, 4e7])
@pytest.mark.parametrize("far", [0.0, 1e3])
def test_the_scene_is_scaled_so_that_absolute_tolerances_are_small(size: float, far: float) -> None:
    center = np.array([far, 0, 0]) * size
    document = SCREEN | {"P0": (center + np.array([0, 0, 5 * size])).tolist()}
    placement = povray_placement(
        loaded := scene(ball(radius=size, center=center.tolist()), screen=document)
    )
    assert 2048 <= placement.length(loaded.extent) < 4096
    assert np.log2(placement.scale) % 1 == 0
    assert np.abs(placement.points(center)).max() <= 2 * 4096
    assert np.abs(placement.back(placement.points(center)) - center).max() <= 2.0**-52 * far * size


def test_numbers_keep_every_digit() -> None:
    center, radius = [1 / 3, -2e-7, 0.1], 1 / 7
    loaded = scene(ball(radius=radius, center=center))
    scale = povray_placement(loaded).scale
    found = re.search(rf"sphere {{ (<[^>]*>), ({NUMBER}) texture", povray_scene(loaded))
    assert found is not None
    assert vectors(found[1])[0] == [scale * x for x in center]
    assert float(found[2]) == scale * radius


def test_triangles_are_reversed_and_degenerate_ones_are_left_out() -> None:
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    triangle = {"type": "triangle", "material": "red", "vertices": corners}
    flat = triangle | {"vertices": [[0, 0, 0], [1, 1, 1], [2, 2, 2]]}
    loaded = scene(triangle, flat)
    text = povray_scene(loaded)
    scale = povray_placement(loaded).scale
    found = re.findall(r"^ *triangle {([^{]*)texture", text, re.MULTILINE)
    assert [vectors(f) for f in found] == [[[scale * x for x in corners[k]] for k in (0, 2, 1)]]


def test_names_cannot_break_out_of_their_comments() -> None:
    name = "a\nlight_source { 0 }\r*/ ν \\"
    thing = ball() | {"name": name}
    text = povray_scene(scene(thing, name=name, about=name))
    assert text.count("light_source") == text.count("// a light_source") * 3 / 2 + 1
    assert not re.search(r"^light_source { 0 }", text, re.MULTILINE)
    assert max(map(len, text.splitlines())) < 400


# materials


def layered(text: str, cosine: float, highlight: float, lit: bool) -> tuple[Floats, Floats]:
    """Colour and transparency of a layered texture by the formula in the module's docstring."""
    color, F = np.zeros(3), np.ones(3)
    for layer in reversed(text.split("\n")):
        P = np.array(vectors(layer)[0])

        def number(key: str, text: str = layer) -> float:
            found = re.search(rf"\b{key} ({NUMBER})", text)
            return float(found[1]) if found else 0.0

        opacity = 1 - number("transmit") - number("filter")
        color = color + F * P * opacity * number("emission")
        if lit:
            shine = number("diffuse") * (1.0 if "brilliance 0" in layer else cosine)
            phong = number("phong") * highlight ** number("phong_size")
            color = color + F * np.array(LIGHT) * (P * opacity * shine + phong)
        F = F * (number("transmit") + number("filter") * P)
    return color, F


@pytest.mark.parametrize("seed", range(40))
def test_layers_add_up_to_the_illumination_model(seed: int) -> None:
    random = np.random.default_rng(seed)
    k_t = random.uniform(0.1, 0.9) if seed % 2 else 0.0
    grey = [float(random.uniform(0, 1))] * 3
    material = Material(
        ambient=tuple(random.uniform(0, 1, 3)),
        diffuse=tuple(random.uniform(0, 1, 3)),
        specular=tuple(grey if seed % 4 < 2 else random.uniform(0.1, 1, 3)),
        shininess=int(random.integers(1, 9)),
        reflectance=float(random.uniform(0, 1 - k_t)) if seed % 3 else 0.0,
        transmittance=k_t,
        ior=1.5,
    )
    shadow = tuple(random.uniform(0, 1, 3)) if seed % 5 < 2 else None
    assert unsupported_material(material, LIGHT, shadow) is None
    text = material_texture(material, LIGHT, shadow, 1.0)
    w, cosine, highlight = 1 - material.reflectance - k_t, 0.7, 0.9
    shine = np.array(material.diffuse) * cosine
    shine += np.array(material.specular) * highlight**material.shininess
    expected = {
        True: w * (np.array(material.ambient) + np.array(LIGHT) * shine),
        False: w * np.array(material.ambient if shadow is None else shadow),
    }
    passing = k_t / (material.reflectance + k_t) if k_t else 0.0
    for lit, local in expected.items():
        color, through = layered(text, cosine, highlight, lit)
        # some dozens of roundings of numbers around 1
        assert np.abs(color - local).max() < 100 * 2.0**-53
        assert np.abs(through - passing).max() < 100 * 2.0**-53
    assert f"reflection {{ {material.reflectance!r} }}" in text
    assert (f"refraction {material.reflectance + k_t!r}" in text) == (k_t > 0)


def test_materials_that_layers_cannot_express_are_reported() -> None:
    red = {"transmittance": 0.5, "ior": 1.5, "specular": [1.0, 0.0, 0.0]}
    tinted = Material.model_validate(red)
    assert "lacks a channel" in str(unsupported_material(tinted, LIGHT, None))
    faint = tinted.model_copy(update={"specular": (1e-51, 0.2, 0.3)})
    assert "lacks a channel" in str(unsupported_material(faint, LIGHT, None))
    assert (
        unsupported_material(faint.model_copy(update={"transmittance": 0.0}), LIGHT, None) is None
    )
    plain = Material.model_validate({"ambient": [0.1, 0.1, 0.1]})
    assert unsupported_material(plain, (1.0, 0.0, 1.0), None) is None
    assert unsupported_material(plain, (1.0, 0.0, 1.0), (0.2, 0.1, 0.0)) is None
    assert "without light" in str(unsupported_material(plain, (1.0, 0.0, 1.0), (0.1, 0.2, 0.1)))
    loaded = scene(ball("tinted"), materials={"tinted": red})
    assert [fault.split(":")[0] for fault in unsupported_colors(loaded)] == ["material 'tinted'"]
    assert "// not exact: material 'tinted'" in povray_scene(loaded)


def test_the_brightest_colour_bounds_every_pixel() -> None:
    loaded = load_scene("atlas:everything")
    assert minirt.render(loaded, quantities=["color"])["color"].max() <= brightest(loaded)


# media


def indices(*objects: dict[str, Any], P0: tuple[float, ...] = (0, 0, 5)) -> list[float]:
    bodies = transparent_bodies(scene(*objects, screen=SCREEN | {"P0": list(P0)}))
    return [round(body.index, 12) for body in bodies]


def test_indices_are_products_of_what_a_body_lies_in() -> None:
    assert indices(ball("glass"), ball("red", 9)) == [1.5]
    assert indices(ball("air", 0.5), ball("glass")) == [1.0, 1.5]
    assert indices(ball("glass", 0.2), ball("air", 0.5), ball("glass")) == [1.5, 1.0, 1.5]
    assert indices(ball("glass"), ball("air", 1, (3, 0, 0))) == [1.5, round(1 / 1.5, 12)]


def test_bodies_around_the_observer_have_inverse_indices() -> None:
    inner, outer = ball("air", 0.5), ball("glass")
    beside = ball("glass", 1, (4, 0, 0))
    assert indices(outer, beside, P0=(0.7, 0, 0)) == [round(1 / 1.5, 12), 1.0]
    # from within the bubble: glass is 1.5 times the air he is in, all else is as the air itself
    assert indices(inner, outer, beside, P0=(0, 0, 0)) == [1.5, 1.0, 1.5]


def test_facets_of_one_material_are_one_body() -> None:
    water = {"type": "polygon", "material": "glass"}
    top = water | {"vertices": [[-9, 1, 9], [9, 1, 9], [9, 1, -9], [-9, 1, -9]]}
    side = water | {"vertices": [[9, 1, 9], [9, -9, 9], [9, -9, -9], [9, 1, -9]]}
    assert indices(top, side, P0=(0, 5, 0)) == [1.5]
    assert indices(top, side, P0=(0, 0, 0)) == [round(1 / 1.5, 12)]


# the file


def test_the_export_renders_alone(tmp_path: Path) -> None:
    document = load_scene("atlas:glass-ball").to_dict()
    document["screen"] |= {"nx": 64, "ny": 48}
    loaded = load_scene(document)
    assert brightest(loaded) <= 1.5
    export_povray(loaded, tmp_path / "alone.pov")
    assert [path.name for path in tmp_path.iterdir()] == ["alone.pov"]
    switches = ["+FN16", "+W64", "+H48", "-A", "-D", "File_Gamma=1.0"]
    command = [str(find_povray()), "+Ialone.pov", "+Oalone.png", *switches]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True)
    assert done.returncode == 0, done.stderr[-1000:]
    with open_image(tmp_path / "alone.png", (48, 64)) as image:
        theirs = np.stack(next(image.blocks())[1][:3], axis=-1) / image.white
    ours = minirt.render(loaded, quantities=["color"])["color"].clip(0, 1)
    # half a code of 1/65535, and some float32 roundings; 1 pixel in 3,072 may hit an edge
    assert (np.abs(theirs - ours).max(axis=2) > 0.5 / 65535 + 1e-6).sum() <= 1


def test_the_command_line_prints_a_command_that_renders(tmp_path: Path) -> None:
    command = [str(Path(sys.executable).with_name("minirt")), "export", "atlas:one-sphere"]
    command += ["--to", "povray", "--out", "ball.pov"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    rendered = subprocess.run(shlex.split(done.stdout), cwd=tmp_path, capture_output=True)
    assert rendered.returncode == 0, rendered.stderr[-1000:]
    with open_image(tmp_path / "ball.png", (192, 256)) as image:
        assert image.channels[:3] == ("R", "G", "B")


def test_the_export_is_atomic(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match="folder"):
        export_povray(scene(ball()), tmp_path / "folder")
    with pytest.raises(InputError, match="no such folder"):
        export_povray(scene(ball()), tmp_path / "nowhere" / "a.pov")
    assert [path.name for path in tmp_path.rglob("*")] == ["folder"]
