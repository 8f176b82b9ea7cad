"""Images and folders that are no frame are refused."""

from __future__ import annotations

import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

from converters.frames.io import read_frame, write_frame
from minirt.errors import InputError
from tests.helpers.frame_files import whole_frame, write_pixels


def huge_exr(path: Path, width: int, height: int) -> None:
    """An image of 1 × 1 whose header claims more."""
    write_pixels(path, np.zeros((1, 1), np.float32), ("Z",))
    data = bytearray(path.read_bytes())
    for window in (b"dataWindow\0box2i\0", b"displayWindow\0box2i\0"):
        start = data.index(window) + len(window) + 4
        data[start : start + 16] = struct.pack("<4i", 0, 0, width - 1, height - 1)
    path.write_bytes(data)


@pytest.mark.parametrize("size", [(100_000, 100_000), (20_000, 20_000), (2**17 + 1, 1)])
def test_exr_over_the_limit_is_refused_by_its_header(size: tuple[int, int], tmp_path: Path) -> None:
    huge_exr(tmp_path / "f.exr", *size)
    with pytest.raises(InputError):
        read_frame(tmp_path / "f.exr")


@pytest.mark.parametrize("name", ["f.npz", "f.exr", "f.d"])
def test_another_size_than_expected_is_refused(name: str, tmp_path: Path) -> None:
    write_frame(whole_frame(6, 4), tmp_path / name)
    with pytest.raises(InputError, match="wrong size") as caught:
        read_frame(tmp_path / name, expect=(4, 6))
    assert "4 × 6" in caught.value.got
    assert "6 × 4" in caught.value.expected


@pytest.mark.parametrize("bad", ["cropped", "incomplete", "foreign", "png inside"])
def test_an_exr_that_is_not_a_frame_is_refused(bad: str, tmp_path: Path) -> None:
    path, pixels = tmp_path / "f.exr", np.zeros((2, 2, 2), np.float32)
    if bad == "cropped":
        write_pixels(path, pixels[..., 0], ("Z",), full_width=5)
    elif bad == "incomplete":
        write_pixels(path, pixels, ("normal.x", "normal.z"))
    elif bad == "foreign":
        write_pixels(path, pixels, ("depth.V", "z"))
    else:
        write_pixels(tmp_path / "f.png", np.zeros((2, 2, 3), np.uint8))
        (tmp_path / "f.png").rename(path)
    with pytest.raises(InputError) as caught:
        read_frame(path)
    assert str(path) in caught.value.where


@pytest.mark.parametrize(
    ("names", "what"),
    [
        (["dept.png"], "unknown quantity"),
        (["hit.png", "hit.exr"], "occurs twice"),
        (["object.png"], "image of integers"),
        (["normal.png"], "image of integers"),
        (["notes.txt"], "no image"),
        ([], "no image"),
    ],
)
def test_folders_without_a_clear_set_of_images_are_refused(
    names: list[str], what: str, tmp_path: Path
) -> None:
    for name in names:
        kind = np.float32 if name.endswith(".exr") else np.uint8
        if name.endswith(".txt"):
            (tmp_path / name).write_text("notes")
        else:
            write_pixels(tmp_path / name, np.zeros((2, 2), kind))
    with pytest.raises(InputError, match=what) as caught:
        read_frame(tmp_path)
    assert str(tmp_path) in caught.value.where


def test_images_of_different_sizes_are_refused(tmp_path: Path) -> None:
    write_pixels(tmp_path / "hit.png", np.zeros((2, 2), np.uint8))
    write_pixels(tmp_path / "shadow.png", np.zeros((2, 3), np.uint8))
    with pytest.raises(InputError, match="wrong size"):
        read_frame(tmp_path)


def test_an_image_with_too_few_channels_is_refused(tmp_path: Path) -> None:
    write_pixels(tmp_path / "normal.exr", np.zeros((2, 2, 2), np.float32))
    with pytest.raises(InputError, match="not have the quantity's channels"):
        read_frame(tmp_path)


def test_a_depth_of_three_different_channels_is_refused(tmp_path: Path) -> None:
    write_pixels(tmp_path / "depth.exr", np.arange(3, dtype=np.float32).reshape(1, 1, 3))
    with pytest.raises(InputError, match="not have the quantity's channels"):
        read_frame(tmp_path)


def test_a_pipe_is_refused_without_waiting(tmp_path: Path) -> None:
    subprocess.run(["/usr/bin/mkfifo", tmp_path / "hit.png"], check=True)
    with pytest.raises(InputError, match="no such file"):
        read_frame(tmp_path)


@pytest.mark.parametrize("name", ["none.npz", "none", "f.jpg", "f\0.npz", "x" * 400 + ".npz"])
def test_a_missing_file_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError):
        read_frame(tmp_path / name)
