"""Anything as bytes that mean the same on a machine without our disk: scenes take meshes along."""

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


def packed(thing: object) -> bytes:
    """A picklable thing as bytes, with the files of the meshes of every scene in it.

    Raises
    ------
    InputError
        A mesh file has gone since its scene was loaded.
    """
    stream = io.BytesIO()
    _Packer(stream, pickle.HIGHEST_PROTOCOL).dump(thing)
    return stream.getvalue()


def unpacked(parcel: bytes, room: Path) -> Any:
    """The thing again, from somebody who is trusted.

    Parameters
    ----------
    parcel : bytes
    room : Path
        An empty folder, where the meshes of its scenes are put; they need it as long as they live.
    """
    return _Unpacker(io.BytesIO(parcel), room).load()


class _Packer(pickle.Pickler):
    def persistent_id(self, thing: object) -> tuple[bytes, dict[str, bytes]] | None:
        """A scene with the files of its meshes, in place of itself."""
        if not isinstance(thing, Scene) or not (names := mesh_names(thing)):
            return None
        return pickle.dumps(thing, pickle.HIGHEST_PROTOCOL), _files(thing, names)


class _Unpacker(pickle.Unpickler):
    def __init__(self, stream: io.BytesIO, room: Path) -> None:
        super().__init__(stream)
        self._room, self._numbers = room, count()

    def persistent_load(self, found: tuple[bytes, dict[str, bytes]]) -> Scene:
        """A scene whose folder is here."""
        scene, files = found
        folder = self._room / f"scene-{next(self._numbers)}"
        for name, content in files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        loaded: Scene = pickle.loads(scene)  # noqa: S301 - as all of the parcel
        return replace(loaded, folder=folder)


def _files(scene: Scene, names: list[str]) -> dict[str, bytes]:
    try:
        return {name: (scene.folder / name).read_bytes() for name in names}
    except OSError as error:
        raise InputError(
            "a mesh file cannot be read", where=str(error.filename)[:200],
            got=error.strerror or str(error),
        ) from None  # fmt: skip
