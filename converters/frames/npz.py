"""A frame as one NumPy archive: every bit of it, and the same bytes for the same frame."""

from __future__ import annotations

import json
import math
import zipfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

from converters.frames.casts import Size, as_quantity, check_size, check_type
from minirt.errors import InputError
from minirt.frame import Array, Frame
from minirt.quantities import QUANTITIES, Quantity

_META = "meta"
_MAX_META_BYTES = 2**20
_BLOCK_BYTES = 2**25


def write_npz(frame: Frame, path: Path) -> None:
    """Write quantities in the table's order, and `meta`. Not atomic; see `converters.frames.io`.

    Members are stored, not compressed, with a fixed date: two equal frames are equal files, on
    any machine and with any version of zlib. Arrays are written a block of rows at a time.
    """
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name in QUANTITIES:
            if name in frame:
                _write_member(archive, name, frame[name])
        _write_member(archive, _META, np.array(meta_text(frame.meta)))


def write_array(stream: IO[bytes], array: Array) -> None:
    """Write one array in NumPy's own format, version 1, C order, without a copy of the whole."""
    descr = npy.dtype_to_descr(array.dtype)
    npy.write_array_header_1_0(
        stream, {"descr": descr, "fortran_order": False, "shape": array.shape}
    )
    rows = max(1, _BLOCK_BYTES * len(array) // array.nbytes)
    for top in range(0, len(array), rows):
        stream.write(array[top : top + rows].tobytes())


def read_npz(path: Path, expect: Size) -> Frame:
    """Read an archive of quantities; sizes and types are checked before anything is allocated.

    `meta` may be absent. Nothing is ever unpickled.

    Raises
    ------
    InputError
        Not a readable archive, a name that is not in the table, or an array that the quantity
        cannot be.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            return _read_members(archive, path, expect)
    except InputError:
        raise
    except Exception as error:  # whatever zipfile, its decompressors and NumPy's parser meet
        raise _broken(path, error, "an .npz archive of arrays") from None


def read_npy(path: Path, quantity: Quantity, expect: Size) -> Array:
    """Read one quantity from an .npy file.

    Parameters
    ----------
    path : Path
    quantity : Quantity
    expect : (ny, nx) or None

    Raises
    ------
    InputError
        Not a readable array, or one that the quantity cannot be.
    """
    try:
        return _read_array(
            lambda: path.open("rb"), path.stat().st_size, quantity, str(path), expect
        )
    except InputError:
        raise
    except Exception as error:  # whatever NumPy's parser meets
        raise _broken(path, error, "an .npy array") from None


def meta_text(meta: Mapping[str, str]) -> str:
    """The JSON text; the same for the same content."""
    return json.dumps(dict(meta), sort_keys=True)


def parse_meta(text: str, where: str) -> dict[str, str]:
    """What `meta_text` wrote; values that are not strings are kept as their JSON text.

    Raises
    ------
    InputError
        Not the JSON text of an object.
    """
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError("not JSON", where=where, got=str(error)[:200]) from None
    if not isinstance(document, dict):
        raise InputError("not a JSON object", where=where, got=text[:80])
    return {k: v if isinstance(v, str) else json.dumps(v) for k, v in document.items()}


def _write_member(archive: zipfile.ZipFile, name: str, array: Array) -> None:
    member = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
    member.create_system = 3  # Unix, for the meaning of the permissions
    member.external_attr = 0o644 << 16
    with archive.open(member, "w", force_zip64=True) as stream:
        if array.ndim:
            write_array(stream, array)
        else:
            npy.write_array(stream, array, version=(1, 0), allow_pickle=False)


def _read_members(archive: zipfile.ZipFile, path: Path, expect: Size) -> Frame:
    arrays: dict[str, Array] = {}
    meta: dict[str, str] = {}
    seen: set[str] = set()
    for member in archive.infolist():
        name = member.filename.removesuffix(".npy")
        if name in seen or (name not in QUANTITIES and name != _META):
            raise InputError(
                "an array occurs twice" if name in seen else "unknown quantity",
                where=str(path),
                got=repr(member.filename)[:80],
                expected=", ".join([*QUANTITIES, _META]),
            )
        seen.add(name)
        if name == _META:
            meta = _read_meta(archive, member, f"{path}: meta")
            continue
        arrays[name] = _read_array(
            partial(archive.open, member),
            member.file_size,
            QUANTITIES[name],
            f"{path}: {name}",
            expect,
        )
        expect = arrays[name].shape[0], arrays[name].shape[1]
    if not arrays:
        raise InputError("no quantity in the file", where=str(path), expected=", ".join(QUANTITIES))
    return Frame(arrays, meta)


def _read_array(
    opener: Callable[[], IO[bytes]], length: int, quantity: Quantity, where: str, expect: Size
) -> Array:
    """Check an array by its header, then read it."""
    with opener() as stream:
        shape, dtype = _read_header(stream)
        check_type(dtype, quantity, where)
        if len(shape) < 2 or shape != quantity.shape(*shape[:2]):
            expected = str(quantity.shape(0, 0)).replace("(0, 0", "(ny, nx")
            raise InputError("wrong shape", where=where, got=str(shape)[:80], expected=expected)
        check_size(shape[0], shape[1], expect, where)
        if stream.tell() + math.prod(shape) * dtype.itemsize != length:
            raise InputError(
                "the array's length is not the one in its header",
                where=where,
                got=f"{length:,} bytes",
                expected=f"{stream.tell() + math.prod(shape) * dtype.itemsize:,}",
            )
    with opener() as stream:
        array = npy.read_array(stream, allow_pickle=False)
    return as_quantity(np.ascontiguousarray(array), quantity, where)


def _read_header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    version = npy.read_magic(stream)
    if version == (1, 0):
        shape, _, dtype = npy.read_array_header_1_0(stream)
    elif version == (2, 0):
        shape, _, dtype = npy.read_array_header_2_0(stream)
    else:
        raise ValueError(f"version {version} of the .npy format")
    return shape, dtype


def _read_meta(archive: zipfile.ZipFile, member: zipfile.ZipInfo, where: str) -> dict[str, str]:
    if member.file_size > _MAX_META_BYTES:
        raise InputError(
            "the text is too long",
            where=where,
            got=f"{member.file_size:,} bytes",
            expected=f"at most {_MAX_META_BYTES:,}",
        )
    with archive.open(member) as stream:
        array = npy.read_array(stream, allow_pickle=False)
    return parse_meta(str(array), where)


def _broken(path: Path, error: Exception, expected: str) -> InputError:
    reason = " ".join(str(error).split())[:200] or type(error).__name__
    return InputError("the file cannot be read", where=str(path), got=reason, expected=expected)
