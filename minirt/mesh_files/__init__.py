"""Readers of mesh files, one a format: triangles in the file's own order, or one clear error.

Each is a function from the file's bytes to a `Soup`, and raises ValueError where the file is not
whole. No reader opens another file, and none runs long or takes much memory on a small file.
"""

from __future__ import annotations

from collections.abc import Callable

from minirt.mesh_files.glb import read_glb
from minirt.mesh_files.obj import read_obj
from minirt.mesh_files.off import read_off
from minirt.mesh_files.ply import read_ply
from minirt.mesh_files.soup import Soup
from minirt.mesh_files.stl import read_stl

READERS: dict[str, Callable[[bytes], Soup]] = {
    ".obj": read_obj,
    ".ply": read_ply,
    ".stl": read_stl,
    ".glb": read_glb,
    ".off": read_off,
}
