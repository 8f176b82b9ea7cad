"""Which scenes a command is about: those named, else the whole atlas."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from minirt.scene import Scene


def scene_names(named: Sequence[str] | None) -> list[str]:
    """The scenes as they were named; without any those of the atlas."""
    from minirt.scene import atlas_names

    return list(named or [f"atlas:{name}" for name in atlas_names()])


def chosen_scenes(named: Sequence[str] | None) -> list[Scene]:
    """Those scenes, loaded.

    Raises
    ------
    InputError or SceneError
    """
    from minirt.scene import load_scene

    return [load_scene(name) for name in scene_names(named)]


def distinct_scenes(named: Sequence[str] | None) -> list[Scene]:
    """The same, where frames and records go by a scene's name.

    Raises
    ------
    InputError
        Two scenes of one name.
    """
    from minirt.errors import InputError

    scenes = chosen_scenes(named)
    names = [scene.name for scene in scenes]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise InputError("two scenes have the same name", got=", ".join(sorted(twice))[:200])
    return scenes
