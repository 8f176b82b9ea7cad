"""Which types and values of a file are accepted, and which of a frame can be written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from converters.frames.io import read_frame, write_frame, write_image
from minirt.errors import InputError
from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from tests.helpers.frame_files import Array, whole_frame


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
def test_values_that_fit_exactly_are_accepted(name: str, values: Array, tmp_path: Path) -> None:
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
def test_arrays_that_do_not_fit_are_refused(
    name: str, values: Array, what: str, tmp_path: Path
) -> None:
    np.savez(tmp_path / "f.npz", allow_pickle=False, **{name: values})
    with pytest.raises(InputError, match=what) as caught:
        read_frame(tmp_path / "f.npz")
    assert caught.value.where.startswith(str(tmp_path / "f.npz"))
    assert caught.value.got


def test_nan_is_accepted(tmp_path: Path) -> None:
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


@pytest.mark.parametrize("name", ["f.jpg", "no/f.npz", "f\0.npz", "x" * 400 + ".npz", "taken.npz"])
def test_a_path_that_cannot_be_written_is_refused(name: str, tmp_path: Path) -> None:
    (tmp_path / "taken.npz").mkdir()
    with pytest.raises(InputError) as caught:
        write_frame(whole_frame(), tmp_path / name)
    assert caught.value.where
    assert [p.name for p in tmp_path.iterdir()] == ["taken.npz"]


def test_a_folder_with_other_files_is_not_replaced(tmp_path: Path) -> None:
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
def test_a_format_that_cannot_hold_a_quantity_is_refused(
    quantity: str, suffix: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="cannot hold"):
        write_image(whole_frame(), quantity, tmp_path / f"x{suffix}")
    with pytest.raises(InputError, match="cannot hold"):
        write_frame(whole_frame(), tmp_path / "f.d", images={quantity: suffix})
    assert not list(tmp_path.iterdir())


def test_requested_formats_that_make_no_sense_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown quantity"):
        write_frame(whole_frame(), tmp_path / "f.d", images={"dept": ".png"})
    with pytest.raises(InputError, match="for a folder"):
        write_frame(whole_frame(), tmp_path / "f.exr", images={"color": ".png"})
    with pytest.raises(InputError, match="does not have"):
        write_image(Frame({"hit": np.eye(2, dtype=bool)}), "color", tmp_path / "c.png")
