"""S14–S16: reflection and refraction, and where the slides' letter fails (E1, E2, E6)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import minirt
from minirt.errors import InputError
from minirt.optics import refracted_direction
from minirt.vectors import Floats, dot, norm, unit

ULP = 2.0**-52
#: Error of a unit vector built from a handful of roundings of numbers up to 1: 16 of half an ulp.
ROUNDING = 8 * ULP

_component = st.floats(-10, 10, allow_nan=False).map(lambda x: round(x, 6))
_vector = st.tuples(_component, _component, _component).filter(lambda v: max(map(abs, v)) > 0.01)
_index = st.floats(0.2, 5.0, allow_nan=False)


def _letter(delta: Floats, s: Floats, nu: float, nu_t: float) -> Floats:
    """S16's formula as printed, with whatever s."""
    cosine, ratio = dot(delta, s), nu / nu_t
    return ratio * delta + (np.sqrt(1 - ratio**2 * (1 - cosine**2)) - ratio * cosine) * s


def _random(n: int) -> tuple[Floats, Floats]:
    """Directions, and unit normals on the incident side: δ·s < 0."""
    rng = np.random.default_rng(50)
    delta, s = unit(rng.normal(size=(3, n))), unit(rng.normal(size=(3, n)))
    return delta, np.where(dot(delta, s) > 0, -s, s)


def test_E1_slide_letter_sends_ray_back() -> None:
    """With s on the incident side, as drawn, the printed formula leaves on that side again."""
    delta, s = _random(1000)
    printed = _letter(delta, s, 1.0, 1.5)
    assert (dot(printed, s) > 0).all()
    ours = minirt.refract(delta, s, 1.0, 1.5)
    assert (dot(ours, s) < 0).all()
    # With s turned along δ the same formula is right.
    nu, nu_t = np.array([1.0]), np.array([1.5])
    assert np.array_equal(_letter(delta, -s, 1.0, 1.5), refracted_direction(delta, s, nu, nu_t))


def test_E2_no_refracted_ray_beyond_the_critical_angle() -> None:
    """From 1.5 into 1 the radicand is negative where sin θ > 1/1.5."""
    angles = np.linspace(0.01, np.pi / 2 - 0.01, 500)
    delta = np.stack((np.sin(angles), -np.cos(angles), np.zeros(500)))
    through = minirt.refract(delta, [0, 1, 0], 1.5, 1.0)
    total = np.isnan(through).all(axis=0)
    assert np.array_equal(total, np.sin(angles) > 1 / 1.5)
    assert 0 < total.sum() < 500
    assert not np.isnan(through[:, ~total]).any()
    assert not np.isnan(minirt.refract(delta, [0, 1, 0], 1.0, 1.5)).any()


def test_E6_the_projection_of_delta_on_the_normal_is_plus_delta_s_s() -> None:
    """δ minus its projection is perpendicular to s; with the slide's (−δ·s)s it is not."""
    delta, s = _random(1000)
    projection = dot(delta, s) * s
    assert np.abs(dot(delta - projection, s)).max() <= ROUNDING
    assert np.abs(dot(delta - (-projection), s)).max() > 1
    assert minirt.reflect(delta, s) == pytest.approx(delta - 2 * projection, abs=ROUNDING)


@settings(max_examples=200, deadline=None)
@given(_vector, _vector)
def test_S14_reflection_keeps_length_plane_and_angle(delta: Any, s: Any) -> None:
    rho, d, n = minirt.reflect(delta, s), np.array(delta), unit(np.array(s))
    size = float(norm(d))
    assert norm(rho) == pytest.approx(size, rel=ROUNDING)
    assert dot(rho, n) == pytest.approx(-dot(d, n), abs=ROUNDING * size)
    assert abs(dot(np.cross(d, n), rho)) <= 2 * ROUNDING * size**2
    assert minirt.reflect(rho, s) == pytest.approx(d, abs=2 * ROUNDING * size)
    assert np.array_equal(minirt.reflect(delta, -np.array(s)), rho)


@settings(max_examples=200, deadline=None)
@given(_vector, _vector, _index, _index)
def test_S15_S16_refraction_obeys_snell(delta: Any, s: Any, nu: float, nu_t: float) -> None:
    through, d, n = minirt.refract(delta, s, nu, nu_t), np.array(delta), unit(np.array(s))
    size, ratio = float(norm(d)), nu / nu_t
    sine = float(norm(np.cross(d, n))) / size
    # 1 − (ν/ν_t)² sin² θ: its error, a few roundings of (ν/ν_t)² ≤ 625, decides near zero.
    error = ROUNDING * (1 + ratio**2)
    if np.isnan(through).any():
        assert np.isnan(through).all()
        assert 1 - (ratio * sine) ** 2 <= error
        return
    assert 1 - (ratio * sine) ** 2 >= -error
    bent = float(norm(np.cross(through, n))) / size
    assert nu * sine == pytest.approx(nu_t * bent, abs=nu_t * error)
    assert norm(through) == pytest.approx(size, rel=error)
    assert abs(dot(np.cross(d, n), through)) <= size**2 * error
    assert dot(through, n) * dot(d, n) >= -error * size**2
    if abs(dot(d, n)) > 0:  # else the ray runs in the surface and either side is along it
        assert np.array_equal(minirt.refract(delta, -np.array(s), nu, nu_t), through)


def test_S16_refraction_is_reversible() -> None:
    delta, s = _random(1000)
    through = minirt.refract(delta, s, 1.0, 1.5)
    # Leaving the denser medium multiplies an error of its cosine, ≥ √(1 − 1/1.5²) = 0.745, by 1.5²
    # over the cosine that comes out.
    back = -minirt.refract(-through, s, 1.5, 1.0)
    cosine = np.abs(dot(delta, s))
    assert (cosine * np.abs(back - delta).max(axis=0)).max() <= 4 * ROUNDING


def test_S16_equal_indices_leave_the_ray_as_it_is() -> None:
    delta, s = _random(100)
    # √(1 − (1 − x²)) − x: the root's argument errs by an ulp, the root by that over 2x.
    moved = np.abs(minirt.refract(delta, s, 1.3, 1.3) - delta).max(axis=0)
    assert (moved * np.abs(dot(delta, s))).max() <= ROUNDING


@pytest.mark.parametrize(
    ("delta", "s", "nu", "shape"),
    [
        ((3,), (3,), (), (3,)),
        ((3, 7), (3,), (), (3, 7)),
        ((3,), (3, 7), (), (3, 7)),
        ((3, 7), (3, 7), (7,), (3, 7)),
        ((3,), (3,), (7,), (3, 7)),
        ((3, 0), (3,), (), (3, 0)),
        ((3, 1), (3,), (), (3, 1)),
    ],
)
def test_S16_shapes(
    delta: tuple[int, ...], s: tuple[int, ...], nu: tuple[int, ...], shape: tuple[int, ...]
) -> None:
    assert minirt.refract(np.ones(delta), np.ones(s), np.ones(nu), 1.5).shape == shape
    if not nu:
        assert minirt.reflect(np.ones(delta), np.ones(s)).shape == shape


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([1, 2], [1, 0, 0], 1, 1), "delta: not a vector"),
        (([0, 0, 0], [1, 0, 0], 1, 1), "delta: a direction is the zero vector"),
        (([1, 0, 0], [0, 0, 0], 1, 1), "s: a direction is the zero vector"),
        (([1, 0, 0], [0, np.inf, 0], 1, 1), "s: a number is not finite"),
        (([1, 0, 0], [1, 0, 0], 0, 1), "nu, nu_t: an index of refraction must be positive"),
        (([1, 0, 0], [1, 0, 0], 1, -1), "nu, nu_t: an index of refraction must be positive"),
        (([1, 0, 0], [1, 0, 0], np.nan, 1), "nu: a number is not finite"),
        (([1, 0, 0], [1, 0, 0], [1, 2], [1, 2, 3]), "nu_t: neither one number nor one for each"),
        (([[1, 2], [0, 0], [0, 0]], [1, 0, 0], [1, 1, 1], 1), "nu: neither one number nor"),
        ((np.ones((3, 2)), np.ones((3, 3)), 1, 1), "different numbers of vectors"),
    ],
)  # fmt: skip
def test_S16_bad_arguments_are_one_clear_error(arguments: tuple[Any, ...], words: str) -> None:
    with pytest.raises(InputError) as caught:
        minirt.refract(*arguments)
    assert str(caught.value).startswith(words)


def test_S14_S16_directions_of_any_length_keep_it() -> None:
    delta, s = _random(50)
    assert norm(minirt.reflect(7.0 * delta, 3.0 * s)) == pytest.approx(7.0, rel=ROUNDING)
    assert norm(minirt.refract(7.0 * delta, 3.0 * s, 1.0, 1.5)) == pytest.approx(7.0, rel=ROUNDING)


def test_S15_indices_are_swapped_on_leaving() -> None:
    nu, nu_t = minirt.SLIDES.indices(np.array([1.5, 1.5]), np.array([False, True]))
    assert nu.tolist() == [1.0, 1.5]
    assert nu_t.tolist() == [1.5, 1.0]
