"""Checks of the arguments of public functions: numbers and vectors, as any array-like."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from minirt.errors import InputError
from minirt.rays import Rays
from minirt.scene_file.schema import LARGEST, SMALLEST
from minirt.vectors import Floats


def vectors(**named: ArrayLike) -> tuple[list[Floats], bool]:
    """Vectors as arrays (3, n) with one common n, and whether all of them were single.

    Parameters
    ----------
    named : array-likes (3,) or (3, n)
        By the argument's name, for errors. A single vector is repeated n times.

    Raises
    ------
    InputError
        Not numbers, wrong shapes, different counts, or numbers that are not finite.
    """
    arrays = {name: _array(value, name) for name, value in named.items()}
    for name, array in arrays.items():
        if array.ndim not in (1, 2) or array.shape[0] != 3:
            raise InputError(
                "not a vector",
                where=name,
                got=f"shape {array.shape}",
                expected="components first: (3,) or (3, n)",
            )
        if not (np.abs(array) <= LARGEST).all():
            raise InputError(
                "a number is not finite or out of range",
                where=name,
                expected=f"within ±{LARGEST:g}",
            )
    single = all(array.ndim == 1 for array in arrays.values())
    counts = {a.shape[1] for a in arrays.values() if a.ndim == 2}
    if len(counts - {1}) > 1:
        raise InputError("different numbers of vectors", got=str(sorted(counts)))
    n = min(counts) if counts == {0} else max(counts | {1})
    return [np.broadcast_to(a.reshape(3, -1), (3, n)) for a in arrays.values()], single


def nonzero(**named: ArrayLike) -> None:
    """Refuse vectors (3,) or (3, n) that are zero, or so short that their squares would be.

    Raises
    ------
    InputError
        One of them is; the message names the argument.
    """
    for name, value in named.items():
        largest = float(np.abs(_array(value, name)).max(axis=0).min(initial=np.inf))
        if largest == 0:
            raise InputError("a direction is the zero vector", where=name)
        if largest < SMALLEST:
            raise InputError(
                "a direction is too short",
                where=name,
                got=f"components up to {largest:g}",
                expected=f"one of at least {SMALLEST:g}",
            )


def rays(P0: ArrayLike, d: ArrayLike, t0: float = 0.0, t1: float = np.inf) -> tuple[Rays, bool]:
    """Rays of origins and directions (3,) or (3, n), and whether it was a single ray.

    A vector that is given once is shared by all rays.

    Parameters
    ----------
    P0, d : array-likes (3,) or (3, n)
    t0, t1 : float
        The interval of t, 0 ≤ t0 ≤ t1.

    Raises
    ------
    InputError
        Not vectors, or a direction that is zero.
    """
    (origins, directions), single = vectors(P0=P0, d=d)
    nonzero(d=d)
    count = origins.shape[1]
    if count and np.size(P0) == 3:
        origins = origins[:, :1]
    if count and np.size(d) == 3:
        directions = directions[:, :1]
    return Rays.of(origins, directions, t0, t1), single


def numbers(value: ArrayLike, name: str, n: int) -> Floats:
    """One number, or one for each ray, as (n,) float64.

    Parameters
    ----------
    value : float or array-like (n,)
    name : str
        The argument's, for errors.
    n : int
        How many rays there are.

    Raises
    ------
    InputError
        Not a number, not as many as rays, or not finite.
    """
    array = _array(value, name)
    if array.ndim > 1 or array.size not in (1, n):
        raise InputError(
            "neither one number nor one for each ray", where=name, got=f"shape {array.shape}"
        )
    if not np.isfinite(array).all():
        raise InputError("a number is not finite", where=name)
    return np.broadcast_to(array.reshape(-1), (n,))


def interval(t0: float, t1: float) -> None:
    """Check the interval [t0, t1] of S6.

    Raises
    ------
    InputError
        Not 0 ≤ t0 ≤ t1.
    """
    try:
        fits = 0 <= t0 <= t1
    except TypeError:
        fits = False
    if not fits:
        raise InputError(
            "not an interval of a ray", where="t0, t1", got=f"[{t0}, {t1}]", expected="0 ≤ t0 ≤ t1"
        )


def shaped(value: NDArray[Any], single: bool) -> Any:
    """A result (..., n), without its last axis for a single ray."""
    return value[..., 0] if single else value


def _array(value: Any, name: str) -> Floats:
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("not numbers", where=name, got=repr(value)[:80]) from None
