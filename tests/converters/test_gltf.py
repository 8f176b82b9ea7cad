"""glTF and OBJ: what goes out comes back through trimesh, and minirt sees the same in it."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import minirt
from converters.gltf.materials import material_to_gltf
from converters.gltf.scene import CHORD_ERROR, export_gltf, gltf_bytes
from converters.obj import export_obj
from minirt import load_scene
from minirt.errors import InputError
from minirt.rules import SLIDES
from minirt.scene import Facets, Scene, Sphere
from minirt.scene_file.atlas import atlas_names
from minirt.screen import VirtualScreen
from minirt.vectors import Floats, unit
from minirt.whitted import primary_directions

#: Scenes with every kind of object; left-handed, off-axis; far from the origin; without objects.
NAMES = [
    "everything", "left-handed-frame", "off-axis-screen", "ball-on-quad-far-away", "closed-mesh",
    "ball-on-quad-millimetres", "degenerate-triangles",
]  # fmt: skip
U32 = 2.0**-24


def atlas(name: str) -> Scene:
    return load_scene(f"atlas:{name}")


def empty() -> Scene:
    document = atlas("one-sphere").to_dict()
    document["objects"] = []
    return load_scene(document)


def document_of(data: bytes) -> dict[str, Any]:
    """The JSON of a .glb file, its frame checked."""
    magic, version, length, size, kind = struct.unpack("<4sIII4s", data[:20])
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
    assert size % 4 == 0
    document: dict[str, Any] = json.loads(data[20 : 20 + size])
    return document


def pieces(loaded: trimesh.Scene, scene: Scene) -> list[trimesh.Trimesh]:
    """The objects' meshes in modelling coordinates, by their nodes' names, in the scene's order."""
    found = []
    for thing in scene.objects:
        matrix, geometry = loaded.graph[thing.name]
        found.append(loaded.geometry[geometry].copy().apply_transform(matrix))
    return found


def fits(mesh: trimesh.Trimesh, thing: Facets | Sphere, rounding: float) -> bool:
    """Whether it is the object's own triangles, or some around its sphere as near as stated."""
    if isinstance(thing, Facets):
        own = thing.vertices[thing.faces]
        return bool(
            mesh.triangles.shape == own.shape and np.abs(mesh.triangles - own).max() <= rounding
        )
    points = np.concatenate([mesh.triangles_center, mesh.triangles.reshape(-1, 3)])
    off = np.abs(np.linalg.norm(points - thing.center, axis=1) - thing.radius).max()
    volume = 4 / 3 * np.pi * thing.radius**3  # all around, and turned outward
    near = off <= CHORD_ERROR * thing.radius + rounding
    return bool(near and abs(mesh.volume / volume - 1) < 3 * CHORD_ERROR)


def size_of(scene: Scene) -> float:
    """Its largest coordinate."""
    assert scene.bounds is not None
    return float(np.abs(scene.bounds).max())


@pytest.mark.parametrize("name", NAMES)
def test_gltf_comes_back_through_trimesh(name: str, tmp_path: Path) -> None:
    scene = atlas(name)
    export_gltf(scene, tmp_path / "scene.glb")
    loaded = trimesh.load_scene(tmp_path / "scene.glb", process=False)
    # the file's vertices are float32 about the scene's middle; trimesh's matrices float64
    rounding = 4 * U32 * scene.extent + 2.0**-50 * size_of(scene)
    meshes = pieces(loaded, scene)
    assert len(meshes) > 2
    assert [m for m, o in zip(meshes, scene.objects, strict=True) if not fits(m, o, rounding)] == []


@pytest.mark.parametrize("name", NAMES)
def test_obj_comes_back_through_trimesh(name: str, tmp_path: Path) -> None:
    """Which sorts objects by their materials, so each is looked for among all."""
    scene = atlas(name)
    export_obj(scene, tmp_path / "out")
    loaded = trimesh.load_scene(
        tmp_path / "out" / "scene.obj", process=False, split_object=True, group_material=False
    )
    meshes = list(loaded.geometry.values())
    assert len(meshes) == len(scene.objects)
    for thing in scene.objects:
        rounding = 0.0 if isinstance(thing, Facets) else 2.0**-50 * size_of(scene)
        assert sum(fits(mesh, thing, rounding) for mesh in meshes) == 1, thing.name


def test_minirt_renders_its_own_obj_alike(tmp_path: Path) -> None:
    """The export as one mesh of a scene: every pixel that is not at a sphere's edge."""
    scene = atlas("everything")
    export_obj(scene, tmp_path / "out")
    document = scene.to_dict()
    material = next(iter(document["materials"]))
    document["objects"] = [{"type": "mesh", "material": material, "file": "scene.obj"}]
    ours = minirt.render(scene, quantities=["hit", "depth"])
    theirs = minirt.render(load_scene(document, tmp_path / "out"), quantities=["hit", "depth"])
    assert (ours["hit"] != theirs["hit"]).mean() < 0.002
    both = ours["hit"] & theirs["hit"]
    assert both.sum() > 10_000
    off = np.abs(ours["depth"][both] - theirs["depth"][both])
    assert np.quantile(off, 0.97) < 4 * CHORD_ERROR  # radii up to 2, seen up to 60° aside
    assert (off == 0).sum() > 1000  # the triangles that are the scene's own


def test_obj_keeps_screen_light_and_materials(tmp_path: Path) -> None:
    scene = atlas("everything")
    export_obj(scene, tmp_path / "out")
    lines = (tmp_path / "out" / "scene.obj").read_text(encoding="utf-8").splitlines()
    assert json.loads(lines[1].removeprefix("# screen ")) == scene.to_dict()["screen"]
    assert json.loads(lines[2].removeprefix("# light ")) == scene.to_dict()["light"]
    text = (tmp_path / "out" / "scene.mtl").read_text(encoding="utf-8")
    assert text.count("newmtl ") == len(scene.materials)
    used = {line.split()[1] for line in lines if line.startswith("usemtl")}
    assert used <= {line.split()[1] for line in text.splitlines() if line.startswith("newmtl")}
    for material in scene.materials.values():
        assert "Kd " + " ".join(map(repr, material.diffuse)) in text


def camera_of(document: dict[str, Any]) -> tuple[Floats, float, float]:
    (node,) = (node for node in document["nodes"] if "camera" in node)
    perspective = document["cameras"][node["camera"]]["perspective"]
    height = np.tan(perspective["yfov"] / 2)
    return np.reshape(node["matrix"], (4, 4)).T, height * perspective["aspectRatio"], height


def is_centred(screen: VirtualScreen) -> bool:
    return screen.l == -screen.r and screen.b == -screen.t


@pytest.mark.parametrize("name", [n for n in atlas_names() if is_centred(atlas(n).screen)])
def test_a_centred_screen_is_the_camera_exactly(name: str) -> None:
    """Directions through its pixels by glTF's own rule, (x·w, y·h, −1) in the camera's frame; of
    a mirrored picture, the mirror image."""
    scene = atlas(name)
    screen = scene.screen
    matrix, width, height = camera_of(document_of(gltf_bytes(scene)))
    d = unit(primary_directions(scene, SLIDES, np.arange(screen.nx * screen.ny)))
    frame = np.array([screen.u, screen.v, screen.n])
    mirrored = np.linalg.det(frame) * screen.nu > 0
    assert mirrored == (name == "positive-nu")
    row, column = np.divmod(np.arange(screen.nx * screen.ny), screen.nx)
    x = ((column + 0.5) / screen.nx * 2 - 1) * width * (-1 if mirrored else 1)
    y = (1 - (row + 0.5) / screen.ny * 2) * height
    theirs = unit(matrix[:3, :3] @ np.stack((x, y, -np.ones_like(x))))
    np.testing.assert_allclose(theirs, d, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(matrix[:3, 3], screen.P0)


def test_most_screens_are_centred() -> None:
    assert sum(is_centred(atlas(name).screen) for name in atlas_names()) > 20


@pytest.mark.parametrize("name", atlas_names())
def test_every_screen_is_within_its_camera(name: str) -> None:
    scene = atlas(name)
    screen = scene.screen
    document = document_of(gltf_bytes(scene))
    matrix, width, height = camera_of(document)
    assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1)
    corners = np.array(
        [(u, v, screen.nu) for u in (screen.l, screen.r) for v in (screen.b, screen.t)]
    )
    d = np.array([screen.u, screen.v, screen.n]).T @ corners.T
    x, y, z = matrix[:3, :3].T @ d
    assert (z < 0).all()
    assert np.abs(x / z).max() == pytest.approx(width)
    assert np.abs(y / z).max() == pytest.approx(height)
    assert document["cameras"][0]["extras"]["screen"] == scene.to_dict()["screen"]


def test_the_light_shines_along_its_nodes_axis() -> None:
    scene = atlas("everything")
    document = document_of(gltf_bytes(scene))
    (node,) = (node for node in document["nodes"] if node["name"] == "light")
    towards = -np.reshape(node["matrix"], (4, 4)).T[:3, 2]
    np.testing.assert_allclose(towards, unit(np.array(scene.light_direction)), atol=1e-15)
    (light,) = document["extensions"]["KHR_lights_punctual"]["lights"]
    lit = np.array(light["color"]) * light["intensity"] / np.pi
    np.testing.assert_allclose(lit, scene.light_color, rtol=1e-15)


def test_materials_stay_within_what_gltf_allows() -> None:
    names = set()
    for name in atlas_names():
        scene = atlas(name)
        document = document_of(gltf_bytes(scene))
        for key, material in scene.materials.items():
            described = material_to_gltf(key, material)
            surface = described["pbrMetallicRoughness"]
            numbers = [*surface["baseColorFactor"], surface["metallicFactor"]]
            numbers += [surface["roughnessFactor"], *described["emissiveFactor"]]
            assert all(0 <= number <= 1 for number in numbers)
            names |= set(described.get("extensions", ()))
            assert set(described.get("extensions", ())) <= set(document["extensionsUsed"])
    assert names == {"KHR_materials_ior", "KHR_materials_transmission"}


def test_spheres_of_a_material_share_their_triangles() -> None:
    data = gltf_bytes(atlas("thousand-spheres"))
    assert len(data) < 300_000
    assert len(document_of(data)["nodes"]) > 1000


def test_a_scene_without_objects_is_a_camera_and_a_light(tmp_path: Path) -> None:
    data = gltf_bytes(empty())
    document = document_of(data)
    assert "meshes" not in document
    assert "buffers" not in document
    assert not any("children" in node for node in document["nodes"])
    loaded = trimesh.load_scene(io.BytesIO(data), file_type="glb")
    assert len(loaded.geometry) == 0
    export_obj(empty(), tmp_path / "out")
    assert "\nv " not in (tmp_path / "out" / "scene.obj").read_text(encoding="utf-8")


def test_exports_are_atomic_and_replace_only_exports(tmp_path: Path) -> None:
    scene = atlas("one-sphere")
    with pytest.raises(InputError, match=r"NAME\.glb"):
        export_gltf(scene, tmp_path / "scene.gltf")
    with pytest.raises(InputError, match="cannot be written"):
        export_gltf(scene, tmp_path / "missing" / "scene.glb")
    assert list(tmp_path.iterdir()) == []
    folder = tmp_path / "out"
    export_obj(scene, folder)
    export_obj(scene, folder)
    (folder / "thesis.tex").write_text("")
    with pytest.raises(InputError, match=r"thesis\.tex"):
        export_obj(scene, folder)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out"]
    assert gltf_bytes(scene) == gltf_bytes(atlas("one-sphere"))
