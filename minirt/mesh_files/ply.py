"""Stanford PLY, ASCII and binary of both byte orders: its vertices and faces."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from minirt.mesh_files.builder import MeshBuilder

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass
class _Property:
    name: str
    kind: str
    #: Type of a list's length; empty for a single value.
    count_kind: str = ""


@dataclass
class _Element:
    name: str
    rows: int
    properties: list[_Property] = field(default_factory=list)

    def column(self, *names: str) -> int:
        """The number of the first property that has one of these names."""
        for k, entry in enumerate(self.properties):
            if entry.name in names:
                return k
        raise ValueError(f"the element {self.name} has no property {names[0]}")


def read_ply(data: bytes) -> MeshBuilder:
    """Vertices and faces in the file's order; polygons may have different numbers of vertices.

    Raises
    ------
    ValueError
        Not PLY, or shorter than its header says.
    """
    stream = io.BytesIO(data)
    order, elements = _header(stream)
    mesh = MeshBuilder()
    place = stream.tell()
    for element in elements:
        if order:
            place = _read_binary(element, order, data, place, mesh)
        else:
            _read_text(element, stream, mesh)
    return mesh


def _header(stream: io.BytesIO) -> tuple[str, list[_Element]]:
    """The byte order, empty for ASCII, and the elements; the stream is then at the data."""
    if stream.readline().strip() != b"ply":
        raise ValueError("does not begin with 'ply'")
    order: str | None = None
    elements: list[_Element] = []
    for line in stream:
        words = line.decode("latin-1").split()
        if words == ["end_header"]:
            break
        if words[:1] == ["format"] and words[1] in _ORDERS:
            order = _ORDERS[words[1]]
        elif words[:1] == ["element"] and len(words) == 3 and int(words[2]) >= 0:
            elements.append(_Element(words[1], int(words[2])))
        elif words[:1] == ["property"] and elements:
            elements[-1].properties.append(_property(words))
        elif words[:1] not in ([], ["comment"], ["obj_info"]):
            raise ValueError(f"not a line of a PLY header: {' '.join(words)[:80]}")
    else:
        raise ValueError("the header does not end")
    if order is None:
        raise ValueError("the header does not name a format")
    return order, elements


def _property(words: list[str]) -> _Property:
    kinds = [_TYPES.get(word, "") for word in words[1:-1] if word != "list"]
    is_list = words[1] == "list"
    if "" in kinds or len(kinds) != 1 + is_list or (is_list and kinds[0][0] == "f"):
        raise ValueError(f"not a property: {' '.join(words)[:80]}")
    return _Property(words[-1], kinds[-1], kinds[0] if is_list else "")


def _read_text(element: _Element, stream: io.BytesIO, mesh: MeshBuilder) -> None:
    axes, corners = _wanted(element)
    for row in range(element.rows):
        words = stream.readline().split()
        values: list[list[bytes]] = []
        place = 0
        for entry in element.properties:
            count = int(words[place]) if entry.count_kind and place < len(words) else 1
            place += bool(entry.count_kind)
            values.append(words[place : place + count])
            if count < 0 or len(values[-1]) != count:
                raise ValueError(f"{element.name} {row} of {element.rows} is incomplete")
            place += count
        if axes:
            mesh.add_vertex(values[k][0] for k in axes)
        if corners is not None:
            mesh.add_polygon([int(word) for word in values[corners]])


def _read_binary(element: _Element, order: str, data: bytes, place: int, mesh: MeshBuilder) -> int:
    """Read rows in runs of equally long lists; returns where the next element begins."""
    axes, corners = _wanted(element)
    has_lists = any(entry.count_kind for entry in element.properties)
    left = element.rows if element.properties else 0
    window = 1 if has_lists else left
    while left:
        kind = _row_type(element, order, data, place)
        fitting = min(left, window, (len(data) - place) // kind.itemsize)
        if not fitting:
            raise ValueError(f"the file ends in {element.name} {element.rows - left}")
        rows = _run(np.frombuffer(data, kind, fitting, place), element)
        if axes:
            mesh.add_vertices(np.stack([rows[f"v{k}"] for k in axes], axis=1))
        if corners is not None:
            mesh.add_polygons(rows[f"v{corners}"])
        left -= len(rows)
        place += len(rows) * kind.itemsize
        window = 2 * window if len(rows) == fitting else 1
    return place


def _wanted(element: _Element) -> tuple[list[int], int | None]:
    """The columns that are kept: three of a vertex, for x, y, z, or one of a face."""
    if element.name == "vertex":
        return [element.column(axis) for axis in "xyz"], None
    if element.name == "face" and element.rows:
        column = element.column("vertex_indices", "vertex_index")
        entry = element.properties[column]
        if not entry.count_kind or entry.kind[0] == "f":
            raise ValueError("a face's vertices are not a list of integers")
        return [], column
    return [], None


def _row_type(element: _Element, order: str, data: bytes, place: int) -> np.dtype[Any]:
    """A row's type, with lists as long as in the row at `place`: fields n0, v0, n1, v1, …."""
    fields: list[Any] = []
    for k, entry in enumerate(element.properties):
        if not entry.count_kind:
            fields.append((f"v{k}", order + entry.kind))
            continue
        before = place + np.dtype(fields).itemsize
        count_kind = np.dtype(order + entry.count_kind)
        if before + count_kind.itemsize > len(data):
            raise ValueError(f"the file ends in a list of {element.name}")
        count = int(np.frombuffer(data, count_kind, 1, before)[0])
        if not 0 <= count <= len(data):
            raise ValueError(f"a list of {count} entries in {element.name}")
        fields += [(f"n{k}", count_kind), (f"v{k}", order + entry.kind, (count,))]
    return np.dtype(fields)


def _run(rows: np.ndarray[Any, Any], element: _Element) -> np.ndarray[Any, Any]:
    """The leading rows whose lists are as long as the first row's."""
    alike = np.ones(len(rows), dtype=bool)
    for k, entry in enumerate(element.properties):
        if entry.count_kind:
            alike &= rows[f"n{k}"] == rows[f"n{k}"][0]
    return rows if alike.all() else rows[: int(np.argmin(alike))]
