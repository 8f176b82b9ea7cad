"""Arrays and a JSON document as one binary glTF file.

Source: glTF 2.0 specification, sections 3.6 (buffers and accessors) and 4 (GLB).
"""

from __future__ import annotations

import json
import struct
from typing import Any

from minirt.vectors import Floats, Ints

_MAGIC, _VERSION = b"glTF", 2
_VERTICES, _INDICES = 34962, 34963  # targets of a buffer view
_FLOAT, _UINT = 5126, 5125


class Buffer:
    """The file's binary chunk, and the accessors and views that describe its content.

    Attributes
    ----------
    accessors, views : list of dict
        As the JSON document lists them.
    """

    def __init__(self) -> None:
        self.accessors: list[dict[str, Any]] = []
        self.views: list[dict[str, Any]] = []
        self._bytes = bytearray()

    def add_points(self, points: Floats) -> int:
        """Store points or vectors (k, 3) as float32; returns the accessor's number."""
        stored = points.astype("<f4")
        bounds = {"min": stored.min(axis=0).tolist(), "max": stored.max(axis=0).tolist()}
        return self._add(stored.tobytes(), _VERTICES, _FLOAT, "VEC3", len(stored), bounds)

    def add_faces(self, faces: Ints) -> int:
        """Store vertex numbers (m, 3) as uint32; returns the accessor's number."""
        return self._add(faces.astype("<u4").tobytes(), _INDICES, _UINT, "SCALAR", faces.size, {})

    def _add(
        self,
        data: bytes,
        target: int,
        component: int,
        kind: str,
        count: int,
        bounds: dict[str, Any],
    ) -> int:
        view = {"buffer": 0, "byteOffset": len(self._bytes), "byteLength": len(data)}
        accessor = {"bufferView": len(self.views), "componentType": component, "type": kind}
        self.views.append(view | {"target": target})
        self.accessors.append(accessor | {"count": count} | bounds)
        self._bytes += data
        return len(self.accessors) - 1

    def file(self, document: dict[str, Any]) -> bytes:
        """The complete file: the document, with the accessors and views added, and the chunk."""
        length = len(self._bytes)
        stored = {
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": length}] if length else [],
        }
        whole = {key: value for key, value in (document | stored).items() if value}
        text = json.dumps(whole, separators=(",", ":"), allow_nan=False)
        chunks = _chunk(b"JSON", text.encode(), b" ")
        if length:
            chunks += _chunk(b"BIN\0", bytes(self._bytes), b"\0")
        return struct.pack("<4sII", _MAGIC, _VERSION, 12 + len(chunks)) + chunks


def _chunk(kind: bytes, data: bytes, padding: bytes) -> bytes:
    data += padding * (-len(data) % 4)
    return struct.pack("<I4s", len(data), kind) + data
