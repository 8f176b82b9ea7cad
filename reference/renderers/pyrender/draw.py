"""Build a scene in pyrender, draw it in one pass and read its buffers back."""

from __future__ import annotations

import gc
import importlib
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from converters.pyrender import PyrenderScene
from minirt.errors import ReferenceError
from minirt.screen import VirtualScreen
from minirt.vectors import Floats, Ints
from reference.source import Unsupported

#: What installs OpenGL without a window, in software where there is no graphics card.
PACKAGES = "apt-get install libegl1 libgl1-mesa-dri"
#: Bits of a pixel by which vertices are placed, at least: Mesa's and graphics cards' number.
SUBPIXEL_BITS = 8
#: Objects that three bytes of colour tell apart, beside the background's black.
MOST_OBJECTS = 2**24 - 1


def start() -> Any:
    """Import pyrender with OpenGL by EGL, which needs no window; the choice is the process's."""
    os.environ["PYOPENGL_PLATFORM"] = "egl"
    return importlib.import_module("pyrender")


def draw(whole: PyrenderScene) -> tuple[Ints, Floats, str]:
    """Object (−1: none) and depth in scene units of every pixel, and the driver's name.

    `RenderFlags.SEG` is the pass without multisampling: it is drawn at the pixels' centres.

    Returns
    -------
    object : (ny, nx) int32
    depth : (ny, nx) float64
        0 where there is no object.
    driver : str

    Raises
    ------
    ReferenceError
        OpenGL does not start.
    Unsupported
        It places vertices more coarsely than is declared.
    """
    pyrender, gl = start(), importlib.import_module("OpenGL.GL")
    world, colors = build(pyrender, whole)
    renderer = window(pyrender, whole.scene.screen)
    try:
        if gl.glGetIntegerv(gl.GL_SUBPIXEL_BITS) < SUBPIXEL_BITS:
            raise Unsupported(f"this OpenGL places vertices by less than {SUBPIXEL_BITS} bits")
        color, depth = renderer.render(world, pyrender.RenderFlags.SEG, colors)
        driver = gl.glGetString(gl.GL_RENDERER).decode()
    finally:
        _close(renderer)
    return object_numbers(color), depth.astype(np.float64) / whole.scale, driver


def window(pyrender: Any, screen: VirtualScreen) -> Any:
    """pyrender's renderer, which holds OpenGL until it is deleted.

    Raises
    ------
    ReferenceError
        There is no driver.
    """
    try:
        return pyrender.OffscreenRenderer(screen.nx, screen.ny)
    except Exception as error:  # PyOpenGL's own, or any that pyrender raises without a device
        raise ReferenceError(
            "OpenGL does not start without a window",
            got=type(error).__name__ + ": " + " ".join(str(error).split())[:200],
            expected=f"a driver: {PACKAGES}",
        ) from None


def _close(renderer: Any) -> None:
    """Release OpenGL.

    pyrender then makes Python collect garbage, among all objects of a long-lived process: a tenth
    of a second each time. Frozen objects are not examined; Python examines them later by itself.
    """
    gc.freeze()
    try:
        renderer.delete()
    finally:
        gc.unfreeze()


def build(pyrender: Any, whole: PyrenderScene) -> tuple[Any, dict[Any, tuple[int, int, int]]]:
    """pyrender's scene, and the colour of each of its nodes."""
    world, colors = pyrender.Scene(), {}
    for part in whole.parts:
        triangles = pyrender.Primitive(
            positions=part.vertices, indices=part.faces, mode=pyrender.constants.GLTF.TRIANGLES
        )
        node = pyrender.Node(mesh=pyrender.Mesh([triangles]))
        world.add_node(node)
        colors[node] = object_color(part.object)
    world.add_node(pyrender.Node(camera=pyrender.IntrinsicsCamera(**vars(whole.camera))))
    return world, colors


def object_color(number: int) -> tuple[int, int, int]:
    """An object's number, counted from 1, in three bytes; black is the background.

    Examples
    --------
    >>> object_color(0), object_color(254), object_color(65_535)
    ((1, 0, 0), (255, 0, 0), (0, 0, 1))
    """
    return (number + 1) & 255, (number + 1) >> 8 & 255, (number + 1) >> 16


def object_numbers(color: NDArray[np.uint8]) -> Ints:
    """Numbers (ny, nx) of objects by their colours (ny, nx, 3); −1 for the background."""
    red, green, blue = np.moveaxis(color.astype(np.int32), -1, 0)
    return np.asarray(red + (green << 8) + (blue << 16) - 1, dtype=np.int32)
