"""A contact sheet: every quantity of a frame in one picture, each with its legend."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from minirt.frame import Array, Frame, has_numbers
from minirt.quantities import QUANTITIES
from minirt.vectors import Bools
from reports.page.colors import CATEGORIES, HATCH, MASK_WORDS, MASKS, NOTHING, viridis
from reports.page.pictures import Span, channels, span_of, value_png
from reports.results.words import number

_COLUMNS, _MARGIN, _HEAD, _FOOT = 4, 16, 24, 22
_PAPER, _INK, _SOFT = (255, 255, 255), (24, 28, 34), (92, 99, 109)
#: Least and most columns of pixels of one picture: small ones are enlarged by a whole number.
_LEAST, _MOST = 256, 512


def write_sheet(frame: Frame, certain: Bools, title: str, path: Path) -> None:
    """Write a PNG of every quantity, and of where a float64 renderer can be judged.

    Parameters
    ----------
    frame : Frame
    certain : (ny, nx) bool
    title : str
    path : Path
    """
    pictures = [*(_picture(name, frame[name]) for name in frame), _mask(certain)]
    width, height = (max(side) for side in zip(*(p.size for _, p, _ in pictures), strict=True))
    rows = -(-len(pictures) // _COLUMNS)
    cell = width + _MARGIN, height + _HEAD + _FOOT + _MARGIN
    sheet = Image.new(
        "RGB", (_COLUMNS * cell[0] + _MARGIN, rows * cell[1] + 2 * _HEAD + _MARGIN), _PAPER
    )
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(15)
    draw.text((_MARGIN, _MARGIN), title, _INK, ImageFont.load_default(20))
    for k, (name, picture, legend) in enumerate(pictures):
        x = _MARGIN + k % _COLUMNS * cell[0]
        y = 2 * _HEAD + _MARGIN // 2 + k // _COLUMNS * cell[1]
        draw.text((x, y), name, _INK, font)
        sheet.paste(picture, (x, y + _HEAD))
        legend_at = (x, y + _HEAD + picture.height + 4)
        sheet.paste(_legend(legend, width), legend_at)
    sheet.save(path, "PNG", optimize=True)


#: A legend: swatches with words; or a colour scale with the two ends' numbers.
Legend = list[tuple[tuple[int, ...], str]] | tuple[str, str] | str


def _picture(name: str, values: Array) -> tuple[str, Image.Image, Legend]:
    quantity = QUANTITIES[name]
    scaled = not quantity.discrete and name not in MASKS
    span = span_of(values) if scaled else Span(np.zeros(1), np.ones(1))
    if name == "color":
        span = Span(np.zeros(3), np.ones(3))
    if values.ndim == 3:
        given = has_numbers(values)[..., None]
        image = Image.fromarray(np.where(given, channels(name, values, span), NOTHING))
    else:
        image = Image.open(io.BytesIO(value_png(name, values, span))).convert("RGB")
    return name, _enlarged(image), _legend_of(name, values, span)


def _legend_of(name: str, values: Array, span: Span) -> Legend:
    if name in MASKS:
        words = zip(MASKS[name], MASK_WORDS[name], strict=True)
        return [(tuple(color.tolist()), word) for color, word in words if word]
    if QUANTITIES[name].discrete:
        nothing = [(tuple(NOTHING.tolist()), "none")]
        return nothing + [(tuple(CATEGORIES[k].tolist()), f"{k}") for k in range(4)]
    if values.ndim == 2:
        high = number(float(span.high[0]))
        return number(float(span.low[0])), f"≥ {high}" if span.clipped else high
    if name == "color":
        return "sRGB, clipped to 0…1"
    if QUANTITIES[name].kind == "direction":
        return "x, y, z from -1 to 1 as red, green, blue"
    if name == "barycentric":
        return "beta, gamma, the rest as red, green, blue"
    return "x, y, z from least to largest as red, green, blue"


def _mask(certain: Bools) -> tuple[str, Image.Image, Legend]:
    colors = np.stack((HATCH[0], NOTHING))
    words = zip((NOTHING, HATCH[0]), ("certain", "uncertain, not judged"), strict=True)
    legend: Legend = [(tuple(color.tolist()), word) for color, word in words]
    return "certain for float64", _enlarged(Image.fromarray(colors[certain.astype(int)])), legend


def _enlarged(image: Image.Image) -> Image.Image:
    """Small pictures by a whole number; large ones one pixel in n × n, none mixed."""
    factor = max(1, _LEAST // max(image.size))
    image = image.resize((image.width * factor, image.height * factor), Image.Resampling.NEAREST)
    step = -(-max(image.size) // _MOST)
    return Image.fromarray(np.asarray(image)[step // 2 :: step, step // 2 :: step])


def _legend(legend: Legend, width: int) -> Image.Image:
    strip = Image.new("RGB", (width, _FOOT), _PAPER)
    draw, font = ImageDraw.Draw(strip), ImageFont.load_default(11)
    if isinstance(legend, str):
        draw.text((0, 2), legend, _SOFT, font)
    elif isinstance(legend, tuple):
        scale = Image.fromarray(np.tile(viridis(100)[None], (10, 1, 1)))
        draw.text((0, 2), legend[0], _SOFT, font)
        x = int(draw.textlength(legend[0], font)) + 6
        strip.paste(scale, (x, 5))
        draw.text((x + 106, 2), legend[1], _SOFT, font)
    else:
        x = 0
        for color, word in legend:
            draw.rectangle((x, 5, x + 10, 15), color, _SOFT)
            draw.text((x + 13, 2), word, _SOFT, font)
            x += 13 + int(draw.textlength(word, font)) + 6
    return strip
