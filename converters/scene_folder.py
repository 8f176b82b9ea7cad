"""A scene with its mesh files in one folder, for a program that does not know the atlas."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

from minirt.errors import InputError
from minirt.scene import Scene

#: The scene's own file in such a folder.
SCENE_FILE = "scene.json"


def plain_document(scene: Scene) -> dict[str, Any]:
    """The JSON of a scene with nothing left to derive: the slides' screen, ε as a number."""
    return scene.to_dict() | {"epsilon": scene.epsilon}


def mesh_names(scene: Scene) -> list[str]:
    """The files that a scene's meshes are read from, relative to its folder, each once."""
    names = [entry["file"] for entry in scene.document["objects"] if entry["type"] == "mesh"]
    return list(dict.fromkeys(names))


def write_scene_folder(scene: Scene, folder: Path) -> Path:
    """Write ``scene.json`` and, under their own names, the mesh files that it names.

    Parameters
    ----------
    scene : Scene
    folder : Path
        Empty, or not there yet.

    Returns
    -------
    Path
        Of ``scene.json``.

    Raises
    ------
    InputError
        A mesh file was deleted since the scene was loaded, or cannot be copied.
    """
    document = plain_document(scene)
    folder.mkdir(parents=True, exist_ok=True)
    for name in mesh_names(scene):
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            shutil.copyfile(scene.folder / name, target)
        except OSError as error:
            raise InputError(
                "a mesh file cannot be copied", where=name[:200], got=error.strerror or str(error)
            ) from None
    path = folder / SCENE_FILE
    path.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return path
