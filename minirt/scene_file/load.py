"""Loading a scene: its text is read, decoded, validated, and resolved to the slides' form."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from minirt.errors import SceneError
from minirt.scene import Object, Scene, bounding_box
from minirt.scene_file.objects import resolve_objects
from minirt.scene_file.schema import SMALLEST, SceneDocument, ScreenModel
from minirt.scene_file.screen import resolve_screen
from minirt.scene_file.text import decode, read_text
from minirt.scene_file.validation import first_error
from minirt.screen import VirtualScreen
from minirt.vectors import norm


def load_scene(source: str | Path | dict[str, Any], folder: str | Path | None = None) -> Scene:
    """Load, check and resolve a scene.

    Parameters
    ----------
    source : path, ``-`` for standard input, ``atlas:NAME``, or a dict of the JSON
    folder : path, optional
        Where meshes are looked up; the scene file's own folder, or the working folder.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        One error that names the file, the JSON path, what is wrong and what would be right.

    Examples
    --------
    >>> load_scene("atlas:one-sphere").objects[0].radius
    1.0
    """
    if isinstance(source, dict):
        label, base = "scene", Path()
        try:
            text = json.dumps(source)
        except (TypeError, ValueError, RecursionError) as error:
            raise SceneError("the scene is not JSON data", where=label, got=str(error)) from None
    else:
        label, base, text = read_text(str(source))
    return _resolve(_validate(decode(text, label), label), label, Path(folder or base))


def _validate(document: Any, label: str) -> SceneDocument:
    try:
        return SceneDocument.model_validate(document)
    except ValidationError as error:
        raise first_error(error, label) from None


def _resolve(document: SceneDocument, label: str, folder: Path) -> Scene:
    screen = resolve_screen(document.screen, f"{label}: screen")
    _require_nonzero(document.light.direction, f"{label}: light.direction", "the light's direction")
    objects = resolve_objects(document, label, folder)
    extent = _extent(screen, objects)
    return Scene(
        name=document.name,
        about=document.about,
        proves=document.proves,
        failure_means=document.failure_means,
        rules=tuple(document.rules),
        floor=(document.floor.certain, document.floor.why) if document.floor else None,
        screen=screen,
        light_direction=document.light.direction,
        light_color=document.light.color,
        background=document.background,
        shadow_color=document.shadow_color,
        epsilon=1e-6 * extent if document.epsilon is None else document.epsilon,
        max_depth=document.max_depth,
        materials=dict(document.materials),
        objects=objects,
        extent=extent,
        document=_resolved_document(document, screen, objects),
        folder=folder,
    )


def _resolved_document(
    document: SceneDocument, screen: VirtualScreen, objects: tuple[Object, ...]
) -> dict[str, Any]:
    """The scene as JSON data: the slides' screen, every default filled in, every object named."""
    resolved = document.model_dump(mode="json", exclude={"screen"})
    resolved["screen"] = ScreenModel(**vars(screen)).model_dump(mode="json")
    for entry, thing in zip(resolved["objects"], objects, strict=True):
        entry["name"] = thing.name
    return resolved


def _require_nonzero(vector: tuple[float, float, float], where: str, what: str) -> None:
    if max(map(abs, vector)) < SMALLEST:
        raise SceneError(
            f"{what} is the zero vector", where=where, got=str(list(vector)), expected="any other"
        )


def _extent(screen: VirtualScreen, objects: tuple[Object, ...]) -> float:
    """The largest distance among P0 and the corners of the objects' bounding box."""
    box = bounding_box(objects)
    if box is None:
        return abs(screen.nu)
    corners = np.stack(np.meshgrid(*box.T, indexing="ij")).reshape(3, -1)
    diagonal = float(norm(box[1] - box[0]))
    reach = float(norm(corners - np.array(screen.P0).reshape(3, 1)).max())
    return max(diagonal, reach)
