"""A scene as one glTF 2.0 file (.glb) that any viewer opens: triangles, camera, light.

What glTF cannot express is approximated:

- a sphere is a polyhedron within 0.2 % of its radius (`converters.tessellate`), its normals exact;
- a material is metallic-roughness: see `converters.gltf.materials`;
- glTF's camera is centred, has no pixels of its own and cannot be mirrored. Where the screen is
  off-axis the camera is the centred one that just contains it; where the picture is mirrored (u
  points to the left as the observer sees the screen, v upwards), the camera's is not. The
  screen itself is kept with the camera, under ``extras``;
- background, shadow colour, ε and max_depth are left out.

Vertices are float32. Where that would cost a scene its precision, they are stored relative to its
middle, and the root node moves them back: see `converters.placement`.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

from converters.atomic import atomic_file
from converters.gltf.glb import Buffer
from converters.gltf.materials import Description, material_to_gltf, used_extensions
from converters.gltf.view import camera, camera_node, light, light_node
from converters.placement import Placement, fitted_placement
from converters.tessellate import icosphere_within
from minirt.errors import InputError
from minirt.scene import Object, Scene, Sphere
from minirt.vectors import Floats, Ints

#: Largest distance of a sphere's triangles from it, over its radius.
CHORD_ERROR = 2e-3


def export_gltf(scene: Scene, path: str | Path) -> None:
    """Write a scene as one .glb file; atomic.

    Parameters
    ----------
    scene : Scene
    path : path
        ``NAME.glb``.

    Raises
    ------
    InputError
        Another suffix, or the path cannot be written.
    """
    if Path(path).suffix.lower() != ".glb":
        raise InputError("not a name for binary glTF", where=str(path), expected="NAME.glb")
    data = gltf_bytes(scene)
    with atomic_file(path) as temporary:
        temporary.write_bytes(data)


def gltf_bytes(scene: Scene) -> bytes:
    """The scene as the bytes of a .glb file."""
    buffer, placement = Buffer(), fitted_placement(scene)
    meshes = _Meshes(scene, buffer, placement)
    objects = [meshes.node(thing) for thing in scene.objects]
    materials = [material_to_gltf(name, m) for name, m in scene.materials.items()]
    count = len(objects)
    root = {
        "name": scene.name,
        "translation": list(placement.center),
        "scale": [1 / placement.scale] * 3,
        **({"children": list(range(count))} if count else {}),
    }
    document = {
        "asset": {"version": "2.0", "generator": "minirt"},
        "scene": 0,
        "scenes": [{"nodes": [count, count + 1, count + 2]}],
        "nodes": [*objects, root, camera_node(scene.screen), light_node(scene)],
        "meshes": meshes.found,
        "cameras": [camera(scene)],
        "materials": materials,
        "extensions": {"KHR_lights_punctual": {"lights": [light(scene.light_color)]}},
        "extensionsUsed": ["KHR_lights_punctual", *used_extensions(materials)],
    }
    return buffer.file(document)


class _Meshes:
    """The meshes of a file: one for each object of triangles, one for all spheres of a material.

    Attributes
    ----------
    found : list of dict
        In the order of their numbers.
    """

    def __init__(self, scene: Scene, buffer: Buffer, placement: Placement) -> None:
        self.found: list[Description] = []
        self._materials = {name: number for number, name in enumerate(scene.materials)}
        self._buffer, self._placement = buffer, placement
        self._sphere_meshes: dict[str, int] = {}

    def node(self, thing: Object) -> Description:
        """The object's node; its mesh is made where there is none yet."""
        if not isinstance(thing, Sphere):
            mesh = self._add(thing.material, self._triangles(thing.vertices, thing.faces))
            return {"name": thing.name, "mesh": mesh}
        if thing.material not in self._sphere_meshes:
            self._sphere_meshes[thing.material] = self._add(thing.material, self._sphere)
        radius = self._placement.length(thing.radius) * (1 + icosphere_within(CHORD_ERROR).error)
        return {
            "name": thing.name,
            "mesh": self._sphere_meshes[thing.material],
            "translation": self._placement.points(thing.center).tolist(),
            "scale": [radius] * 3,
        }

    def _triangles(self, vertices: Floats, faces: Ints) -> Description:
        points = self._buffer.add_points(self._placement.points(vertices))
        return {"attributes": {"POSITION": points}, "indices": self._buffer.add_faces(faces)}

    @cached_property
    def _sphere(self) -> Description:
        """The unit sphere: its points are its normals."""
        icosphere = icosphere_within(CHORD_ERROR)
        points = self._buffer.add_points(icosphere.vertices)
        attributes = {"POSITION": points, "NORMAL": points}
        return {"attributes": attributes, "indices": self._buffer.add_faces(icosphere.faces)}

    def _add(self, material: str, triangles: Description) -> int:
        self.found.append({"primitives": [triangles | {"material": self._materials[material]}]})
        return len(self.found) - 1
