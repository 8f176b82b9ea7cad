"""Small pictures that head a scene's section of the page: minirt's colours, and who agrees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from minirt import load_scene
from minirt.frame import Frame
from minirt.render import render
from minirt.scene import Scene
from minirt.vectors import Bools
from reports.page.pictures import Span, agreement_png, shrink_factor, shrunk, value_png

#: Largest sides, in pixels: of a scene's picture, and of a map or a passing quantity's pictures.
LARGE, SMALL = (256, 192), (128, 96)


@dataclass(frozen=True)
class Thumbnail:
    """A PNG file, and its sides in pixels."""

    png: bytes
    width: int
    height: int


def scene_thumbnail(scene: Scene) -> Thumbnail:
    """Render a scene's colours, in fewer pixels on the same screen where it has many."""
    screen = scene.screen
    scale = min(1.0, LARGE[0] / screen.nx, LARGE[1] / screen.ny)
    nx, ny = (max(1, round(side * scale)) for side in (screen.nx, screen.ny))
    document = scene.to_dict()
    document["screen"] |= {"nx": nx, "ny": ny}
    return _colors(render(load_scene(document, scene.folder), quantities="color"))


def frame_thumbnail(frame: Frame) -> Thumbnail:
    """A frame's colours, every k-th pixel where it has many. A `MakeThumbnail`."""
    ny, nx = frame.size
    return _colors(Frame({"color": shrunk(frame["color"], shrink_factor(nx, ny, LARGE))}))


def agreement_thumbnail(agree: NDArray[np.int64], differ: Bools) -> Thumbnail:
    """How many references confirm each pixel of a quantity, and where one differs. A `Draw`."""
    ny, nx = agree.shape
    factor = shrink_factor(nx, ny, SMALL)
    return Thumbnail(agreement_png(agree, differ, factor), -(-nx // factor), -(-ny // factor))


def _colors(frame: Frame) -> Thumbnail:
    ny, nx = frame.size
    return Thumbnail(value_png("color", frame["color"], Span(np.zeros(3), np.ones(3))), nx, ny)
