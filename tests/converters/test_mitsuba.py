"""Scenes in Mitsuba's language. Mitsuba itself runs in child processes only."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

import minirt
from converters.frames.images import open_image
from converters.mitsuba.materials import is_exact, material_to_dict
from converters.mitsuba.ply import write_ply
from converters.mitsuba.scene import export_mitsuba, object_key, scene_to_dict, unsupported_camera
from converters.placement import COMFORTABLE, IDENTITY, Placement, fitted_placement, reach
from minirt.errors import InputError
from minirt.scene import Material, Scene
from minirt.vectors import Floats
from reference.jobs.isolate import Workers
from reference.renderers.mitsuba.cli import find_command

SCREEN = {
    "P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
    "l": -0.5, "r": 0.5, "b": -0.375, "t": 0.375, "nx": 64, "ny": 48,
}  # fmt: skip
MATERIALS: dict[str, dict[str, Any]] = {
    "red": {"diffuse": [0.8, 0.1, 0.3]},
    "shiny": {"diffuse": [0.3, 0.3, 0.3], "specular": [0.5, 0.5, 0.5], "shininess": 32},
    "mirror": {"reflectance": 1.0},
    "half": {"reflectance": 0.5},
    "glass": {"ior": 1.5, "transmittance": 1.0},
    "frosted": {"ior": 1.3, "transmittance": 0.6, "reflectance": 0.4},
    "tinted": {"ior": 1.3, "transmittance": 0.5, "reflectance": 0.2, "specular": [1, 0, 0]},
}


def scene(objects: list[dict[str, Any]], folder: Path | None = None, **changes: Any) -> Scene:
    document = {
        "minirt": 1, "name": "test", "screen": SCREEN, "light": {"direction": [-1, -2, -3]},
        "materials": MATERIALS, "objects": objects,
    }  # fmt: skip
    return (
        minirt.load_scene(document | changes)
        if folder is None
        else minirt.load_scene(document | changes, folder)
    )


def ball(material: str = "red", center: tuple[float, ...] = (0, 0, 0)) -> dict[str, Any]:
    return {"type": "sphere", "material": material, "center": list(center), "radius": 1.0}


def many(number: int = 13) -> Scene:
    """Spheres and triangles in turn, two of them the very same, of every material."""
    names = list(MATERIALS)
    objects = [ball("red", (0.3, 0, 0)), ball("red", (0.3, 0, 0))]
    for k in range(number):
        corner = [k - 6.0, 1.0, 0.1]
        triangle = {
            "type": "triangle", "material": names[k % len(names)],
            "vertices": [corner, [k - 5.0, 1.0, 0.1], [k - 6.0, 2.0, 0.1]],
        }  # fmt: skip
        objects += [triangle, ball(names[k % len(names)], (k - 6.0, -2, 0.1))]
    return scene(objects, background=[0.1, 0.2, 0.3])


@pytest.fixture(scope="module")
def workers() -> Iterator[Workers]:
    with Workers(1) as pool:
        yield pool


def parameters(source: dict[str, Any] | str) -> dict[str, Any]:
    """Every parameter of a scene that Mitsuba loads, with the order of its shapes."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    if isinstance(source, dict):
        rows = source["sensor"]["to_world"]
        source["sensor"]["to_world"] = mi.ScalarTransform4d(rows)
    loaded = mi.load_dict(source) if isinstance(source, dict) else mi.load_file(source)
    values = {}
    for name, value in mi.traverse(loaded):
        matrix = getattr(value, "matrix", value)
        values[name] = np.array(matrix, dtype=np.float64).ravel().tolist()
    return values | {"shapes": [shape.id() for shape in loaded.shapes()]}


@pytest.mark.full
def test_the_xml_says_what_the_dict_says(workers: Workers, tmp_path: Path) -> None:
    whole, folder = many(), tmp_path / "export"
    export_mitsuba(whole, folder)
    described = scene_to_dict(whole, folder)
    outcomes = [
        workers.submit(60, parameters, source).outcome()
        for source in (described, str(folder / "scene.xml"))
    ]
    assert [outcome.state for outcome in outcomes] == ["done", "done"], outcomes
    from_dict, from_xml = (outcome.value for outcome in outcomes)
    assert from_dict == from_xml
    assert from_xml["shapes"] == [object_key(k) for k in range(len(whole.objects))]
    assert len(from_xml) > 5 * len(whole.objects)


def test_an_export_contains_no_absolute_path(tmp_path: Path) -> None:
    export_mitsuba(many(), tmp_path / "export")
    text = (tmp_path / "export" / "scene.xml").read_text(encoding="utf-8")
    assert str(tmp_path) not in text
    files = [
        e.get("value", "")
        for e in ElementTree.fromstring(text).iter()  # noqa: S314 - our own text
        if e.get("name") == "filename"
    ]
    assert len(files) == 13
    assert all((tmp_path / "export" / file).is_file() for file in files)


def test_an_export_replaces_an_earlier_one_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "export"
    export_mitsuba(many(), folder)
    export_mitsuba(scene([ball()]), folder)
    assert [path.name for path in folder.iterdir()] == ["scene.xml"]
    (folder / "thesis.tex").write_text("")
    with pytest.raises(InputError, match=r"thesis\.tex"):
        export_mitsuba(scene([ball()]), folder)
    assert len(list(tmp_path.iterdir())) == 1


def rendered(whole: Scene, folder: Path) -> dict[str, Floats]:
    """The channels that Mitsuba's own command gives of an export."""
    export_mitsuba(whole, folder / "export")
    image = folder / "out.exr"
    source = folder / "export" / "scene.xml"
    command = [str(find_command()), "-m", "scalar_rgb", str(source), "-o", str(image)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "WARN" not in done.stdout + done.stderr
    with open_image(image, (whole.screen.ny, whole.screen.nx)) as picture:
        blocks = [np.stack(planes) for _, planes in picture.blocks()]
        return dict(zip(picture.channels, np.concatenate(blocks, axis=1), strict=True))


def test_the_command_renders_every_material(tmp_path: Path) -> None:
    channels = rendered(many(), tmp_path)
    assert np.isfinite(channels["R"]).all()
    assert channels["A"].min() == 1  # the background is an emitter


def test_the_commands_picture_of_a_lit_ball_is_ours(tmp_path: Path) -> None:
    """A lone convex body has no light from a second bounce: direct light is all there is."""
    whole = scene([ball()], light={"direction": [-1, -2, -3], "color": [1, 0.5, 2]})
    channels, ours = rendered(whole, tmp_path), minirt.render(whole)
    theirs = np.stack([channels[c] for c in "RGB"], axis=-1)
    # the silhouette's and the terminator's pixels may fall to either side
    flat = np.abs(ours["color"] - theirs).max(axis=2) < 1e-5 * ours["color"].max()
    assert ours["hit"].sum() > 500
    assert ours["color"].max() > 0.5
    assert (~flat).sum() <= 2


def test_pixels_that_are_not_square_are_refused(tmp_path: Path) -> None:
    whole = scene([ball()], screen=SCREEN | {"ny": 50})
    assert unsupported_camera(whole.screen) is not None
    with pytest.raises(InputError, match="square pixels"):
        scene_to_dict(whole, tmp_path)
    assert unsupported_camera(scene([ball()]).screen) is None


@pytest.mark.parametrize(
    ("name", "kinds", "exact"),
    [
        ("red", ["twosided", "diffuse"], True),
        ("mirror", ["twosided", "conductor"], True),
        ("shiny", ["twosided", "roughplastic"], False),
        ("half", ["twosided", "blendbsdf", "diffuse", "conductor"], False),
        ("glass", ["dielectric"], False),
        ("frosted", ["blendbsdf", "twosided", "conductor", "dielectric"], False),
        ("tinted", ["blendbsdf", "twosided", "blendbsdf", "roughplastic", "conductor",
                    "dielectric"], False),
    ],
)  # fmt: skip
def test_materials_become_their_bsdfs(name: str, kinds: list[str], exact: bool) -> None:
    material = Material(**MATERIALS[name])
    assert list(plugins(material_to_dict(material))) == kinds
    assert is_exact(material) == exact


def plugins(description: dict[str, Any]) -> Iterator[str]:
    if description["type"] != "rgb":
        yield description["type"]
    for part in description.values():
        if isinstance(part, dict):
            yield from plugins(part)


def test_a_scene_of_medium_extent_is_not_moved() -> None:
    assert fitted_placement(many()) == IDENTITY


@pytest.mark.parametrize(("size", "shift"), [(1e-3, 0.0), (1e4, 0.0), (1.0, 1e5), (1e-20, 3.0)])
def test_a_small_large_or_far_scene_is_moved_and_scaled(size: float, shift: float) -> None:
    screen = SCREEN | {key: SCREEN[key] * size for key in ("nu", "l", "r", "b", "t")}  # type: ignore[operator]
    whole = scene(
        [ball() | {"center": [shift, 0, 0], "radius": size}],
        screen=screen | {"P0": [shift, 0, 5 * size]},
    )
    placement = fitted_placement(whole)
    assert np.frexp(placement.scale)[0] == 0.5  # a power of two
    assert 32 <= placement.length(whole.extent) < COMFORTABLE[1]
    assert reach(whole, placement) <= COMFORTABLE[1]
    point = np.array([shift + size, 0.5 * size, -size])
    np.testing.assert_allclose(placement.back(placement.points(point)), point, rtol=2.0**-50)


def test_a_placement_moves_every_length_and_no_direction(tmp_path: Path) -> None:
    whole, placement = many(), Placement(4.0, (1.0, 2.0, 3.0))
    here, there = scene_to_dict(whole, tmp_path), scene_to_dict(whole, tmp_path, placement)
    assert there["object_000000"]["radius"] == 4 * here["object_000000"]["radius"]
    assert there["object_000000"]["center"] == [4 * (0.3 - 1), -8.0, -12.0]
    first, second = (np.array(d["sensor"]["to_world"])[:3, :3] for d in (here, there))
    np.testing.assert_array_equal(first, second)
    assert there["light"] == here["light"]


def test_ply_keeps_faces_in_order_and_degenerate_ones(tmp_path: Path) -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1 / 3, 1, 0]])
    faces = np.array([[2, 1, 3], [0, 0, 0], [0, 1, 2]], dtype=np.int32)
    write_ply(tmp_path / "m.ply", vertices, faces, 7)
    mesh = trimesh.load(tmp_path / "m.ply", process=False)
    assert isinstance(mesh, trimesh.Trimesh)
    np.testing.assert_array_equal(mesh.faces, faces)
    np.testing.assert_array_equal(mesh.vertices, vertices.astype(np.float32))
