"""Hashes of a frame's numbers, where they say anything about who computed them.

Two honest programs hardly share the last bits of many quantities in float64. They do share those
of a depth or a colour, and the right answer rounded to float32 nearly always: such numbers accuse
nobody.
"""

from __future__ import annotations

import hashlib

import numpy as np

from minirt.frame import Array, Frame
from minirt.quantities import QUANTITIES

#: So many quantities tell programs apart.
_ENOUGH = 6


def fingerprint(ours: Frame, theirs: Frame) -> tuple[str, bool]:
    """A hash of a frame's numbers, empty where they tell nothing; and whether they are minirt's.

    Parameters
    ----------
    ours, theirs : Frame
        `theirs` says who wrote it, if minirt did: numbers rounded to float32 are minirt's own
        only then.
    """
    names = [n for n in QUANTITIES if n in theirs and not QUANTITIES[n].discrete and n != "alpha"]
    if len(names) < _ENOUGH:
        return "", False
    numbers = _hash(theirs, names, np.float64)
    if _hash(theirs, names, np.float32) != numbers:
        return numbers, numbers == _hash(ours, names, np.float64)
    if numbers != _hash(ours, names, np.float32):
        return numbers, False
    signed = bool(theirs.meta.get("sceneSha256"))
    return numbers if signed else "", signed


def is_rounded(frame: Frame) -> bool:
    """Whether every number of a frame is one of float32, in whatever file it came."""
    numbers = [array for array in frame.arrays.values() if array.dtype == np.float64]
    return bool(numbers) and all(_is_rounded(array) for array in numbers)


def _is_rounded(array: Array) -> bool:
    with np.errstate(over="ignore"):
        same = array.astype(np.float32).astype(np.float64) == array
    return bool((same | np.isnan(array)).all())


def _hash(frame: Frame, names: list[str], step: type) -> str:
    digest = hashlib.sha256()
    for name in names:
        digest.update(name.encode() + b"\0" + _plain(frame[name], step).tobytes())
    return digest.hexdigest()[:32]


def _plain(values: Array, step: type) -> Array:
    """Without the bits that say nothing: signs of zeros, kinds of NaN, what a format dropped."""
    with np.errstate(over="ignore"):
        rounded = values.astype(step).astype(np.float64)
    return np.asarray(np.where(np.isnan(rounded), np.nan, rounded) + 0.0)
