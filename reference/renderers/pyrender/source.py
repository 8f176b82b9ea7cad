"""The pyrender reference: OpenGL's rasteriser and depth buffer, which cast no ray."""

from __future__ import annotations

import ctypes
import importlib.util
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import numpy as np

from converters.pyrender import LEAST_NEAR, PyrenderScene, pyrender_scene
from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.renderers.pyrender.draw import MOST_OBJECTS, PACKAGES, draw
from reference.renderers.pyrender.errors import declared
from reference.source import Declared, Rendering, Unsupported

#: OpenGL without a window.
_LIBRARY = "libEGL.so.1"
#: Longest side of a picture: Mesa's largest buffer, and that of most graphics cards.
LARGEST_SIDE = 16_384

_GIVEN = ("hit", "object", "depth")
#: Where a system keeps OpenGL, the drivers of Mesa and the LLVM that it compiles with.
_DRIVERS = tuple(
    f"usr/lib/{folder}{name}"
    for folder in ("", "*-linux-gnu/")
    for name in ("libEGL*.so*", "libGL*.so*", "libgallium*.so*", "libLLVM*.so*", "dri/*.so")
)
_REASON = "a rasteriser gives the object and the depth of each pixel"


@dataclass(frozen=True)
class PyrenderReference:
    """The segmentation pass of pyrender: one colour for each object, without multisampling.

    pyrender's usual depth pass has four samples for each pixel, none of them at the centre, and
    keeps the depth of one.
    """

    name: str = "pyrender"

    def missing(self) -> str | None:
        """Why it cannot run here, with the command that would bring it; None where it can."""
        if importlib.util.find_spec("pyrender") is None:
            return "pyrender is not installed: pip install 'minirt[pyrender]'"
        try:
            ctypes.CDLL(_LIBRARY)
        except OSError:
            return f"no {_LIBRARY}: {PACKAGES}"
        return None

    def ingredients(self) -> tuple[str | Path | None, ...]:
        """pyrender with the packages below it, and the system's OpenGL with its compiler."""
        drivers = sorted(path for pattern in _DRIVERS for path in Path("/").glob(pattern))
        return "pyrender", "PyOpenGL", "trimesh", *drivers

    def declare(self, scene: Scene) -> Declared:
        """How it errs on this scene."""
        return declared(pyrender_scene(scene))

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Render the scene; imports pyrender, so only in a child process.

        Raises
        ------
        Unsupported
            An image, a number of objects or a range of depths beyond OpenGL's buffers.
        ReferenceError
            OpenGL does not start.
        """
        whole = pyrender_scene(scene)
        fault = buffer_fault(whole)
        if fault:
            raise Unsupported(fault)
        number, depth, driver = draw(whole)
        hit = number >= 0
        arrays = {"hit": hit, "object": number, "depth": np.where(hit, depth, np.inf)}
        unsupported = {name: _REASON for name in QUANTITIES if name not in _GIVEN}
        program = f"pyrender {metadata.version('pyrender')}, {driver}"
        return Rendering(Frame(arrays), unsupported, program)


def buffer_fault(whole: PyrenderScene) -> str | None:
    """Why the scene does not fit in OpenGL's buffers; None where it does."""
    screen, camera = whole.scene.screen, whole.camera
    if max(screen.nx, screen.ny) > LARGEST_SIDE:
        return f"OpenGL's buffers have at most {LARGEST_SIDE:,} pixels a side"
    if len(whole.scene.objects) > MOST_OBJECTS:
        return f"24 bits of colour tell at most {MOST_OBJECTS:,} objects apart"
    if camera.znear < LEAST_NEAR * camera.zfar:
        return "a surface comes too near to the observer for a depth buffer of 24 bits"
    return None
