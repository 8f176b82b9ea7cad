"""Pictures of quantities: arrays in, small PNG files out."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import lru_cache, reduce

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from converters.frames.srgb import srgb_codes
from minirt.frame import Array, has_numbers, planes
from minirt.quantities import QUANTITIES
from minirt.vectors import Bools, Floats
from reports.page.colors import (
    BANDS,
    CATEGORIES,
    HATCH,
    MASKS,
    NOTHING,
    RING,
    SOURCES,
    Bytes,
    band_of,
    viridis,
)

#: Steps of a picture of lengths: fine enough for the eye, and they compress.
_LEVELS = 64
#: Colours of a picture of vectors or of light.
_COLORS = 250
#: A picture's side per pixel of width of the line around wrong pixels, which stays clear of them.
_SIDES_PER_LINE = 100


@dataclass(frozen=True)
class Span:
    """The values that the ends of a colour scale stand for.

    Attributes
    ----------
    low, high : (k,) float64
        By component.
    clipped : bool
        Whether values beyond `high` occur: far outliers must not darken all the rest.
    """

    low: Floats
    high: Floats
    clipped: bool = False


#: The scale of what needs none.
_UNIT = Span(np.zeros(1), np.ones(1))


def span_of(*arrays: Array) -> Span:
    """A common scale for several arrays (ny, nx) or (ny, nx, k); values of no number left out."""
    components = [np.stack([plane.ravel() for plane in planes(a)]) for a in arrays]
    columns = np.concatenate(components, axis=1)
    finite = columns[:, np.isfinite(columns).all(axis=0)].astype(np.float64)
    if not finite.size:
        return Span(np.zeros(len(finite)), np.ones(len(finite)))
    low, high = finite.min(axis=1), finite.max(axis=1)
    usual = np.percentile(finite, 98, axis=1)
    clipped = bool((high - low > 4 * (usual - low)).any() and (usual > low).all())
    return Span(low, usual if clipped else high, clipped)


def picture_span(name: str, ours: Array, theirs: Array) -> Span:
    """The scale of a quantity's pictures; 0…1 where its values need none."""
    return span_of(ours, theirs) if has_scale(name) or name == "position" else _UNIT


def has_scale(name: str) -> bool:
    """Whether a quantity's picture needs a scale with numbers."""
    quantity = QUANTITIES[name]
    return not quantity.discrete and quantity.components == 1


def shrink_factor(nx: int, ny: int, largest: tuple[int, int]) -> int:
    """The least whole number that brings an image within the sides."""
    return max(1, -(-nx // largest[0]), -(-ny // largest[1]))


def shrunk(array: Array, factor: int) -> Array:
    """Every factor-th pixel, each a pixel of the original: none are averaged."""
    rows, columns = (
        np.minimum(np.arange(0, side, factor) + factor // 2, side - 1) for side in array.shape[:2]
    )
    return array[np.ix_(rows, columns)]


def value_png(name: str, values: Array, span: Span) -> bytes:
    """A picture of one quantity.

    Parameters
    ----------
    name : str
    values : (ny, nx) or (ny, nx, k) array
        Of the quantity's own type.
    span : Span
        The scale, for lengths and positions; not used by the others.
    """
    if name in MASKS:
        return _indexed(np.clip(values, -1, 1).astype(np.int64) + 1, MASKS[name])
    if QUANTITIES[name].discrete:
        colors = np.concatenate((CATEGORIES, NOTHING[None]))
        return _indexed(np.where(values < 0, len(CATEGORIES), values % len(CATEGORIES)), colors)
    if values.ndim == 2:
        return _scalar(values, span)
    return _rgb(channels(name, values, span), has_numbers(values))


def ratio_png(ratio: Floats, factor: int = 1) -> bytes:
    """A picture of error over tolerance in bands; wrong pixels outlined, uncertain ones hatched.

    A pixel of the picture shows the worst of the factor × factor pixels that it stands for, so
    that one wrong pixel shows however small the picture is.

    Parameters
    ----------
    ratio : (ny, nx) float64
        NaN where uncertain.
    factor : int
    """
    unjudged = np.isnan(ratio)
    worst = _pooled(np.where(unjudged, 0.0, ratio), factor)
    wrong = worst > 1
    uncertain = _pooled(unjudged, factor) & ~wrong
    index = band_of(worst)
    rows, columns = np.indices(index.shape)
    stripes = len(BANDS) + (rows + columns) // 2 % 2
    index = np.where(uncertain, stripes, index)
    index = np.where(_outline(wrong), len(BANDS) + len(HATCH), index)
    return _indexed(index, np.concatenate((BANDS, HATCH, RING)))


def agreement_png(agree: NDArray[np.int64], differ: Bools, factor: int = 1) -> bytes:
    """A picture of how many sources confirm each pixel; where one differs, outlined.

    A pixel of the picture shows the fewest of the factor × factor pixels that it stands for.

    Parameters
    ----------
    agree : (ny, nx) int64
        Sources that judged the pixel and agree with minirt.
    differ : (ny, nx) bool
    factor : int
    """
    most = len(SOURCES) - 1
    fewest = -_pooled(-np.minimum(agree, most), factor)
    index = np.where(_outline(_pooled(differ, factor)), len(SOURCES), fewest)
    return _indexed(index, np.concatenate((SOURCES, RING)))


def _pooled(array: Array, factor: int) -> Array:
    """The largest of each factor × factor block, the last ones of a row or column maybe smaller."""
    for axis, side in enumerate(array.shape):
        first = np.arange(0, side, factor)
        each = (np.minimum(first + k, side - 1) for k in range(min(factor, side)))
        array = reduce(np.maximum, (array.take(some, axis=axis) for some in each))
    return array


def _outline(wrong: Bools) -> Bools:
    line = max(1, max(wrong.shape) // _SIDES_PER_LINE)
    return _dilated(wrong, 3 * line) & ~_dilated(wrong, 2 * line)


def _dilated(mask: Bools, radius: int) -> Bools:
    """A mask (ny, nx) and all within `radius` columns and rows of it."""
    grown = mask.copy()
    for axis in (0, 1):
        before = grown.copy()
        for step in range(1, radius + 1):
            ahead = [slice(None), slice(None)]
            behind = [slice(None), slice(None)]
            ahead[axis], behind[axis] = slice(step, None), slice(None, -step)
            grown[tuple(ahead)] |= before[tuple(behind)]
            grown[tuple(behind)] |= before[tuple(ahead)]
    return grown


def _scalar(values: Array, span: Span) -> bytes:
    width = float(span.high[0] - span.low[0]) or 1.0
    finite = np.isfinite(values)
    level = np.where(finite, np.where(finite, values, 0.0) - span.low[0], 0.0) / width
    index = np.clip(np.rint(level * (_LEVELS - 1)), 0, _LEVELS - 1).astype(np.int64)
    colors = np.concatenate((viridis(_LEVELS), NOTHING[None]))
    return _indexed(np.where(finite, index, _LEVELS), colors)


def channels(name: str, values: Array, span: Span) -> Bytes:
    """Vectors (ny, nx, k) as sRGB codes (ny, nx, 3); a span is needed for positions only."""
    if name == "color":
        return srgb_codes(values)
    if name == "barycentric":
        share = np.concatenate((values, 1 - values.sum(axis=2, keepdims=True)), axis=2)
    elif QUANTITIES[name].kind == "direction":
        share = (values + 1) / 2
    else:
        width = np.where(span.high > span.low, span.high - span.low, 1.0)
        share = (values - span.low) / width
    clipped = np.clip(np.nan_to_num(share, nan=0.0, posinf=1.0, neginf=0.0), 0, 1)
    codes: Bytes = np.rint(clipped * 255).astype(np.uint8)
    return codes


def _rgb(codes: Bytes, given: Bools) -> bytes:
    """Colours (ny, nx, 3), reduced to few; where none is given, the colour of nothing."""
    index = np.full(given.shape, _COLORS)
    colors = np.tile(NOTHING, (_COLORS + 1, 1))
    if given.any():
        strip = Image.fromarray(codes[given][None])
        few = strip.quantize(_COLORS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        found = np.array(few.getpalette(), dtype=np.uint8).reshape(-1, 3)[:_COLORS]
        colors[: len(found)] = found
        index[given] = np.asarray(few)[0]
    return _indexed(index, colors)


def _indexed(index: NDArray[np.integer], colors: Bytes) -> bytes:
    small = index.astype(np.uint8)
    return _png(small.shape[1], small.shape[0], small.tobytes(), colors.tobytes())


@lru_cache(maxsize=64)
def _png(width: int, height: int, index: bytes, colors: bytes) -> bytes:
    """A PNG file; many pictures of one scene are equal, as where references give one answer."""
    image = Image.frombytes("P", (width, height), index)
    image.putpalette(colors)
    stream = io.BytesIO()
    image.save(stream, "PNG", optimize=True)
    return stream.getvalue()
