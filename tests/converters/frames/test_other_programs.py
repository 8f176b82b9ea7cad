"""Folders of images and EXR files as other programs write them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio

from converters.frames.io import read_frame, write_image
from converters.frames.srgb import linear_light, srgb_codes
from minirt.frame import Frame
from tests.helpers.frame_files import write_pixels


def test_pfm_rows_count_from_the_bottom(tmp_path: Path) -> None:
    depth = np.arange(6, dtype="<f4").reshape(3, 2)
    bottom_up = b"".join(row.tobytes() for row in depth[::-1])
    (tmp_path / "depth.pfm").write_bytes(b"Pf\n2 3\n-1.0\n" + bottom_up)
    np.testing.assert_array_equal(read_frame(tmp_path)["depth"], depth)
    write_image(Frame({"depth": depth.astype(float)}), "depth", tmp_path / "again.pfm")
    assert (tmp_path / "again.pfm").read_bytes().endswith(bottom_up)


def test_png_masks_are_true_from_half_of_white(tmp_path: Path) -> None:
    write_pixels(tmp_path / "hit.png", np.array([[0, 127], [128, 255]], dtype=np.uint8))
    np.testing.assert_array_equal(read_frame(tmp_path)["hit"], [[False, False], [True, True]])
    write_pixels(tmp_path / "hit.png", np.array([[32767, 32768]], dtype=np.uint16))
    np.testing.assert_array_equal(read_frame(tmp_path)["hit"], [[False, True]])


def test_a_png_mask_in_colour_is_read_by_its_mean_without_coverage(tmp_path: Path) -> None:
    """The grey is the mean of red, green and blue; the fourth channel says nothing."""
    pixels = np.array([[[255, 255, 255, 0], [255, 128, 0, 255], [255, 126, 0, 255]]], np.uint8)
    write_pixels(tmp_path / "hit.png", pixels, ("R", "G", "B", "A"))
    np.testing.assert_array_equal(read_frame(tmp_path)["hit"], [[True, True, False]])


def test_shadow_png_takes_its_misses_from_hit(tmp_path: Path) -> None:
    write_pixels(tmp_path / "shadow.png", np.array([[0, 255, 0, 255]], dtype=np.uint8))
    np.testing.assert_array_equal(read_frame(tmp_path)["shadow"], [[0, 1, 0, 1]])
    write_pixels(tmp_path / "hit.png", np.array([[255, 255, 0, 0]], dtype=np.uint8))
    np.testing.assert_array_equal(read_frame(tmp_path)["shadow"], [[0, 1, -1, -1]])


def test_shadow_in_numbers_keeps_its_own_misses(tmp_path: Path) -> None:
    write_pixels(tmp_path / "shadow.exr", np.array([[0, 1, -1]], dtype=np.float32))
    write_pixels(tmp_path / "hit.png", np.array([[255, 0, 0]], dtype=np.uint8))
    np.testing.assert_array_equal(read_frame(tmp_path)["shadow"], [[0, 1, -1]])


def test_color_png_is_srgb(tmp_path: Path) -> None:
    """Mid grey 188 is half of the light: the standard's own example, to half a code."""
    codes = np.array([[[0, 188, 255]]], dtype=np.uint8)
    write_pixels(tmp_path / "color.png", codes, ("R", "G", "B"))
    color = read_frame(tmp_path)["color"]
    slope = 1.1 / 0.5 * 0.5  # relative change of light by a code near 188: 2.4 / 188 · 0.5
    np.testing.assert_allclose(color, [[[0, 0.5, 1]]], atol=slope * 0.5 / 188 * 2.4)
    write_image(Frame({"color": color}), "color", tmp_path / "again.png")
    source = oiio.ImageInput.open(str(tmp_path / "again.png"))
    assert source is not None
    np.testing.assert_array_equal(source.read_image(0, 0, 0, 3, "uint8"), codes)


def test_srgb_codes_are_the_nearest_ones() -> None:
    codes = np.arange(256, dtype=np.uint8)
    np.testing.assert_array_equal(srgb_codes(linear_light(codes)), codes)
    np.testing.assert_array_equal(
        srgb_codes(np.array([-1, np.nan, -np.inf, 2, np.inf])), [0, 0, 0, 255, 255]
    )
    light = np.linspace(0, 1, 10_001)
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    # The standard's two branches meet to 1e-8 of a code; half a code is the rounding.
    assert np.abs(srgb_codes(light) - 255 * encoded).max() <= 0.5 + 1e-6
    assert linear_light(np.array([65535], dtype=np.uint16)) == 1


def test_equal_channels_may_be_dropped_or_added(tmp_path: Path) -> None:
    """Programs that drop or add equal channels on their own."""
    write_pixels(tmp_path / "color.png", np.array([[255, 0]], dtype=np.uint8))
    depth = np.repeat(np.array([[1.5, np.inf]], dtype=np.float32)[..., None], 4, axis=2)
    depth[..., 3] = 1
    write_pixels(tmp_path / "depth.exr", depth, ("R", "G", "B", "A"))
    frame = read_frame(tmp_path)
    np.testing.assert_array_equal(frame["color"], [[[1, 1, 1], [0, 0, 0]]])
    np.testing.assert_array_equal(frame["depth"], [[1.5, np.inf]])


def test_npy_files_are_read_and_other_files_ignored(tmp_path: Path) -> None:
    np.save(tmp_path / "depth.npy", np.array([[1, 2]], dtype=np.float32))
    np.save(tmp_path / "object.npy", np.asfortranarray([[-1, 70_000]], dtype=np.int64))
    (tmp_path / "log.txt").write_text("done")
    frame = read_frame(tmp_path)
    assert set(frame) == {"depth", "object"}
    np.testing.assert_array_equal(frame["object"], [[-1, 70_000]])
    assert frame["object"].flags.c_contiguous
    assert frame.meta == {}


def test_channels_of_other_names_are_ignored(tmp_path: Path) -> None:
    pixels = np.array([[[3, 4, 5]]], dtype=np.float32)
    write_pixels(tmp_path / "f.exr", pixels, ("Z", "crypto.x", "depth"))
    frame = read_frame(tmp_path / "f.exr")
    assert set(frame) == {"depth"}
    assert frame["depth"][0, 0] == 3


def test_integer_and_half_channels_keep_their_values(tmp_path: Path) -> None:
    """OpenImageIO alone would read a UINT channel's 1 as 1/(2³²−1)."""
    codes = np.array([[[1, 0.5, 2]]], dtype=np.float32)
    names, formats = ("hit", "Z", "object"), (oiio.HALF, oiio.HALF, oiio.FLOAT)
    types = tuple(oiio.TypeDesc(f) for f in formats)
    write_pixels(tmp_path / "f.exr", codes, names, formats=types)
    write_pixels(tmp_path / "g.exr", np.array([[7]], dtype=np.uint32), ("object",))
    frame = read_frame(tmp_path / "f.exr")
    assert (frame["hit"][0, 0], frame["depth"][0, 0], frame["object"][0, 0]) == (True, 0.5, 2)
    assert read_frame(tmp_path / "g.exr")["object"][0, 0] == 7


def test_a_tiled_exr_is_read(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr("converters.frames.images.BLOCK_BYTES", 1)
    depth = np.arange(50 * 40, dtype=np.float32).reshape(50, 40)
    write_pixels(tmp_path / "f.exr", depth, ("Z",), tile=16)
    np.testing.assert_array_equal(read_frame(tmp_path / "f.exr")["depth"], depth)
