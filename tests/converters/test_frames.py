"""Frames in files: round trips, what is taken over, what is refused."""

from __future__ import annotations

import hashlib
import struct
import subprocess
import sys
import tracemalloc
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray
from PIL import Image

from converters.frames.folder import META_FILE
from converters.frames.io import read_frame, write_frame, write_image
from converters.frames.srgb import linear_light, srgb_codes
from minirt.errors import InputError
from minirt.frame import Frame
from minirt.quantities import QUANTITIES, Quantity

Array = NDArray[Any]
META = {"scene": "kugel ν", "sceneSha256": "ab" * 32, "version": "0.1.0"}
KINDS = ("f.npz", "f.exr", "f.d", "f")


def values_of(quantity: Quantity, ny: int, nx: int) -> st.SearchStrategy[Array]:
    """Values that float32 holds, infinities and NaN among them."""
    shape, dtype = quantity.shape(ny, nx), np.dtype(quantity.dtype)
    if dtype.kind == "f":
        return hnp.arrays(dtype, shape, elements=st.floats(width=32))
    if dtype.kind == "b":
        return hnp.arrays(dtype, shape)
    top = 1 if dtype == np.int8 else 2**24
    return hnp.arrays(dtype, shape, elements=st.integers(-1, top))


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    ny, nx = draw(st.tuples(st.integers(1, 5), st.integers(1, 5)))
    names = draw(st.lists(st.sampled_from(list(QUANTITIES)), min_size=1, unique=True))
    arrays = {name: draw(values_of(QUANTITIES[name], ny, nx)) for name in names}
    if "hit" in arrays and "shadow" in arrays:  # the table's: −1 where nothing is hit, else 0, 1
        arrays["shadow"] = np.where(arrays["hit"], np.abs(arrays["shadow"]), -1).astype(np.int8)
    text = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), min_size=1)
    return Frame(arrays, draw(st.dictionaries(st.sampled_from(list(META)), text)))


def whole_frame(ny: int = 6, nx: int = 4) -> Frame:
    """Every quantity, no two rows or columns alike."""
    arrays = {}
    for k, quantity in enumerate(QUANTITIES.values()):
        shape = quantity.shape(ny, nx)
        ramp = np.arange(np.prod(shape)).reshape(shape) + k
        arrays[quantity.name] = (ramp % 2 if quantity.discrete else ramp / 7).astype(quantity.dtype)
    arrays["shadow"][~arrays["hit"]] = -1
    return Frame(arrays, META)


def assert_same(a: Frame, b: Frame, exact: bool = True) -> None:
    assert set(a) == set(b)
    assert len(a) > 0
    for name in a:
        expected = a[name] if exact or QUANTITIES[name].discrete else a[name].astype(np.float32)
        assert b[name].dtype == QUANTITIES[name].dtype
        np.testing.assert_array_equal(b[name], expected, err_msg=name)
    assert b.meta == a.meta


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def write_pixels(path: Path, pixels: Array, names: tuple[str, ...] = (), **extra: Any) -> None:
    """An image as another program would write it."""
    pixels = np.atleast_3d(pixels)
    kind = {"float32": "float", "uint32": "uint"}.get(pixels.dtype.name, pixels.dtype.name)
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    if names:
        spec.channelnames = names
    if "formats" in extra:
        spec.channelformats = extra["formats"]
    if "tile" in extra:
        spec.tile_width = spec.tile_height = extra["tile"]
    if "full_width" in extra:
        spec.full_width = extra["full_width"]
    out = oiio.ImageOutput.create(str(path))
    assert out is not None
    assert out.open(str(path), spec), out.geterror()
    assert out.write_image(np.ascontiguousarray(pixels)), out.geterror()
    assert out.close()


# Round trips


@pytest.mark.parametrize("name", KINDS[:3])
def test_round_trip(name: str) -> None:
    @settings(max_examples=25, deadline=None, derandomize=True, database=None)
    @given(frames())
    def check(frame: Frame) -> None:
        with TemporaryDirectory() as folder:
            write_frame(frame, Path(folder) / name)
            assert_same(frame, read_frame(Path(folder) / name))
        seen.append(len(frame))

    seen: list[int] = []
    check()
    assert len(seen) >= 25


@pytest.mark.parametrize("name", KINDS)
def test_every_quantity_comes_back(name: str, tmp_path: Path) -> None:
    frame = whole_frame()
    write_frame(frame, tmp_path / name)
    assert_same(frame, read_frame(tmp_path / name, expect=(6, 4)), exact=name == "f.npz")


@pytest.mark.parametrize("name", ["f.npz", "f.exr"])
def test_same_frame_same_bytes(name: str, tmp_path: Path) -> None:
    frame = whole_frame()
    other_order = {k: np.asfortranarray(frame[k]) for k in reversed(list(frame))}
    for folder, content in (("a", frame), ("b", Frame(other_order, dict(META)))):
        (tmp_path / folder).mkdir()
        write_frame(content, tmp_path / folder / name)
    assert digest(tmp_path / "a" / name) == digest(tmp_path / "b" / name)
    data = (tmp_path / "a" / name).read_bytes()
    assert b"capDate" not in data, "OpenEXR's time of writing"


def test_npz_bytes_do_not_depend_on_the_machine(tmp_path: Path) -> None:
    """Stored members, fixed dates: the digest of a known frame is a constant.

    Computed once by this test's own frame; NumPy's header is part of it.
    """
    write_frame(Frame({"hit": np.eye(2, dtype=bool)}, {"scene": "s"}), tmp_path / "f.npz")
    with zipfile.ZipFile(tmp_path / "f.npz") as archive:
        assert archive.namelist() == ["hit.npy", "meta.npy"]
        assert {m.compress_type for m in archive.infolist()} == {zipfile.ZIP_STORED}
        assert {m.date_time for m in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_numpy_reads_the_npz(tmp_path: Path) -> None:
    frame = whole_frame()
    write_frame(frame, tmp_path / "f.npz")
    with np.load(tmp_path / "f.npz", allow_pickle=False) as archive:
        assert archive.files == [*QUANTITIES, "meta"]
        assert archive["depth"].dtype == np.float64
        assert '"scene": "kugel' in str(archive["meta"])


def test_exr_has_the_names_that_viewers_know(tmp_path: Path) -> None:
    write_frame(whole_frame(), tmp_path / "f.exr")
    source = oiio.ImageInput.open(str(tmp_path / "f.exr"))
    assert source is not None
    spec = source.spec()
    assert tuple(spec.channelnames[:5]) == ("R", "G", "B", "A", "Z")
    assert set(spec.channelnames) == {c for q in QUANTITIES.values() for c in q.channels}
    assert str(spec.format) == "float"
    assert spec.get_string_attribute("compression") == "zip"
    assert spec.get_string_attribute("minirt:scene") == META["scene"]
    assert spec.get_string_attribute("minirt:sceneSha256") == META["sceneSha256"]


def test_folder_shows_the_colours_too_and_reads_the_numbers(tmp_path: Path) -> None:
    frame = whole_frame()
    write_frame(frame, tmp_path / "f")
    assert {"color.png", "color.exr"} <= {path.name for path in (tmp_path / "f").iterdir()}
    assert_same(frame, read_frame(tmp_path / "f"), exact=False)
    (tmp_path / "f" / "color.exr").unlink()
    assert read_frame(tmp_path / "f")["color"].shape == frame["color"].shape
    write_frame(frame, tmp_path / "f", images={"color": ".png"})
    assert not (tmp_path / "f" / "color.exr").exists()


def test_black_in_shadow_png_is_lit_or_nothing_hit_as_hit_png_says(tmp_path: Path) -> None:
    shadow = np.array([[1, 0, -1]], dtype=np.int8)
    write_frame(Frame({"hit": shadow >= 0, "shadow": shadow}), tmp_path / "f")
    assert np.asarray(Image.open(tmp_path / "f" / "shadow.png")).tolist() == [[255, 0, 0]]
    assert read_frame(tmp_path / "f")["shadow"].tolist() == [[1, 0, -1]]


def test_folder_has_images_that_people_can_look_at(tmp_path: Path) -> None:
    write_frame(whole_frame(), tmp_path / "f", images={"color": ".png", "depth": ".pfm"})
    names = {p.name for p in (tmp_path / "f").iterdir()}
    assert {"hit.png", "shadow.png", "color.png", "depth.pfm", "normal.exr", META_FILE} <= names
    assert len(names) == len(QUANTITIES) + 1


def test_blocks_of_rows_join_without_a_seam(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr("converters.frames.images.BLOCK_BYTES", 1)
    monkeypatch.setattr("converters.frames.npz._BLOCK_BYTES", 1)
    frame = whole_frame(37, 5)
    images = {"depth": ".pfm", "position": ".pfm"}
    for name, wish in (("f.npz", None), ("f.exr", None), ("f.d", images)):
        write_frame(frame, tmp_path / name, wish)
        assert_same(frame, read_frame(tmp_path / name), exact=name == "f.npz")


@pytest.mark.parametrize("name", ["f.npz", "f.exr", "f.d"])
def test_memory_is_bounded_by_blocks(name: str, tmp_path: Path, monkeypatch: Any) -> None:
    """Beside the arrays: on writing some blocks, on reading some blocks. They hold 35 MB.

    A block of b bytes counts 4 a value; its float64 original, its float32 copy, the values that
    OpenImageIO hands over and masks of one byte a value make less than 6 b at a time.
    """
    monkeypatch.setattr("converters.frames.images.BLOCK_BYTES", 2**19)
    monkeypatch.setattr("converters.frames.npz._BLOCK_BYTES", 2**19)
    ramp = np.linspace(0, 1, 1024)
    color = np.stack([ramp + ramp[:, None]] * 3, axis=2)
    frame = Frame({"depth": color[..., 0].copy(), "hit": color[..., 0] > 1, "color": color})
    held = sum(array.nbytes for array in frame.values())
    write_frame(frame, tmp_path / name)  # what is allocated once, on the first call
    tracemalloc.start()
    write_frame(frame, tmp_path / name)
    written = tracemalloc.get_traced_memory()[1]
    tracemalloc.reset_peak()
    size = read_frame(tmp_path / name).size
    read = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert size == (1024, 1024)
    assert held > 34e6
    assert written < 6 * 2**19
    assert read - held < 6 * 2**19


# Folders from other programs


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


def test_png_mask_in_colour_with_coverage(tmp_path: Path) -> None:
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


def test_grey_png_as_color_and_rgb_exr_as_depth(tmp_path: Path) -> None:
    """Programs that drop or add equal channels on their own."""
    write_pixels(tmp_path / "color.png", np.array([[255, 0]], dtype=np.uint8))
    depth = np.repeat(np.array([[1.5, np.inf]], dtype=np.float32)[..., None], 4, axis=2)
    depth[..., 3] = 1
    write_pixels(tmp_path / "depth.exr", depth, ("R", "G", "B", "A"))
    frame = read_frame(tmp_path)
    np.testing.assert_array_equal(frame["color"], [[[1, 1, 1], [0, 0, 0]]])
    np.testing.assert_array_equal(frame["depth"], [[1.5, np.inf]])


def test_npy_and_other_files_in_a_folder(tmp_path: Path) -> None:
    np.save(tmp_path / "depth.npy", np.array([[1, 2]], dtype=np.float32))
    np.save(tmp_path / "object.npy", np.asfortranarray([[-1, 70_000]], dtype=np.int64))
    (tmp_path / "log.txt").write_text("done")
    frame = read_frame(tmp_path)
    assert set(frame) == {"depth", "object"}
    np.testing.assert_array_equal(frame["object"], [[-1, 70_000]])
    assert frame["object"].flags.c_contiguous
    assert frame.meta == {}


# EXR files from other programs


def test_channels_of_others_are_left_alone(tmp_path: Path) -> None:
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


def test_tiled_exr(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr("converters.frames.images.BLOCK_BYTES", 1)
    depth = np.arange(50 * 40, dtype=np.float32).reshape(50, 40)
    write_pixels(tmp_path / "f.exr", depth, ("Z",), tile=16)
    np.testing.assert_array_equal(read_frame(tmp_path / "f.exr")["depth"], depth)


# What is taken over, and what is not


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("depth", np.array([[1.5]], np.float32)),
        ("depth", np.array([[1.5]], np.float16)),
        ("depth", np.array([[2]], np.int64)),
        ("depth", np.array([[1.5]], ">f8")),
        ("hit", np.array([[1]], np.uint8)),
        ("hit", np.array([[1.0]], np.float64)),
        ("object", np.array([[5]], np.int64)),
        ("object", np.array([[5.0]], np.float32)),
        ("shadow", np.array([[True]])),
    ],
)
def test_values_are_taken_over(name: str, values: Array, tmp_path: Path) -> None:
    np.savez(tmp_path / "f.npz", allow_pickle=False, **{name: values})
    read = read_frame(tmp_path / "f.npz")[name]
    assert read.dtype == QUANTITIES[name].dtype
    assert read[0, 0] == values[0, 0]


@pytest.mark.parametrize(
    ("name", "values", "what"),
    [
        ("depth", np.array([[1j]]), "wrong type"),
        ("depth", np.array([["1"]]), "wrong type"),
        ("depth", np.array([[0]], "M8[s]"), "wrong type"),
        ("depth", np.zeros((1, 1), [("a", "f8")]), "wrong type"),
        ("depth", np.array([[1]], np.longdouble), "wrong type"),
        ("hit", np.array([[2]], np.uint8), "cannot have"),
        ("hit", np.array([[np.nan]]), "cannot have"),
        ("object", np.array([[0.5]]), "cannot have"),
        ("object", np.array([[2**31]], np.int64), "cannot have"),
        ("object", np.array([[2**63]], np.uint64), "cannot have"),
        ("shadow", np.array([[255]], np.uint8), "cannot have"),
        ("shadow", np.array([[np.inf]]), "cannot have"),
        ("depth", np.zeros(3), "wrong shape"),
        ("depth", np.float64(3), "wrong shape"),
        ("depth", np.zeros((2, 2, 1)), "wrong shape"),
        ("normal", np.zeros((2, 2)), "wrong shape"),
        ("normal", np.zeros((3, 2, 2)), "wrong shape"),
        ("depth", np.zeros((0, 4)), "empty"),
        ("Depth", np.zeros((1, 1)), "unknown quantity"),
        ("../depth", np.zeros((1, 1)), "unknown quantity"),
    ],
)
def test_arrays_are_refused(name: str, values: Array, what: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "f.npz", allow_pickle=False, **{name: values})
    with pytest.raises(InputError, match=what) as caught:
        read_frame(tmp_path / "f.npz")
    assert caught.value.where.startswith(str(tmp_path / "f.npz"))
    assert caught.value.got


def test_nan_is_read(tmp_path: Path) -> None:
    np.savez(tmp_path / "f.npz", allow_pickle=False, depth=np.array([[np.nan, -np.inf]]))
    np.testing.assert_array_equal(read_frame(tmp_path / "f.npz")["depth"], [[np.nan, -np.inf]])


@pytest.mark.parametrize("name", ["f.exr", "f.d", "object.pfm"])
def test_an_id_that_float32_would_round_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    for value, fits in ((2**24, True), (2**24 + 1, False), (-(2**31), False)):
        frame = Frame({"object": np.array([[value]], dtype=np.int32)})
        write = write_frame if name != "object.pfm" else _write_object
        if fits:
            write(frame, path)
            continue
        with pytest.raises(InputError, match="float32 cannot hold"):
            write(frame, path)
    assert path.exists(), "the file before stays"
    assert len(list(tmp_path.iterdir())) == 1, "nothing else is left"


def _write_object(frame: Frame, path: Path) -> None:
    write_image(frame, "object", path)


def test_a_length_that_float32_would_lose_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="float32 cannot hold"):
        write_frame(Frame({"depth": np.array([[1e39]])}), tmp_path / "f.exr")


# Hostile files


class Trap:
    def __reduce__(self) -> tuple[Any, ...]:
        return sys.exit, (9,)


def npz_with(path: Path, member: str, data: bytes, compression: int = zipfile.ZIP_DEFLATED) -> None:
    with zipfile.ZipFile(path, "w", compression) as archive:
        archive.writestr(member, data)


def npy_header(text: str, version: bytes = b"\x01\x00") -> bytes:
    return b"\x93NUMPY" + version + struct.pack("<H", len(text)) + text.encode()


def test_pickles_are_not_opened(tmp_path: Path) -> None:
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


def test_zip_bomb_is_refused_by_its_header(tmp_path: Path) -> None:
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
def test_broken_arrays(data: bytes, tmp_path: Path) -> None:
    npz_with(tmp_path / "f.npz", "depth.npy", data)
    with pytest.raises(InputError) as caught:
        read_frame(tmp_path / "f.npz")
    assert "f.npz" in caught.value.where
    (tmp_path / "d").mkdir()
    (tmp_path / "d" / "depth.npy").write_bytes(data)
    with pytest.raises(InputError):
        read_frame(tmp_path / "d")


def test_an_array_that_stands_twice(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "f.npz", "w") as archive:
        archive.writestr("depth", b"")
        archive.writestr("depth.npy", b"")
    with pytest.raises(InputError):
        read_frame(tmp_path / "f.npz")


def test_meta_that_is_no_object(tmp_path: Path) -> None:
    for text, what in (("{", "not JSON"), ("[1]", "not a JSON object"), ("[" * 10**5, "not JSON")):
        with pytest.raises(InputError, match=what):
            _read_saved(tmp_path, depth=np.zeros((1, 1)), meta=np.array(text))
    assert _read_saved(tmp_path, hit=np.eye(2), meta=np.array('{"a": 1}')).meta == {"a": "1"}


@pytest.mark.parametrize("name", ["f.npz", "f.exr", "f.d/hit.png", "f.d/depth.exr"])
def test_truncated_and_damaged_files(name: str, tmp_path: Path) -> None:
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
def test_exr_that_is_not_a_frame(bad: str, tmp_path: Path) -> None:
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
def test_folders_that_are_refused(names: list[str], what: str, tmp_path: Path) -> None:
    for name in names:
        kind = np.float32 if name.endswith(".exr") else np.uint8
        if name.endswith(".txt"):
            (tmp_path / name).write_text("notes")
        else:
            write_pixels(tmp_path / name, np.zeros((2, 2), kind))
    with pytest.raises(InputError, match=what) as caught:
        read_frame(tmp_path)
    assert str(tmp_path) in caught.value.where


def test_images_of_different_sizes_in_a_folder(tmp_path: Path) -> None:
    write_pixels(tmp_path / "hit.png", np.zeros((2, 2), np.uint8))
    write_pixels(tmp_path / "shadow.png", np.zeros((2, 3), np.uint8))
    with pytest.raises(InputError, match="wrong size"):
        read_frame(tmp_path)


def test_an_image_with_too_few_channels(tmp_path: Path) -> None:
    write_pixels(tmp_path / "normal.exr", np.zeros((2, 2, 2), np.float32))
    with pytest.raises(InputError, match="not have the quantity's channels"):
        read_frame(tmp_path)


def test_depth_of_three_different_channels(tmp_path: Path) -> None:
    write_pixels(tmp_path / "depth.exr", np.arange(3, dtype=np.float32).reshape(1, 1, 3))
    with pytest.raises(InputError, match="not have the quantity's channels"):
        read_frame(tmp_path)


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    subprocess.run(["/usr/bin/mkfifo", tmp_path / "hit.png"], check=True)
    with pytest.raises(InputError, match="no such file"):
        read_frame(tmp_path)


@pytest.mark.parametrize("name", ["none.npz", "none", "f.jpg", "f\0.npz", "x" * 400 + ".npz"])
def test_what_is_not_there(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError):
        read_frame(tmp_path / name)


# Paths that cannot be written


@pytest.mark.parametrize("name", ["f.jpg", "no/f.npz", "f\0.npz", "x" * 400 + ".npz", "taken.npz"])
def test_paths_that_cannot_be_written(name: str, tmp_path: Path) -> None:
    (tmp_path / "taken.npz").mkdir()
    with pytest.raises(InputError) as caught:
        write_frame(whole_frame(), tmp_path / name)
    assert caught.value.where
    assert [p.name for p in tmp_path.iterdir()] == ["taken.npz"]


def test_a_folder_of_other_things_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "hit.png").write_bytes(b"")
    (tmp_path / "thesis.txt").write_text("years of work")
    with pytest.raises(InputError, match="other files"):
        write_frame(whole_frame(), f"{tmp_path}/")
    assert (tmp_path / "thesis.txt").read_text() == "years of work"


def test_an_empty_frame_is_not_written(tmp_path: Path) -> None:
    for frame in (Frame({}), Frame({"hit": np.zeros((0, 3), bool)})):
        with pytest.raises(InputError, match="empty"):
            write_frame(frame, tmp_path / "f.exr")


@pytest.mark.parametrize(
    ("quantity", "suffix"),
    [("object", ".png"), ("normal", ".png"), ("barycentric", ".pfm"), ("depth", ".jpg")],
)
def test_formats_that_cannot_hold_a_quantity(quantity: str, suffix: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot hold"):
        write_image(whole_frame(), quantity, tmp_path / f"x{suffix}")
    with pytest.raises(InputError, match="cannot hold"):
        write_frame(whole_frame(), tmp_path / "f.d", images={quantity: suffix})
    assert not list(tmp_path.iterdir())


def test_wishes_that_make_no_sense(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown quantity"):
        write_frame(whole_frame(), tmp_path / "f.d", images={"dept": ".png"})
    with pytest.raises(InputError, match="for a folder"):
        write_frame(whole_frame(), tmp_path / "f.exr", images={"color": ".png"})
    with pytest.raises(InputError, match="does not have"):
        write_image(Frame({"hit": np.eye(2, dtype=bool)}), "color", tmp_path / "c.png")
