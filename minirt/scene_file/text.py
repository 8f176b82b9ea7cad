"""The text of a scene file: read from its source, and decoded as JSON after RFC 8259."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from minirt.errors import SceneError
from minirt.scene_file.atlas import ATLAS_PREFIX, atlas_names, atlas_path
from minirt.scene_file.validation import json_path, shortened

#: Largest scene file that is read, in bytes.
MAX_SCENE_BYTES = 256 * 2**20
#: Digits of the longest integer that is read as one; a longer one is out of every range.
_MAX_DIGITS = 400
#: Most levels of nested brackets; the format has six.
_MAX_LEVELS = 64


def read_text(source: str) -> tuple[str, Path, str]:
    """A label for errors, the folder of the mesh files, and the text of a scene.

    Parameters
    ----------
    source : str
        A path, ``-`` for standard input, or ``atlas:NAME``.

    Raises
    ------
    SceneError
        No such scene, a file that cannot be read, is too large or not UTF-8.
    """
    if source == "-":
        label = "standard input"
        return label, Path(), _decoded(sys.stdin.buffer.read(MAX_SCENE_BYTES + 1), label)
    label = source if source.isprintable() and 0 < len(source) <= 300 else shortened(source)
    path = atlas_path(source, label) if source.startswith(ATLAS_PREFIX) else Path(source)
    try:
        with path.open("rb") as stream:
            data = stream.read(MAX_SCENE_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        meant = f"{ATLAS_PREFIX}{source}" if source in atlas_names() else ""
        raise SceneError(
            "the scene file cannot be read", where=label, got=reason, expected=meant
        ) from None
    return label, path.parent, _decoded(data, label)


def decode(text: str, label: str) -> Any:
    """The JSON document of a text; NaN and Infinity pass, and validation refuses them by path.

    Raises
    ------
    SceneError
        Not JSON, nested too deeply, or a key that occurs twice in one object.
    """
    try:
        document = json.loads(text, object_pairs_hook=_object, parse_int=_integer)
        _refuse_repeated(document, [], label)
    except json.JSONDecodeError as error:
        message = error.msg[:1].lower() + error.msg[1:]
        what = f"{message} at line {error.lineno}, column {error.colno}"
        raise SceneError(
            "not JSON",
            where=label,
            got=what if text.strip() else "nothing",
            expected="one JSON object",
        ) from None
    except RecursionError:
        raise SceneError(
            "nested too deeply", where=label, expected=f"at most {_MAX_LEVELS} levels of brackets"
        ) from None
    return document


def _decoded(data: bytes, label: str) -> str:
    if len(data) > MAX_SCENE_BYTES:
        raise SceneError(
            "the scene is too large", where=label, expected=f"at most {MAX_SCENE_BYTES:,} bytes"
        )
    try:
        return data.decode("utf-8-sig")  # a byte order mark is accepted, as RFC 8259 allows
    except UnicodeDecodeError as error:
        raise SceneError(
            "the scene is not UTF-8 text",
            where=label,
            got=f"byte 0x{data[error.start]:02x} at offset {error.start}",
        ) from None


class _Repeated(dict[str, Any]):
    """An object in which a key occurs twice."""

    key = ""


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(result) < len(pairs):
        result = _Repeated(result)
        keys = [key for key, _ in pairs]
        result.key = next(key for key in keys if keys.count(key) > 1)
    return result


def _integer(digits: str) -> int | float:
    return int(digits) if len(digits) <= _MAX_DIGITS else float(digits)


def _refuse_repeated(document: Any, path: list[int | str], label: str) -> None:
    if len(path) > _MAX_LEVELS:
        raise RecursionError
    if isinstance(document, _Repeated):
        raise SceneError(
            "a key occurs twice in one object",
            where=f"{label}: {json_path([*path, document.key])}",
            expected="each key once",
        )
    if isinstance(document, dict):
        for key, value in document.items():
            _refuse_repeated(value, [*path, key], label)
    elif isinstance(document, list):
        for index, value in enumerate(document):
            if isinstance(value, dict | list):
                _refuse_repeated(value, [*path, index], label)
