"""References that end in every way a reference can end. Child processes import them."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import minirt
from minirt.frame import Array, Frame
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene
from minirt.vectors import Bools, Floats
from reference.source import Declared, Rendering, Unsupported

#: Hostile text: markup for a page, a table, a terminal and an XML file.
HOSTILE = "<img src=x onerror=alert(1)> | *b* [red]r[/red] \x1b[31m \x00 ]]> ${7*7} {{7*7}} `c`"

NX, NY = 48, 36


def small_scene(name: str = "ball", **changes: object) -> Scene:
    """A ball of glass on a quad that carries its shadow, 48 × 36 pixels."""
    gray = {"ambient": [0.1, 0.1, 0.1], "diffuse": [0.7, 0.7, 0.7]}
    glass = {**gray, "transmittance": 0.8, "ior": 1.5}
    quad = [[-4, -1, 4], [4, -1, 4], [4, -1, -4], [-4, -1, -4]]
    return minirt.load_scene(
        {
            "minirt": 1,
            "name": name,
            "about": "a ball on a quad",
            "proves": "that reports are right",
            "failure_means": "that they are not",
            "rules": ["S8", "S11", "S12", "S16"],
            "floor": {"certain": 0.9, "why": "so few pixels are mostly edges"},
            "screen": {
                "look_at": {"eye": [0, 1, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y": 40},
                "nx": NX,
                "ny": NY,
            },
            "light": {"direction": [-1, -2, -1]},
            "materials": {"gray": gray, "glass": glass},
            "objects": [
                {"type": "sphere", "name": "ball", "material": "glass", "center": [0, 0, 0],
                 "radius": 1},
                {"type": "polygon", "name": "floor", "material": "gray", "vertices": quad},
            ],
            **changes,
        }
    )  # fmt: skip


@dataclass(frozen=True)
class Honest:
    """minirt itself, under given rules; the error that it declares is far above float64's."""

    name: str = "honest"

    def missing(self) -> str | None:
        return None

    def declare(self, scene: Scene) -> Declared:
        delta = 2.0**-44 * scene.extent
        return Declared(delta, 0.0, 2.0**-44, 2.0**-44, None, "256 roundings of 2⁻⁵²")

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        return Rendering(self.changed(scene, self.rendered(scene)), {}, f"minirt as {self.name}")

    def rendered(self, scene: Scene) -> dict[str, Array]:
        return dict(minirt.render(scene, rules=self.rules()).arrays)

    def rules(self) -> Rules:
        return SLIDES

    def changed(self, scene: Scene, arrays: dict[str, Array]) -> Frame:
        return Frame(arrays)


@dataclass(frozen=True)
class Undeclared(Honest):
    """Answers, and then cannot say how it errs: minirt cannot judge."""

    def declare(self, scene: Scene) -> Declared:
        raise ValueError("no error is known")


def culls_small_t(t: Floats, t0: Floats, t1: Floats) -> Bools:
    """A rule S6 that overlooks near hits of shadow rays."""
    return (t >= t0) & (t <= t1) & (t > 1.5) & np.isfinite(t)


@dataclass(frozen=True)
class Faulty(Honest):
    """Its shadow rays are blind for what is near: a fault in a rule, with consequences."""

    name: str = "faulty"

    def rules(self) -> Rules:
        return SLIDES.replace(in_interval=culls_small_t)


@dataclass(frozen=True)
class Coarse(Honest):
    """Right, and declares an error of a pixel or more: too little of its image is certain."""

    name: str = "coarse"

    def declare(self, scene: Scene) -> Declared:
        return replace(super().declare(scene), delta=0.002 * scene.extent)


@dataclass(frozen=True)
class InsideOut(Honest):
    """Its spheres have their normals inside; all of them, or the named one."""

    name: str = "inside-out"
    only: str = ""

    def changed(self, scene: Scene, arrays: dict[str, Array]) -> Frame:
        for k, thing in enumerate(scene.objects):
            if thing.type == "sphere" and self.only in ("", thing.name):
                arrays["normal"][arrays["object"] == k] *= -1
        return Frame(arrays)


@dataclass(frozen=True)
class Transparent(Honest):
    """The named object casts no shadow on the others."""

    name: str = "transparent"
    only: str = ""

    def changed(self, scene: Scene, arrays: dict[str, Array]) -> Frame:
        document = scene.to_dict()
        others = [entry for entry in document["objects"] if entry["name"] != self.only]
        alone = minirt.load_scene(document | {"objects": others}, folder=scene.folder)
        lit = minirt.render(alone)["shadow"] == 0
        names = np.array([thing.name for thing in scene.objects] + [""])
        elsewhere = names[arrays["object"]] != self.only
        arrays["shadow"][(arrays["shadow"] == 1) & lit & elsewhere] = 0
        return Frame(arrays)


@dataclass(frozen=True)
class OnePixel(Honest):
    """Right but for one pixel of the shadow mask, and of the depth at another."""

    name: str = "one-pixel"
    shadow: tuple[int, int] = (30, 10)
    depth: tuple[int, int] = (31, 20)

    def changed(self, scene: Scene, arrays: dict[str, Array]) -> Frame:
        arrays["shadow"][self.shadow] = 1 - arrays["shadow"][self.shadow]
        arrays["depth"][self.depth] *= 1.001
        return Frame(arrays)


@dataclass(frozen=True)
class Partial(Honest):
    """Gives hit and t only, and says of color why not."""

    name: str = "partial"

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        arrays = self.rendered(scene)
        given = {name: arrays[name] for name in ("hit", "t")}
        return Rendering(Frame(given), {"color": "it is colour-blind"}, "partial 1.0")


@dataclass(frozen=True)
class Silent(Honest):
    """Answers with an empty frame."""

    name: str = "silent"

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        return Rendering(Frame({}), {}, "silent 1.0")


@dataclass(frozen=True)
class WrongSize(Honest):
    """An image half as wide as asked for."""

    name: str = "wrong-size"

    def changed(self, scene: Scene, arrays: dict[str, Array]) -> Frame:
        return Frame({"depth": np.ascontiguousarray(arrays["depth"][:, ::2])})


@dataclass(frozen=True)
class CannotSay(Honest):
    """Cannot represent any scene."""

    name: str = "cannot"

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        raise Unsupported(f"its pixels are round {HOSTILE}")


@dataclass(frozen=True)
class Missing(Honest):
    """Is not installed."""

    name: str = "missing"

    def missing(self) -> str | None:
        return "not installed: pip install <nothing>"


@dataclass(frozen=True)
class Raising(Honest):
    """Fails with an exception of Python's."""

    name: str = "raising"

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        raise ZeroDivisionError("the light is off")


@dataclass(frozen=True)
class Aborting(Honest):
    """Dies as a C library does, on one scene or on all."""

    name: str = "aborting"
    on: str = ""

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        if self.on in ("", scene.name):
            os.write(2, f"LLVM ERROR: cannot select {HOSTILE}\n".encode())
            os.abort()
        return super().render(scene, scratch)


@dataclass(frozen=True)
class Hanging(Honest):
    """Never answers."""

    name: str = "hanging"

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        os.write(1, b"loading the kernel\n")
        time.sleep(600)
        raise AssertionError("slept through the time limit")
