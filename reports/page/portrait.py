"""minirt's own picture of a scene, small enough to head its section of the page."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from minirt import load_scene
from minirt.frame import Frame
from minirt.render import render
from minirt.scene import Scene
from reports.page.pictures import Span, shrink_factor, shrunk, value_png

#: Largest sides, in pixels.
LARGEST = (256, 192)


@dataclass(frozen=True)
class Portrait:
    """The colours that minirt gives a scene.

    Attributes
    ----------
    png : bytes
    width, height : int
        In pixels.
    """

    png: bytes
    width: int
    height: int


def portrait_of(scene: Scene) -> Portrait:
    """Render a scene's colours, in fewer pixels on the same screen where it has many."""
    screen = scene.screen
    scale = min(1.0, LARGEST[0] / screen.nx, LARGEST[1] / screen.ny)
    nx, ny = (max(1, round(side * scale)) for side in (screen.nx, screen.ny))
    document = scene.to_dict()
    document["screen"] |= {"nx": nx, "ny": ny}
    return _painted(render(load_scene(document, scene.folder), quantities="color"))


def portrayed(frame: Frame) -> Portrait:
    """A frame's colours, every k-th pixel where it has many. A `Portray`."""
    ny, nx = frame.size
    return _painted(Frame({"color": shrunk(frame["color"], shrink_factor(nx, ny, LARGEST))}))


def _painted(frame: Frame) -> Portrait:
    ny, nx = frame.size
    return Portrait(value_png("color", frame["color"], Span(np.zeros(3), np.ones(3))), nx, ny)
