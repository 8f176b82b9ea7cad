"""Frames that are written come back, with bounded memory."""

from __future__ import annotations

import hashlib
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
from PIL import Image

from converters.frames.folder import META_FILE
from converters.frames.io import read_frame, write_frame
from minirt.frame import Frame
from minirt.quantities import QUANTITIES, Quantity
from tests.helpers.frame_files import KINDS, META, Array, assert_same, whole_frame


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


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize("name", KINDS[:3])
def test_any_frame_is_read_as_it_was_written(name: str) -> None:
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
def test_the_same_frame_gives_the_same_bytes(name: str, tmp_path: Path) -> None:
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


def test_a_folder_has_colours_as_a_picture_and_as_numbers(tmp_path: Path) -> None:
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
