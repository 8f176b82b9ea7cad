"""FLIP beside colour: what it says of pictures that are the same, and of those that are not."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

import minirt
from minirt.frame import Frame
from minirt.vectors import Floats
from reference.compare.flip import FLIP_CEILING, flip_ceiling, flip_of


@pytest.fixture(scope="module")
def picture() -> Floats:
    whole = minirt.load_scene("atlas:everything")
    document = whole.to_dict()
    document["screen"] |= {"nx": 128, "ny": 96}
    small = minirt.load_scene(document, whole.folder)
    return np.asarray(minirt.render(small, quantities=["color"])["color"])


def flip(ours: Floats, theirs: Floats) -> float:
    mean = flip_of("color", Frame({"color": ours}), Frame({"color": theirs}))
    assert mean is not None
    return mean


def test_the_same_picture_does_not_flip(picture: Floats) -> None:
    assert flip(picture, picture) == 0
    assert flip(3 * picture, 5 * picture.clip(0.2)) < 1


def test_one_in_a_hundred_uncertain_pixels_stays_below_the_ceiling(picture: Floats) -> None:
    random = np.random.default_rng(1)
    wrong = random.random(picture.shape[:2]) < 0.008
    other = picture.copy()
    other[wrong] = 1 - np.round(other[wrong])
    assert wrong.sum() > 50
    assert 0.01 < flip(picture, other) < FLIP_CEILING


@pytest.mark.parametrize("share", [0.05, 0.1])
def test_the_ceiling_rises_with_the_share_of_uncertain_pixels(
    picture: Floats, share: float
) -> None:
    wrong = np.random.default_rng(2).random(picture.shape[:2]) < share
    other = picture.copy()
    other[wrong] = 1 - np.round(other[wrong])
    assert FLIP_CEILING < flip(picture, other) < flip_ceiling(float(wrong.mean()))
    assert flip_ceiling(0.0) == flip_ceiling(0.01) == FLIP_CEILING
    assert flip_ceiling(1.0) == 1.0


def test_a_picture_one_pixel_aside_is_above_the_ceiling(picture: Floats) -> None:
    assert flip(picture, np.roll(picture, 1, axis=1)) > FLIP_CEILING


def test_it_is_of_colours_and_only_where_it_is_installed(
    picture: Floats, monkeypatch: pytest.MonkeyPatch
) -> None:
    frame = Frame({"color": picture})
    assert flip_of("hit", frame, frame) is None
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert flip_of("color", frame, frame) is None
