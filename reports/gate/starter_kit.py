"""`minirt gate --init`: what the author of another tracer needs to begin, in one folder."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path

from converters.atomic import atomic_folder
from converters.frames.io import write_frame
from converters.scene_folder import write_scene_folder
from minirt import load_scene
from minirt.errors import InputError
from minirt.render import render
from minirt.scene_file.schema import scene_schema

#: From the first ray to a mesh, a mirror and glass: scenes that are passed one after the other.
SCENES = ("one-sphere", "fan-of-triangles", "glass-ball")
#: The kit's beginnings of a tracer, by language.
STUBS = {"cpp": "stub.cpp", "javascript": "stub.mjs", "python": "stub.py"}


def write_kit(folder: Path, language: str) -> list[Path]:
    """Write the schema, three scenes with their expected values, the protocol and a stub.

    Parameters
    ----------
    folder : Path
        New, or empty.
    language : str
        One of `STUBS`.

    Returns
    -------
    list of Path
        The files, relative to the folder.

    Raises
    ------
    InputError
        The folder holds something already, or cannot be written.
    """
    if folder.is_dir() and any(folder.iterdir()):
        raise InputError(
            "the folder is not empty", where=str(folder), expected="a new name, or an empty folder"
        )
    kit = resources.files("reports.gate").joinpath("kit")
    with atomic_folder(folder) as staging:
        for name in ("README.md", STUBS[language]):
            (staging / name).write_bytes(kit.joinpath(name).read_bytes())
        schema = json.dumps(scene_schema(), indent=1, ensure_ascii=False)
        (staging / "scene.schema.json").write_text(schema + "\n", encoding="utf-8")
        (staging / "expected").mkdir()
        for name in SCENES:
            scene = load_scene(f"atlas:{name}")
            write_scene_folder(scene, staging / "scenes" / name)
            write_frame(render(scene), staging / "expected" / f"{name}.npz")
        return sorted(p.relative_to(staging) for p in staging.rglob("*") if p.is_file())
