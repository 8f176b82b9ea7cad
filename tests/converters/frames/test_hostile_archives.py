"""Archives that are broken, hostile or too large are refused."""

from __future__ import annotations

import struct
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from converters.frames.io import read_frame, write_frame
from minirt.errors import InputError
from minirt.frame import Frame
from tests.helpers.frame_files import Array, whole_frame


class Trap:
    def __reduce__(self) -> tuple[Any, ...]:
        return sys.exit, (9,)


def npz_with(path: Path, member: str, data: bytes, compression: int = zipfile.ZIP_DEFLATED) -> None:
    with zipfile.ZipFile(path, "w", compression) as archive:
        archive.writestr(member, data)


def npy_header(text: str, version: bytes = b"\x01\x00") -> bytes:
    return b"\x93NUMPY" + version + struct.pack("<H", len(text)) + text.encode()


def test_pickles_are_never_loaded(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="wrong type"):
        _read_saved(tmp_path, depth=np.array([[Trap()]], dtype=object))
    with pytest.raises(InputError, match="cannot be read"):
        _read_saved(tmp_path, depth=np.zeros((1, 1)), meta=np.array(Trap(), dtype=object))


def _read_saved(folder: Path, **arrays: Array) -> Frame:
    np.savez(folder / "f.npz", **arrays)  # type: ignore[arg-type]
    return read_frame(folder / "f.npz")


@pytest.mark.parametrize("shape", ["(100000, 100000)", "(16384, 16385)", "(1, 200000)"])
def test_npz_over_the_limit_is_refused_by_its_header(shape: str, tmp_path: Path) -> None:
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}"
    npz_with(tmp_path / "f.npz", "depth.npy", npy_header(text))
    with pytest.raises(InputError, match="over the size limit"):
        read_frame(tmp_path / "f.npz")


def test_a_zip_bomb_is_refused_by_its_header(tmp_path: Path) -> None:
    """300 MB that deflate to 0.3 MB: the declared length is not the array's."""
    bomb = npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2)}") + bytes(10**7)
    npz_with(tmp_path / "f.npz", "depth.npy", bomb)
    assert (tmp_path / "f.npz").stat().st_size < 10**5
    with pytest.raises(InputError, match="length is not the one"):
        read_frame(tmp_path / "f.npz")
    npz_with(tmp_path / "g.npz", "meta.npy", bomb)
    with pytest.raises(InputError, match="too long"):
        read_frame(tmp_path / "g.npz")


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"garbage",
        npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': (-1, -1)}"),
        npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': (1,"),
        npy_header("[" * 9000),
        npy_header("{'descr': '|O', 'fortran_order': False, 'shape': (1, 1)}"),
        npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1)}", b"\x03\x00"),
        npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': (True, 1)}"),
        npy_header("{'descr': 'nonsense', 'fortran_order': False, 'shape': (1, 1)}"),
        npy_header("'x' * 10**10"),
    ],
)
def test_broken_arrays_are_refused(data: bytes, tmp_path: Path) -> None:
    npz_with(tmp_path / "f.npz", "depth.npy", data)
    with pytest.raises(InputError) as caught:
        read_frame(tmp_path / "f.npz")
    assert "f.npz" in caught.value.where
    (tmp_path / "d").mkdir()
    (tmp_path / "d" / "depth.npy").write_bytes(data)
    with pytest.raises(InputError):
        read_frame(tmp_path / "d")


def test_an_array_that_occurs_twice_is_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "f.npz", "w") as archive:
        archive.writestr("depth", b"")
        archive.writestr("depth.npy", b"")
    with pytest.raises(InputError):
        read_frame(tmp_path / "f.npz")


def test_meta_that_is_not_a_json_object_is_refused(tmp_path: Path) -> None:
    for text, what in (("{", "not JSON"), ("[1]", "not a JSON object"), ("[" * 10**5, "not JSON")):
        with pytest.raises(InputError, match=what):
            _read_saved(tmp_path, depth=np.zeros((1, 1)), meta=np.array(text))
    assert _read_saved(tmp_path, hit=np.eye(2), meta=np.array('{"a": 1}')).meta == {"a": "1"}


@pytest.mark.parametrize("name", ["f.npz", "f.exr", "f.d/hit.png", "f.d/depth.exr"])
def test_truncated_and_damaged_files_never_give_a_traceback(name: str, tmp_path: Path) -> None:
    """Each cut is refused; each flipped byte is refused or gives a frame, never a traceback."""
    path, frame = tmp_path / name, whole_frame(20, 30)
    place = path if name.startswith("f.d") is False else path.parent
    write_frame(frame, place)
    data = path.read_bytes()
    for cut in (0, 1, 10, len(data) // 3, len(data) // 2, len(data) - 30):
        path.write_bytes(data[:cut])
        with pytest.raises(InputError) as caught:
            read_frame(place)
        assert str(place) in caught.value.where
    generator = np.random.default_rng(5)
    outcomes: list[object] = []
    for position in generator.integers(0, min(len(data), 3000), 60):
        damaged = bytearray(data)
        damaged[position] ^= 1 << int(generator.integers(8))
        path.write_bytes(damaged)
        try:
            outcomes.append(read_frame(place, expect=(20, 30)).size)
        except InputError as error:
            outcomes.append(error.what)
    assert len(outcomes) == 60
