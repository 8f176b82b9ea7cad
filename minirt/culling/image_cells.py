"""The pixels of an image in cells, so that those traced together are neighbours.

Cells that can show none of a few objects are left out: otherwise one sphere takes 1.6 × as long,
and ten 1.9 × (rows '1 sphere' and '10 spheres' of the bench).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from minirt.culling.bounding_tests import PAD
from minirt.culling.cell_bounds import CellRays
from minirt.culling.index import SceneIndex
from minirt.rays import Rays
from minirt.vectors import Bools, Index

#: Pixels along the side of the squares that are traced together, a multiple of `CELL`: bounds the
#: working memory whatever the image's size.
SIDE = 256
#: Pixels along the side of a cell.
CELL = 8
#: Primitives of a kind, at most, that cells are tested against.
_MOST = 32
#: Cells that are tested at once, in whole rows.
_CELLS = 8_192


def squares(nx: int, ny: int) -> Iterator[Index]:
    """The pixels of an image in square tiles, cell by cell: (n,) intp."""
    for row, column in cells(nx, ny, SIDE, SIDE):
        yield pixels_of(row, column, nx, ny)


def visible_pixels(
    index: SceneIndex, nx: int, ny: int, rays_of: Callable[[Index], Rays]
) -> Iterator[tuple[Index, int]]:
    """Yield (pixels, done): those that may show something, and how many are dealt with then.

    Parameters
    ----------
    index : SceneIndex
    nx, ny : int
        Of the image.
    rays_of : callable
        The lecture's own rays, which leave one point, of pixels (n,).
    """
    done = 0
    if any(kind.count > _MOST for kind in index.kinds):
        for pixels in squares(nx, ny):
            done += len(pixels)
            yield pixels, done
        return
    height = max(1, _CELLS * CELL // nx) * CELL
    for row, column in cells(nx, ny, height, nx):
        some = np.flatnonzero(_may_show(index, nx, ny, row, column, rays_of))
        pixels = pixels_of(row[some], column[some], nx, ny)
        parts = np.array_split(pixels, max(1, round(len(pixels) / SIDE**2)))
        for part in parts[:-1]:
            yield part, done
        done = nx * min(ny, int(row[-1]) + CELL)
        yield parts[-1], done


def _may_show(
    index: SceneIndex, nx: int, ny: int, row: Index, column: Index,
    rays_of: Callable[[Index], Rays],
) -> Bools:  # fmt: skip
    """Whether any pixel of cells (c,) may show an object.

    Each number of a direction grows with its pixel's row or falls, and so with its column,
    rounding included: between those of a cell's corners lie those of all its rays.
    """
    rows = np.minimum(row + np.array([[0], [0], [CELL - 1], [CELL - 1]]), ny - 1)
    columns = np.minimum(column + np.array([[0], [CELL - 1], [0], [CELL - 1]]), nx - 1)
    corners = rays_of((rows * nx + columns).ravel())
    d = corners.directions.reshape(3, 4, len(row))
    cell = CellRays(corners.P0, d.min(axis=1), d.max(axis=1))
    found = np.zeros(len(row), dtype=np.bool_)
    for kind in index.kinds:
        pad = PAD * max(kind.tree.reach, float(np.abs(corners.P0).max()))
        found |= kind.met_by(cell, pad).any(axis=0)
    return found


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
