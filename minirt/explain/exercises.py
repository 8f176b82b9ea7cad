"""S17: the lecture's three exercises, new ones of the same kinds, and the marking of answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import sqrt
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from minirt.errors import InputError
from minirt.explain.exercise_kinds import Exercise, Reflection, TangentDirection, TangentSphere

#: The lecture's own three, by number.
EXERCISES: tuple[Exercise, ...] = (
    TangentDirection((1, 5, 4), (2, 2, 4), sqrt(2), (1, -1, 0)),
    TangentSphere((3, 2, -1), (1, 2, 1), (1, -1, 1), 1),
    Reflection((3, 2, 1), (0, 1, -1)),
)


def generated(seed: int) -> tuple[Exercise, ...]:
    """Three new exercises of the same kinds, whose solutions have small whole numbers.

    Parameters
    ----------
    seed : int
        At least 0; the same seed gives the same exercises.

    Examples
    --------
    >>> generated(1)[2].answer
    {'direction': [3.0, 0.4, 2.8]}
    """
    random = np.random.default_rng(seed)
    P0, d, w, t = _draw(random)
    first = TangentDirection(P0, _sum(P0, t, d, w), float(np.linalg.norm(w)), d)
    P0, d, w, t = _draw(random)
    second = TangentSphere(P0, d, w, t)
    while True:
        delta, normal = random.integers(-3, 4, 3), random.integers(-2, 3, 3)
        if normal.any() and np.dot(delta, normal) and np.cross(delta, normal).any():
            return first, second, Reflection(_ints(delta), _ints(normal))


def checked(exercises: Sequence[Exercise], answers: Mapping[str, Any]) -> dict[str, str | None]:
    """What is wrong with each answer, by the exercise's number: empty if right, None if absent.

    Parameters
    ----------
    exercises : sequence of Exercise
        Numbered from 1.
    answers : mapping of str to mapping
        By the exercise's number, each in the form of its `Exercise.answer`.

    Raises
    ------
    InputError
        An answer to no exercise, or not in the form of one.

    Examples
    --------
    >>> checked(EXERCISES, {"3": {"direction": [3, 1, 2]}})
    {'1': None, '2': None, '3': ''}
    """
    known = {str(k): each for k, each in enumerate(exercises, start=1)}
    strange = [name for name in answers if name not in known]
    if strange:
        raise InputError(
            "an answer to no exercise", got=repr(strange[0])[:80], expected=", ".join(known)
        )
    return {number: _verdict(each, answers.get(number), number) for number, each in known.items()}


def _verdict(exercise: Exercise, given: Any, number: str) -> str | None:
    if given is None:
        return None
    if not isinstance(given, Mapping):
        form = ", ".join(exercise.answer)
        raise InputError(
            "not an answer", where=number, got=repr(given)[:80], expected=f"an object: {form}"
        )
    try:
        return exercise.check(given)
    except InputError as error:
        raise InputError(
            error.what, where=f"{number}: {error.where}", got=error.got, expected=error.expected
        ) from None


#: P0, d, w and t of `_draw`.
_Drawn: TypeAlias = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...], float]


def _draw(random: np.random.Generator) -> _Drawn:
    """P0 and d of a ray, a vector w perpendicular to it, and a t > 0; all small whole numbers."""
    while True:
        d, other = random.integers(-2, 3, 3), random.integers(-2, 3, 3)
        w = np.cross(d, other)
        if w.any():
            w = w // np.gcd.reduce(np.abs(w))
            P0, t = random.integers(-5, 6, 3), int(random.integers(1, 4))
            return _ints(P0), _ints(d), _ints(w), t


def _sum(
    P0: Sequence[float], t: float, d: Sequence[float], w: Sequence[float]
) -> tuple[float, ...]:
    return tuple(p + t * x + y for p, x, y in zip(P0, d, w, strict=True))


def _ints(values: NDArray[np.int64]) -> tuple[float, ...]:
    return tuple(int(value) for value in values)
