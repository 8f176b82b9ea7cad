"""Arrays that go onto the page come back bit for bit, or say that they were rounded."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

import minirt
from minirt.frame import Array
from reports.page.inspector.packing import Packed, pack, pack_ratio
from tests.helpers.fake_references import small_scene

RNG = np.random.default_rng(20)
SIZE = (7, 11)


#: Bytes of a kind's numbers, and what they are.
KINDS = {"f8": (8, "<f8"), "f4": (4, "<f4"), "i4": (4, "<i4"), "i1": (1, "i1"), "b2": (2, "<u2")}


def unpacked(packed: Packed, ny: int, nx: int, other: Array | None = None) -> Array:
    """The array again, as the page's script makes it."""
    width, kind = KINDS[packed.kind]
    unsigned = np.dtype(f"<u{width}").type
    planes = np.frombuffer(zlib.decompress(packed.data), np.uint8).reshape(-1, width, ny * nx)
    parts = []
    for k, (subtracted, orders) in enumerate(packed.predictors):
        folded: Array = np.ascontiguousarray(planes[k].T).view(unsigned).reshape(ny, nx)
        bits = (folded >> unsigned(1)) ^ (unsigned(0) - (folded & unsigned(1)))
        for _ in range(orders):
            bits = np.cumsum(np.cumsum(bits, axis=0, dtype=unsigned), axis=1, dtype=unsigned)
        if subtracted:
            assert other is not None
            beside = other.reshape(ny, nx, -1)[..., k].astype(kind)
            bits = bits + np.ascontiguousarray(beside).view(unsigned)
        parts.append(bits)
    stacked: Array = np.stack(parts, axis=2)
    if packed.kind == "b2":
        halves: Array = (stacked.astype(np.uint32) << np.uint32(16)).view(np.float32)
        return halves[..., 0]
    values = stacked.view(kind)
    return values[..., 0] if packed.components == 1 else values


def same(a: Array, b: Array) -> bool:
    """The same numbers, the sign of a zero included; every NaN is the same."""
    floats = a.dtype.kind == "f"
    return bool(
        np.array_equal(a, b, equal_nan=floats)
        and (not floats or np.array_equal(np.signbit(a) & (a == 0), np.signbit(b) & (b == 0)))
    )


@pytest.mark.parametrize("dtype", ["bool", "int8", "int32", "float64"])
@pytest.mark.parametrize("components", [1, 3])
def test_any_bit_pattern_comes_back(dtype: str, components: int) -> None:
    shape = (*SIZE, components) if components > 1 else SIZE
    bits = RNG.integers(0, 2 if dtype == "bool" else 256, (*shape, np.dtype(dtype).itemsize))
    values = np.ascontiguousarray(bits.astype(np.uint8)).view(dtype)[..., 0]
    if dtype == "float64":
        values.flat[:4] = [np.inf, -np.inf, np.nan, -0.0]
    packed = pack(values)
    assert packed.exact
    assert same(unpacked(packed, *SIZE).astype(values.dtype), values)


def test_every_quantity_of_a_frame_comes_back_alone_and_beside_another() -> None:
    frame = minirt.render(small_scene())
    ny, nx = frame.size
    assert len(frame) > 15
    for name, values in frame.items():
        alone = pack(values)
        assert same(unpacked(alone, ny, nx).astype(values.dtype), values), name
        other = values.copy()
        other[5] = other[4]
        beside = pack(other, values)
        assert beside.exact
        assert same(unpacked(beside, ny, nx, values).astype(values.dtype), other), name


def test_what_is_almost_equal_takes_almost_no_room() -> None:
    values = RNG.random((64, 64))
    other = values.copy()
    other[3, 4] = np.nextafter(other[3, 4], 2)
    assert len(pack(other, values).data) < 100 < len(pack(values).data)
    assert pack(other, values).predictors == ((True, 0),)


def test_what_is_smooth_takes_little_room() -> None:
    row, column = np.indices((64, 64), dtype=np.float64)
    smooth = np.sqrt(2 + 0.001 * row + 0.002 * column)
    assert pack(smooth).predictors[0][1] > 1
    assert len(pack(smooth).data) < 64 * 64 * 8 / 3


def test_rounding_is_to_float32_and_said() -> None:
    third, half = np.full(SIZE, 1 / 3), np.full(SIZE, 0.5)
    assert not pack(third, rounded=True).exact
    assert unpacked(pack(third, rounded=True), *SIZE)[0, 0] == np.float32(1 / 3)
    assert pack(half).kind == "f4"
    assert pack(half).exact
    assert pack(third).kind == pack(third, half).kind == pack(half, third).kind == "f8"


def test_a_ratio_keeps_two_digits_its_sign_and_its_side_of_one() -> None:
    above = np.nextafter(1, 2)
    ratio = np.array([[0.0, 1.0, above, -above, np.inf, -np.inf, np.nan, 0.123, -45.6, 1e300]])
    back = unpacked(pack_ratio(ratio), 1, 10)[0].astype(float)
    assert back[:2].tolist() == [0, 1]
    assert 1 < back[2] < 1.01
    assert back[3] == -back[2]
    assert back[4:6].tolist() == [np.inf, -np.inf]
    assert np.isnan(back[6])
    assert back[7:9] == pytest.approx([0.123, -45.6], rel=0.01)
    assert np.isfinite(back[9])
    assert back[9] > 1e38
