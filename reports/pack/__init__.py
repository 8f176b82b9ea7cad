"""Packs: reference images that say what confirms them, and that prove themselves again."""

from enum import StrEnum


class Only(StrEnum):
    """Which scenes of a pack are approved anew."""

    failing = "failing"
    missing = "missing"
    all = "all"
