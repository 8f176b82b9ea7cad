"""S7, S13: colours computed by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import minirt
from minirt.shading import integer_power

_PLAIN = {"ambient": [0.1, 0.2, 0.3], "diffuse": [0.5, 0.4, 0.2], "specular": [0.3, 0.3, 0.6],
          "shininess": 2}  # fmt: skip
_GREEN = {"ambient": [0, 0.6, 0], "diffuse": [0, 0, 0]}


def _exactly(expected: Any) -> Any:
    """Equal but for rounding: some 30 roundings by half an ulp of numbers up to 1."""
    return pytest.approx(expected, rel=1e-14, abs=1e-15)


def _floor(material: str, y: float = 0.0) -> dict[str, Any]:
    corners = [[-9, y, 9], [9, y, 9], [9, y, -9], [-9, y, -9]]
    return {"type": "polygon", "material": material, "vertices": corners}


def _ball(material: str, center: list[float], radius: float = 1.0) -> dict[str, Any]:
    return {"type": "sphere", "material": material, "center": center, "radius": radius}


def _scene(*objects: dict[str, Any], **more: Any) -> minirt.Scene:
    materials = {
        "plain": _PLAIN,
        "green": _GREEN,
        "mirror": {**_PLAIN, "reflectance": 0.25},
        "glass": {**_PLAIN, "reflectance": 0.125, "transmittance": 0.5, "ior": 1.5},
    }
    document = {
        "minirt": 1, "name": "colours",
        "screen": {"P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
                   "l": -1, "r": 1, "b": -1, "t": 1, "nx": 4, "ny": 4},
        "light": {"direction": [0, -5, 0], "color": [1, 0.5, 0.25]},
        "background": [0.2, 0.1, 0.4], "materials": materials, "objects": list(objects), **more,
    }  # fmt: skip
    return minirt.load_scene(document)


def _color(scene: minirt.Scene, P0: Any, d: Any) -> list[float]:
    return [float(c) for c in minirt.ray_color(scene, P0, d)]


def test_S13_a_lit_point_by_phongs_formula() -> None:
    """Floor y = 0 seen along δ = (0.6, −0.8, 0), light straight down: s = (0,1,0), L = (0,1,0).
    s·L = 1; ρ(−L) = (0,1,0); ρ·(−δ) = 0.8; 0.8² = 0.64. So by channel
    0.1 + 1·(0.5 + 0.3·0.64), 0.2 + 0.5·(0.4 + 0.3·0.64), 0.3 + 0.25·(0.2 + 0.6·0.64).
    """
    expected = [0.1 + 0.5 + 0.192, 0.2 + 0.5 * 0.592, 0.3 + 0.25 * 0.584]
    assert _color(_scene(_floor("plain")), [0, 1, 0], [3, -4, 0]) == _exactly(expected)


def test_S13_the_normal_is_turned_to_the_viewer() -> None:
    """From below, s = (0,−1,0): the light is behind the surface, and so is the floor: shadow."""
    scene = _scene(_floor("plain"))
    assert _color(scene, [0, -1, 0], [0, 1, 0]) == _exactly(_PLAIN["ambient"])
    # Light from below as well: lit by the same formula, head on: 0.5 + 0.3 and so on.
    below = _scene(_floor("plain"), light={"direction": [0, 2, 0]})
    expected = [0.1 + 0.8, 0.2 + 0.7, 0.3 + 0.8]
    assert _color(below, [0, -1, 0], [0, 1, 0]) == _exactly(expected)


def test_S13_no_highlight_where_the_light_does_not_face_the_surface() -> None:
    """A ball lit from behind: ρ(−L) at the point seen is along L mirrored, towards the viewer."""
    scene = _scene(_ball("plain", [0, 0, 0]), light={"direction": [0, 0, 1]})
    assert _color(scene, [0.0, 0, 5], [0, 0, -1]) == _exactly(_PLAIN["ambient"])


def test_S13_in_shadow_ambient_alone_or_the_scenes_colour() -> None:
    objects = _floor("plain"), _ball("plain", [0, 3, 0])
    assert _color(_scene(*objects), [0, 1, 5], [0, -1, -5]) == pytest.approx([0.1, 0.2, 0.3])
    colored = _scene(*objects, shadow_color=[0.7, 0.0, 0.1])
    assert _color(colored, [0, 1, 5], [0, -1, -5]) == _exactly([0.7, 0.0, 0.1])


def test_S7_nothing_met_is_the_background() -> None:
    assert _color(_scene(_floor("plain")), [0, 1, 0], [0, 1, 0]) == [0.2, 0.1, 0.4]
    assert _color(_scene(), [0, 1, 0], [0, 1, 0]) == [0.2, 0.1, 0.4]


def test_S7_a_mirror_adds_its_share_of_what_it_meets() -> None:
    """Floor, straight down, under a green ceiling that shades it: local is ambient;
    0.75·(0.1, 0.2, 0.3) + 0.25·(0, 0.6, 0). The ceiling, met from below, has ambient alone.
    """
    scene = _scene(_floor("mirror"), _floor("green", 4.0))
    expected = [0.075, 0.15 + 0.15, 0.225]
    assert _color(scene, [0, 1, 0], [0, -1, 0]) == _exactly(expected)


def test_S7_glass_adds_what_is_behind_it() -> None:
    """A ball of glass over a green floor, light from below: the floor shades the ball, whose local
    colours are ambient. Straight down nothing bends.
    Top: 0.375·local + 0.125·background + 0.5·C(ϱ);
    bottom, from inside: C(ϱ) = 0.375·local + 0.125·C(up) + 0.5·C(floor);
    the floor, met from the side that is not lit: (0, 0.6, 0).
    With max_depth 2, C(up) is the inner top's 0.375·local.
    """
    scene = _scene(
        _ball("glass", [0, 3, 0]), _floor("green"), light={"direction": [0, 1, 0]}, max_depth=2
    )
    local = np.array([0.1, 0.2, 0.3])
    green, sky = np.array([0, 0.6, 0]), np.array([0.2, 0.1, 0.4])
    bottom = 0.375 * local + 0.125 * (0.375 * local) + 0.5 * green
    expected = 0.375 * local + 0.125 * sky + 0.5 * bottom
    assert _color(scene, [0, 9, 0], [0, -1, 0]) == _exactly(expected.tolist())


def test_S7_at_total_reflection_the_transmitted_share_is_mirrored() -> None:
    """Inside a ball of glass at 60° to its surface: 1.5 · sin 60° > 1, and so at every later
    bounce, whose angle is the same. Under a ceiling all is in shadow, (0.1, 0.2, 0.3): each
    generation keeps 0.375 of it and mirrors 0.125 + 0.5. With max_depth 2, that makes
    0.375·(1 + 0.625 + 0.625²).
    """
    ball, ceiling = _ball("glass", [0, 0, 0]), _floor("plain", 5.0)
    scene = _scene(ball, ceiling, max_depth=2, shadow_color=[0.1, 0.2, 0.3])
    share = 0.375 * (1 + 0.625 + 0.625**2)
    expected = [share * 0.1, share * 0.2, share * 0.3]
    d = [-np.sin(np.pi / 3), 0, -np.cos(np.pi / 3)]
    assert _color(scene, [0, 0, 1], d) == _exactly(expected)


def test_S7_beyond_max_depth_rays_bring_black() -> None:
    """Two mirrors face to face under a roof: local colours in shadow, weighed by powers of 0.25."""
    between = _floor("mirror"), _floor("mirror", 4.0), _floor("green", 6.0)
    for depth in range(4):
        scene = _scene(*between, max_depth=depth, shadow_color=[0.4, 0.4, 0.4])
        share = 0.75 * sum(0.25**k for k in range(depth + 1))
        expected = [0.4 * share] * 3
        assert _color(scene, [0, 1, 0], [0, -1, 0]) == _exactly(expected)


def test_S7_ray_color_is_the_pictures() -> None:
    scene = _scene(_ball("glass", [0, 0, 0]), _ball("mirror", [1, 1, -1]), _floor("plain", -1.0))
    frame = minirt.render(scene)
    d = frame["ray"].reshape(-1, 3).T
    colors = minirt.ray_color(scene, [0, 0, 5], d)
    assert colors.shape == (3, 16)
    # The picture's d is not normalised; unit ones give points that differ by an ulp or two of 6.
    assert colors.T.reshape(4, 4, 3) == pytest.approx(frame["color"], abs=1e-12)


@pytest.mark.parametrize("exponent", [1, 2, 3, 7, 37, 64, 1000])
def test_S13_integer_power(exponent: int) -> None:
    base = np.linspace(0, 1, 101)
    # Each squaring doubles a relative error and adds one: exponent roundings in all.
    expected = np.array([float(b) ** exponent for b in base])
    power = integer_power(base, np.full(101, exponent, dtype=np.int32))
    assert power == pytest.approx(expected, rel=exponent * 2.0**-52)
