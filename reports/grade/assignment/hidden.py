"""Hidden scenes: seeded variants of public ones, that an answer to the public one fails.

The window of the virtual screen moves, the light turns, the materials change, and the objects
stand in another order: nothing that the rules treat differently, and every quantity changes.
"""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from minirt import load_scene
from minirt.scene import Scene

#: How far the window moves, as a share of its side, and the light, as a share of its length.
_WINDOW, _LIGHT = (0.03, 0.12), 0.08


def variant(scene: Scene, seed: int, number: int) -> Scene:
    """Variant `number` of a scene; the same for the same seed, under the same name."""
    digest = hashlib.sha256(f"{seed} {number} {scene.sha256}".encode()).digest()
    random = np.random.default_rng(np.frombuffer(digest, dtype=np.uint32))
    document = scene.to_dict()
    _move_window(document["screen"], random)
    _turn_light(document["light"], random)
    for material in document["materials"].values():
        _recolor(material, random)
    order = random.permutation(len(document["objects"]))
    if len(order) > 1 and (order == np.arange(len(order))).all():
        order = np.roll(order, 1)
    document["objects"] = [document["objects"][k] for k in order]
    document["epsilon"] = scene.epsilon
    return load_scene(document, scene.folder)


def _move_window(screen: dict[str, Any], random: np.random.Generator) -> None:
    for low, high in (("l", "r"), ("b", "t")):
        side = screen[high] - screen[low]
        step = float(side * random.uniform(*_WINDOW) * random.choice([-1, 1]))
        screen[low], screen[high] = screen[low] + step, screen[high] + step


def _turn_light(light: dict[str, Any], random: np.random.Generator) -> None:
    direction = np.array(light["direction"])
    length = float(np.abs(direction).max())
    light["direction"] = (direction + random.uniform(-_LIGHT, _LIGHT, 3) * length).tolist()


def _recolor(material: dict[str, Any], random: np.random.Generator) -> None:
    for name in ("ambient", "diffuse", "specular"):
        color = np.array(material[name])
        material[name] = (color * random.uniform(0.6, 0.95, 3)).tolist()
