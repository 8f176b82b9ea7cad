"""A scene for pyrender: in the observer's coordinates, facing it, between fitted planes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from converters import pyrender as converter
from converters.pyrender import COARSEST, FINEST, PyrenderScene
from minirt.rules import SLIDES
from minirt.scene import Scene
from minirt.vectors import column, cross, dot
from minirt.whitted import primary_directions

SCREEN: dict[str, Any] = {
    "P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
    "l": -0.5, "r": 0.5, "b": -0.375, "t": 0.375, "nx": 64, "ny": 48,
}  # fmt: skip
#: A turned frame of determinant −1, ν > 0, off-axis, pixels twice as wide as high.
LEFT = SCREEN | {
    "u": [-0.8, 0, 0.6], "n": [-0.6, 0, -0.8], "nu": 2.0, "P0": [3, 0, 4],
    "l": -0.3, "r": 0.7, "b": -0.5, "t": 0.1, "nx": 40, "ny": 48,
}  # fmt: skip


def scene(*objects: dict[str, Any], screen: dict[str, Any] = SCREEN) -> Scene:
    return minirt.load_scene(
        {
            "minirt": 1, "name": "test", "screen": screen, "light": {"direction": [-1, -2, -3]},
            "materials": {"red": {}}, "objects": [o | {"material": "red"} for o in objects],
        },
        Path(),
    )  # fmt: skip


def ball(*center: float, radius: float = 1.0) -> dict[str, Any]:
    return {"type": "sphere", "center": list(center), "radius": radius}


def facet(*vertices: list[float]) -> dict[str, Any]:
    kind = "triangle" if len(vertices) == 3 else "polygon"
    return {"type": kind, "vertices": list(vertices)}


FLOOR = facet([-4, -1, 9], [4, -1, 9], [4, -1, -4], [-4, -1, -4])


def moved(whole: Scene, scale: float, shift: float) -> Scene:
    """The scene larger, and elsewhere."""

    def place(point: list[float]) -> list[float]:
        return [scale * value + shift for value in point]

    document = whole.to_dict()
    screen = document["screen"]
    screen |= {"P0": place(screen["P0"])} | {k: scale * screen[k] for k in ("nu", *"lrbt")}
    for thing in document["objects"]:
        if thing["type"] == "sphere":
            thing |= {"center": place(thing["center"]), "radius": scale * thing["radius"]}
        else:
            thing["vertices"] = [place(p) for p in thing["vertices"]]
    return minirt.load_scene(document)


@pytest.mark.parametrize("screen", [SCREEN, LEFT], ids=["right-handed", "left-handed"])
def test_camera_puts_every_ray_at_the_centre_of_its_pixel(screen: dict[str, Any]) -> None:
    """OpenGL's own projection, x = cx − fx·X/Z from the left, y = cy + fy·Y/Z from the top."""
    whole = PyrenderScene(scene(ball(0, 0, 0), screen=screen))
    view = whole.scene.screen
    d = primary_directions(whole.scene, SLIDES, np.arange(view.nx * view.ny))
    x, y, z = whole.points((column(view.P0) + 3 * d).T).T
    camera = whole.camera
    row, col = np.divmod(np.arange(view.nx * view.ny), view.nx)
    assert (z < 0).all()
    np.testing.assert_allclose(camera.cx - camera.fx * x / z, col + 0.5, rtol=0, atol=1e-11)
    np.testing.assert_allclose(camera.cy + camera.fy * y / z, row + 0.5, rtol=0, atol=1e-11)
    np.testing.assert_allclose(-z / whole.scale, 3 * abs(view.nu), rtol=1e-14)


@pytest.mark.parametrize("screen", [SCREEN, LEFT], ids=["right-handed", "left-handed"])
def test_every_face_with_an_area_faces_the_observer(screen: dict[str, Any]) -> None:
    a, b, c = [-1.0, -1.0, 0.0], [1.0, -1.0, 0.3], [0.0, 1.0, -0.2]
    inside = ball(*screen["P0"], radius=30.0)
    whole = PyrenderScene(
        scene(facet(a, b, c), facet(a, c, b), facet(a, a, b), ball(0, 0, 0), inside, screen=screen)
    )
    assert [part.object for part in whole.parts] == [0, 1, 3, 4]
    for part in whole.parts:
        p, q, r = (part.vertices[part.faces[:, k]].T for k in range(3))
        assert (dot(p, cross(q - p, r - p)) < 0).all()
        assert len(part.faces) == 1 or part.object > 2
    assert np.array_equal(whole.parts[0].vertices[0], whole.parts[1].vertices[0])


@pytest.mark.parametrize(
    ("whole", "tight"),
    [
        (scene(ball(0, 0, 0), FLOOR), 0.95),  # the floor passes below the observer
        (scene(ball(0, 0, 5, radius=2.0)), 0.5),  # from inside; large faces are cut by the view
        (scene(ball(0, 0, 0), screen=LEFT), 0.9),
        (scene(FLOOR, ball(0, 0, 9), facet([0, 0, 6], [9, 0, 7], [0, 9, 8])), 0.95),  # behind
        (scene(facet([-9, -9, 0], [9, -9, 2], [0, 9, -3]), ball(8, 0, 4.9)), 0.95),  # and aside
    ],
)
def test_clipping_planes_enclose_the_visible_faces_tightly(whole: Scene, tight: float) -> None:
    view = PyrenderScene(whole)
    depth = minirt.render(whole, quantities=["depth"])["depth"]
    seen = view.scale * depth[np.isfinite(depth)]
    assert seen.size > 100
    near, far = view.camera.znear, view.camera.zfar
    assert tight * seen.min() < near < seen.min() * (1 - 2.0**-12)
    assert seen.max() * (1 + 2.0**-12) < far < 4 * seen.max()


def test_a_scene_out_of_view_has_default_clipping_planes() -> None:
    for objects in ([], [ball(0, 0, 9)], [ball(90, 0, 0)]):
        camera = PyrenderScene(scene(*objects)).camera
        assert (camera.znear, camera.zfar) == (1, 2)


def test_spheres_are_as_fine_as_stated_in_pixels() -> None:
    whole = PyrenderScene(scene(ball(0, 0, 0), ball(0, 0, 4.5, radius=0.1), ball(0, 0, -99)))
    errors = [error / (whole.pixel * distance) for error, distance in whole.chord_errors()]
    assert len(errors) == 3
    assert all(0.5 * FINEST < error <= FINEST for error in errors)
    triangles = [len(whole.icospheres[k].faces) for k in range(3)]
    assert triangles[2] < triangles[0] / 10


def test_a_budget_makes_spheres_coarser_and_the_error_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    crowd = [ball(x, y, 0, radius=0.1) for x in range(-5, 5) for y in range(-5, 5)]
    monkeypatch.setattr(converter, "TRIANGLE_BUDGET", 20_000)
    whole = PyrenderScene(scene(*crowd))
    errors = [error / (whole.pixel * distance) for error, distance in whole.chord_errors()]
    assert FINEST < max(errors) < COARSEST
    assert sum(len(b.faces) for b in whole.icospheres.values()) < 1.6 * 20_000  # cuts are whole
    near = PyrenderScene(scene(ball(0, 0, 5, radius=1 - 1e-9)))
    monkeypatch.setattr(converter, "MAX_PER_SPHERE", 2000)
    ((error, distance),) = near.chord_errors()
    assert len(near.icospheres[0].faces) == 2000
    assert error > 1e-3 * distance


def test_place_and_size_of_a_scene_change_no_digit_beyond_their_own_rounding() -> None:
    whole = scene(ball(0, 0, 0), FLOOR, screen=LEFT)
    usual = PyrenderScene(whole)
    for scale, shift in ((2.0**-10, 0.0), (1024.0, 2.0**20)):
        other = PyrenderScene(moved(whole, scale, shift))
        assert other.scale == usual.scale / scale
        for mine, theirs in zip(usual.parts, other.parts, strict=True):
            rounding = 2.0**-52 * abs(shift) / scale * usual.scale
            np.testing.assert_allclose(
                theirs.vertices, mine.vertices, rtol=1e-12, atol=4 * rounding + 1e-13
            )


def test_nothing_of_pyrender_is_imported() -> None:
    assert PyrenderScene(scene(ball(0, 0, 0))).parts
    assert "pyrender" not in sys.modules
