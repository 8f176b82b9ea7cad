"""minirt: the ray tracing of a lecture's sixteen rules, exactly, in NumPy float64.

>>> import minirt
>>> frame = minirt.render(minirt.load_scene("atlas:one-sphere"))
>>> bool(frame["hit"][96, 128])
True
"""

from minirt.api import (
    RT,
    Hits,
    RT_all,
    intersect_polygon,
    intersect_sphere,
    intersect_triangle,
    ray_color,
)
from minirt.errors import InputError, MinirtError, SceneError
from minirt.frame import Frame
from minirt.optics import reflect, refract
from minirt.quantities import QUANTITIES
from minirt.render import render
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene
from minirt.scene_file.load import load_scene
from minirt.version import __version__

__all__ = [
    "QUANTITIES",
    "RT",
    "SLIDES",
    "Frame",
    "Hits",
    "InputError",
    "MinirtError",
    "RT_all",
    "Rules",
    "Scene",
    "SceneError",
    "__version__",
    "intersect_polygon",
    "intersect_sphere",
    "intersect_triangle",
    "load_scene",
    "ray_color",
    "reflect",
    "refract",
    "render",
]
