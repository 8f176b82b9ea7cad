"""The pixels of an image in squares, so that those traced together are neighbours."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from minirt.vectors import Index

#: Pixels along the side of the squares that are traced together, a multiple of `CELL`: bounds the
#: working memory whatever the image's size.
SIDE = 256
#: Pixels along the side of a cell.
CELL = 8


def squares(nx: int, ny: int) -> Iterator[Index]:
    """The pixels of an image in square tiles, cell by cell: (n,) intp."""
    for row, column in cells(nx, ny, SIDE, SIDE):
        yield pixels_of(row, column, nx, ny)


def cells(nx: int, ny: int, height: int, width: int) -> Iterator[tuple[Index, Index]]:
    """The cells of an image, tile by tile: the first row and column of each, (c,) intp.

    Height and width of a tile are multiples of `CELL`.
    """
    for top in range(0, ny, height):
        for left in range(0, nx, width):
            row = np.arange(top, min(top + height, ny), CELL)
            column = np.arange(left, min(left + width, nx), CELL)
            yield np.repeat(row, len(column)), np.tile(column, len(row))


def pixels_of(row: Index, column: Index, nx: int, ny: int) -> Index:
    """The pixels of cells by their first rows and columns (c,), each in the order of a Z: (n,)."""
    pixels = (row * nx + column)[:, None] + (_ROW * nx + _COLUMN)
    if nx % CELL == 0 and ny % CELL == 0:
        return pixels.ravel()
    within = (row[:, None] + _ROW < ny) & (column[:, None] + _COLUMN < nx)
    return pixels[within]


def _z_order() -> tuple[Index, Index]:
    """Rows and columns (64,) of a cell's pixels in the order of a Z, and so its parts."""
    number = np.arange(CELL * CELL)
    row, column = np.zeros_like(number), np.zeros_like(number)
    for bit in range(3):
        column |= (number >> 2 * bit & 1) << bit
        row |= (number >> 2 * bit + 1 & 1) << bit
    return row, column


_ROW, _COLUMN = _z_order()
