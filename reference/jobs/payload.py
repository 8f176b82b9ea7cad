"""Serialise jobs and answers for machines without our disk: scenes carry their mesh files."""

from __future__ import annotations

import io
import pickle
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

from converters.scene_folder import mesh_names
from minirt.errors import InputError
from minirt.scene import Scene


def to_payload(thing: object) -> bytes:
    """Serialise anything picklable, with the mesh files of every scene in it.

    Raises
    ------
    InputError
        A mesh file has gone since its scene was loaded.
    """
    stream = io.BytesIO()
    _Pickler(stream, pickle.HIGHEST_PROTOCOL).dump(thing)
    return stream.getvalue()


def from_payload(payload: bytes, folder: Path) -> Any:
    """Load a payload that comes from a trusted sender.

    Parameters
    ----------
    payload : bytes
    folder : Path
        An empty folder for the mesh files; its scenes need it as long as they are in use.
    """
    return _Unpickler(io.BytesIO(payload), folder).load()


class _Pickler(pickle.Pickler):
    def persistent_id(self, thing: object) -> tuple[bytes, dict[str, bytes]] | None:
        """A scene with the files of its meshes, in place of itself."""
        if not isinstance(thing, Scene) or not (names := mesh_names(thing)):
            return None
        return pickle.dumps(thing, pickle.HIGHEST_PROTOCOL), _files(thing, names)


class _Unpickler(pickle.Unpickler):
    def __init__(self, stream: io.BytesIO, folder: Path) -> None:
        super().__init__(stream)
        self._folder, self._numbers = folder, count()

    def persistent_load(self, found: tuple[bytes, dict[str, bytes]]) -> Scene:
        """A scene whose folder is here."""
        scene, files = found
        folder = self._folder / f"scene-{next(self._numbers)}"
        for name, content in files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        loaded: Scene = pickle.loads(scene)  # noqa: S301 - from the same trusted sender
        return replace(loaded, folder=folder)


def _files(scene: Scene, names: list[str]) -> dict[str, bytes]:
    try:
        return {name: (scene.folder / name).read_bytes() for name in names}
    except OSError as error:
        raise InputError(
            "a mesh file cannot be read", where=str(error.filename)[:200],
            got=error.strerror or str(error),
        ) from None  # fmt: skip
