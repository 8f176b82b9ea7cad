"""Readers of mesh files, one a format: triangles in the file's own order, or one clear error.

Why minirt reads mesh files itself: the quantity `triangle` is the number of a face in the file, so
every face must be there, in the file's order. trimesh 5.2 was measured to regroup the faces of an
OBJ by material, to reorder a PLY of triangles and quads, to split quads another way than S11's
fan, and to lose faces of truncated files in silence. plyfile 1.1.5 keeps the order and reports
truncated files, but takes a list of −3 entries in a binary PLY for the rest of the file, allocates
memory for the 10⁹ faces that a file of 200 bytes announces, and needs 12 s where `ply.py` needs
0.1 s (binary, 10⁶ triangles).

Each reader is a function from the file's bytes to a `MeshBuilder`, and raises ValueError where the
file is truncated or malformed. No reader opens another file, and none runs long or takes much
memory on a small file.
"""

from __future__ import annotations

from collections.abc import Callable

from minirt.mesh_files.builder import MeshBuilder
from minirt.mesh_files.glb import read_glb
from minirt.mesh_files.obj import read_obj
from minirt.mesh_files.off import read_off
from minirt.mesh_files.ply import read_ply
from minirt.mesh_files.stl import read_stl

READERS: dict[str, Callable[[bytes], MeshBuilder]] = {
    ".obj": read_obj,
    ".ply": read_ply,
    ".stl": read_stl,
    ".glb": read_glb,
    ".off": read_off,
}
