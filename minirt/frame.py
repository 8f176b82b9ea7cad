"""A frame: the quantities of one image."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from minirt.errors import InputError, NotInFrame
from minirt.quantities import QUANTITIES

Array = NDArray[Any]


def planes(array: Array) -> list[Array]:
    """The components of an image (ny, nx) or (ny, nx, k), as arrays (ny, nx)."""
    return [array] if array.ndim == 2 else [array[..., k] for k in range(array.shape[2])]


def has_numbers(array: Array) -> NDArray[np.bool_]:
    """Where all components of an image (ny, nx) or (ny, nx, k) are finite, as a mask (ny, nx)."""
    numbers: NDArray[np.bool_] = np.logical_and.reduce([*map(np.isfinite, planes(array))])
    return numbers


@dataclass(frozen=True, eq=False, repr=False)
class Frame(Mapping[str, Array]):
    """Quantities of one image, by name; any subset of the table in `minirt.quantities`.

    Attributes
    ----------
    arrays : dict of str to array
        (ny, nx) or (ny, nx, k), of the table's dtypes, row 0 at the top.
    meta : dict of str to str
        ``scene``, ``sceneSha256``, ``version``; empty where unknown.

    Raises
    ------
    InputError
        A name that the table does not have, or a wrong type or shape.

    Examples
    --------
    >>> Frame({"hit": np.zeros((3, 4), dtype=bool)})
    <Frame 4 × 3: hit>
    """

    arrays: dict[str, Array]
    meta: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        sides = set()
        for name, array in self.arrays.items():
            quantity = QUANTITIES.get(name)
            if quantity is None:
                raise InputError(
                    "unknown quantity", got=repr(name)[:80], expected=", ".join(QUANTITIES)
                )
            if array.ndim < 2 or array.shape != quantity.shape(*array.shape[:2]):
                raise InputError(
                    "wrong shape",
                    where=name,
                    got=str(array.shape),
                    expected=str(quantity.shape(0, 0)).replace("(0, 0", "(ny, nx"),
                )
            if array.dtype != np.dtype(quantity.dtype):
                raise InputError(
                    "wrong type", where=name, got=str(array.dtype), expected=quantity.dtype
                )
            sides.add(array.shape[:2])
        if len(sides) > 1:
            raise InputError("quantities of different sizes in one frame", got=str(sorted(sides)))

    def __getitem__(self, name: str) -> Array:
        if name not in self.arrays:
            held = ", ".join(self.arrays) or "nothing"
            raise NotInFrame(f"not in this frame; it holds {held}", where=str(name)[:80])
        return self.arrays[name]

    def __contains__(self, name: object) -> bool:
        return name in self.arrays

    def __repr__(self) -> str:
        ny, nx = self.size
        return f"<Frame {nx} × {ny}: {', '.join(self.arrays) or 'nothing'}>"

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def __len__(self) -> int:
        return len(self.arrays)

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns, (ny, nx); (0, 0) for a frame without quantities."""
        for array in self.arrays.values():
            return array.shape[0], array.shape[1]
        return 0, 0
