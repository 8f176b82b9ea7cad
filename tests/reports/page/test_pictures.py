from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import minirt
from minirt.quantities import QUANTITIES
from reports.page.colors import (
    BANDS,
    BOUNDS,
    HATCH,
    NOTHING,
    RING,
    SOURCES,
    band_of,
    palette,
    viridis,
)
from reports.page.pictures import (
    agreement_png,
    ratio_png,
    shrink_factor,
    shrunk,
    span_of,
    value_png,
)
from reports.page.thumbnails import SMALL
from tests.helpers.fake_references import NX, NY, small_scene


def pixels(png: bytes) -> NDArray[np.uint8]:
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))


def is_color(image: NDArray[np.uint8], color: Any) -> NDArray[np.bool_]:
    return np.asarray((image == np.asarray(color)).all(axis=-1))


def lightness(colors: NDArray[np.uint8]) -> NDArray[np.float64]:
    """CIE L* of sRGB colours (n, 3)."""
    code = colors / 255
    linear = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
    Y = linear @ [0.2126, 0.7152, 0.0722]
    return np.where(Y > 0.008856, 116 * np.cbrt(Y) - 16, 903.3 * Y)


@pytest.mark.parametrize("name", list(QUANTITIES))
def test_every_quantity_has_a_picture_of_its_size(name: str) -> None:
    values = minirt.render(small_scene())[name]
    png = value_png(name, values, span_of(values))
    assert pixels(png).shape == (NY, NX, 3)
    assert png == value_png(name, values, span_of(values))


@pytest.mark.parametrize(
    "name", [n for n in QUANTITIES if n not in ("ray", "color", "alpha", "hit")]
)
def test_pixels_without_a_value_have_a_colour_of_their_own(name: str) -> None:
    values = minirt.render(small_scene())[name]
    values[0, 0] = QUANTITIES[name].miss
    none = is_color(pixels(value_png(name, values, span_of(values))), NOTHING)
    flat = values.reshape(NY, NX, -1)
    no_value = flat[..., 0] < 0 if QUANTITIES[name].discrete else ~np.isfinite(flat).all(axis=2)
    assert none[0, 0]
    assert (none == no_value).all()


@pytest.mark.parametrize("where", [(0, 0), (767, 1023), (400, 511), (1, 1022)])
def test_one_wrong_pixel_shows_on_a_thumbnail(where: tuple[int, int]) -> None:
    ratio = np.full((768, 1024), 0.3)
    ratio[where] = 3.0
    factor = shrink_factor(1024, 768, SMALL)
    image = pixels(ratio_png(ratio, factor))
    assert image.shape[:2] == (96, 128)
    row, column = where[0] // factor, where[1] // factor
    assert is_color(image, BANDS[6]).sum() == 1
    assert is_color(image, BANDS[6])[row, column]
    ring = np.argwhere(is_color(image, RING[0]))
    assert len(ring) >= 7
    assert np.abs(ring - (row, column)).max() == 3


def test_no_wrong_pixel_no_line_and_no_orange() -> None:
    image = pixels(ratio_png(np.linspace(0, 1, 400).reshape(20, 20)))
    assert not is_color(image, RING[0]).any()
    assert sum(is_color(image, band).sum() for band in BANDS[:5]) == 400


def test_uncertain_pixels_are_hatched_and_hide_no_wrong_one() -> None:
    ratio = np.full((64, 64), np.nan)
    ratio[10, 10] = np.inf
    image = pixels(ratio_png(ratio, 2))
    assert is_color(image, BANDS[-1])[5, 5]
    stripes = [is_color(image, color).sum() for color in HATCH]
    assert min(stripes) > 300
    assert sum(stripes) + is_color(image, RING[0]).sum() + 1 == 32 * 32


def test_bands_change_exactly_at_their_bounds() -> None:
    for k, bound in enumerate(BOUNDS):
        assert band_of(np.array(bound)) == k
        assert band_of(np.array(np.nextafter(bound, np.inf))) == k + 1
    assert band_of(np.array(np.inf)) == len(BANDS) - 1


def test_maps_grow_lighter_all_the_way() -> None:
    steps = np.diff(lightness(BANDS))
    assert (steps > 9.5).all()
    assert steps[4] == steps.max() > 13.5
    assert (np.diff(lightness(viridis(64))) > 0).all()


def test_shrunk_picture_holds_only_pixels_of_the_original() -> None:
    values = np.arange(7 * 11, dtype=np.int32).reshape(7, 11)
    small = shrunk(values, 3)
    assert small.shape == (3, 4)
    assert np.isin(small, values).all()
    assert pixels(ratio_png(np.zeros((7, 11)), 3)).shape[:2] == small.shape


def test_far_outliers_do_not_darken_the_rest() -> None:
    values = np.ones((10, 100))
    values[:, 1:] = np.linspace(1, 2, 99)
    values[0, 0] = 1e6
    span = span_of(values)
    assert span.clipped
    assert span.high[0] < 2.1
    assert not span_of(values[:, 1:]).clipped


def test_scale_is_common_to_both_and_survives_nothing() -> None:
    span = span_of(np.array([[1.0, np.inf]]), np.array([[3.0, np.nan]]))
    assert (span.low[0], span.high[0]) == (1.0, 3.0)
    empty = span_of(np.full((2, 2), np.inf))
    image = pixels(value_png("t", np.full((2, 2), np.inf), empty))
    assert is_color(image, NOTHING).all()


def test_palette_reads_hexadecimal() -> None:
    assert palette("ff8000", "000001").tolist() == [[255, 128, 0], [0, 0, 1]]


def test_a_map_of_agreement_shows_the_least_confirmed_and_every_dissent() -> None:
    agree, differ = np.full((96, 128), 5), np.zeros((96, 128), dtype=np.bool_)
    agree[51, 70] = 2
    differ[20, 30] = True
    small = pixels(agreement_png(agree, differ, 2))
    assert small.shape == (48, 64, 3)
    assert is_color(small, SOURCES[2]).sum() == 1
    assert is_color(small, SOURCES[2])[25, 35]
    ring = is_color(small, RING[0])
    assert ring.any()
    assert not ring[10, 15]
    rows, columns = np.nonzero(ring)
    assert (abs(rows - 10) <= 3).all()
    assert (abs(columns - 15) <= 3).all()
    assert (np.diff(lightness(SOURCES)) > 8).all()
