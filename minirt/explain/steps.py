"""One step of an explanation, and the helpers that turn a single ray's arrays into its values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from minirt.hits import RayHits
from minirt.vectors import Floats
from minirt.whitted import Whitted

Value: TypeAlias = bool | int | float | str | tuple[float, ...] | None


@dataclass(frozen=True)
class Step:
    """One step of the algorithm.

    Attributes
    ----------
    rule : str
        S1–S16.
    title : str
        What the step finds, in a few words.
    sentence : str
        What happened, with the number that matters.
    values : mapping of str to number, vector, text or None
        Lengths in scene units, angles in degrees; under a quantity's name, that quantity.
    """

    rule: str
    title: str
    sentence: str
    values: Mapping[str, Value]


def number(values: Floats) -> float:
    """The only value of an array with one element, as a float."""
    return float(values.reshape(-1)[0])


def vector(values: Floats) -> tuple[float, ...]:
    """The only column of an array (3, 1), as three floats."""
    return tuple(float(x) for x in values.reshape(3, -1)[:, 0])


def named(whitted: Whitted, hits: RayHits) -> str:
    """The object that a single ray meets, in words; "nothing" for none."""
    index = int(hits.object[0])
    if index < 0:
        return "nothing"
    thing = whitted.scene.objects[index]
    face = "" if thing.type in ("sphere", "triangle") else f", triangle {int(hits.triangle[0])}"
    return f"object {index} '{thing.name}' ({thing.type}{face})"


def length_in_words(length: float) -> str:
    """The length of d in words, with every digit where it is close to 1 but not 1.

    Examples
    --------
    >>> length_in_words(1.0), length_in_words(2.5)
    ('of length 1', 'of length 2.5')
    >>> length_in_words(1.0000030369427582)
    'not normalised: length 1.0000030369427582'
    """
    if length == 1 or f"{length:.6g}" != "1":
        return f"of length {length:.6g}"
    return f"not normalised: length {length!r}"


def plain(value: Any) -> Any:
    """A value as JSON data: tuples as lists, numbers that are not finite as text."""
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, tuple):
        return [plain(each) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value
