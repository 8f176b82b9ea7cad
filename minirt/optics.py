"""S14–S16: reflection and refraction at a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from minirt.arguments import nonzero, numbers, shaped, vectors
from minirt.errors import InputError
from minirt.vectors import Bools, Floats, dot, norm


def reflected_direction(delta: Floats, s: Floats) -> Floats:
    """ρ = δ − 2(δ·s)s.

    (δ·s)s is the projection of δ on the normal; the slide's (−δ·s)s is that of −δ (E6).

    Parameters
    ----------
    delta : (3, n) float64
        Direction of propagation, of any length; ρ has the same.
    s : (3, n) float64
        Unit normal of either side.

    Source: S14, E6.
    """
    return delta - 2.0 * dot(delta, s) * s


def refractive_indices(ior: Floats, leaving: Bools) -> tuple[Floats, Floats]:
    """ν of the medium the ray comes from and ν_t of the one it goes to: ν sin θ = ν_t sin φ.

    Parameters
    ----------
    ior : (n,) float64
        The object's index relative to its outside, whose index is 1.
    leaving : (n,) bool
        Whether the ray comes from the object's inside.

    Source: S15.
    """
    return np.where(leaving, ior, 1.0), np.where(leaving, 1.0, ior)


def refracted_direction(delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
    """ϱ = (ν/ν_t)δ + [√(1 − ν²(1−(δ·s)²)/ν_t²) − (ν/ν_t)(δ·s)] s, with s turned along δ.

    The slide draws s on the incident side. With that s the printed formula sends the ray back
    where it came from (E1): √… is the cosine of the refracted ray with s, so s must point the
    way the ray goes. And the slide assumes ν_t > ν; otherwise the radicand can be negative,
    which is total internal reflection: there is no refracted ray (E2).

    Parameters
    ----------
    delta, s : (3, n) float64
        Unit direction of propagation, and unit normal of either side.
    nu, nu_t : (n,) float64
        Indices before and behind the surface.

    Returns
    -------
    (3, n) float64
        Unit; NaN columns at total internal reflection.

    Source: S16, E1, E2.
    """
    cosine = dot(delta, s)
    s = np.where(cosine <= 0, -s, s)
    cosine = np.abs(cosine)
    ratio = nu / nu_t
    radicand = 1.0 - ratio * ratio * (1.0 - cosine * cosine)
    total = radicand < 0
    root = np.sqrt(np.where(total, 0.0, radicand))
    return np.where(total, np.nan, ratio * delta + (root - ratio * cosine) * s)


def reflect(delta: ArrayLike, s: ArrayLike) -> Floats:
    """Reflect directions at a surface.

    Parameters
    ----------
    delta : (3,) or (3, n) array_like
        Directions of propagation, of any length but 0.
    s : (3,) or (3, n) array_like
        Normals, of either side and any length but 0.

    Returns
    -------
    (3,) or (3, n) float64
        ρ, of the same length as `delta`.

    Raises
    ------
    InputError
        Shapes that do not fit, zero vectors or numbers that are not finite.

    Examples
    --------
    Exercise 3 of the lecture: (3, 2, 1) at the normal (0, √2/2, −√2/2).

    >>> reflect([3, 2, 1], [0, 1, -1]).round(12).tolist()
    [3.0, 1.0, 2.0]

    Source: S14.
    """
    (delta_, s_), single = vectors(delta=delta, s=s)
    nonzero(delta=delta, s=s)
    result: Floats = shaped(reflected_direction(delta_, s_ / norm(s_)), single)
    return result


def refract(delta: ArrayLike, s: ArrayLike, nu: ArrayLike, nu_t: ArrayLike) -> Floats:
    """Refract directions at a surface between two media.

    Parameters
    ----------
    delta : (3,) or (3, n) array_like
        Directions of propagation, of any length but 0.
    s : (3,) or (3, n) array_like
        Normals, of either side and any length but 0.
    nu, nu_t : float or (n,) array_like
        Refractive index of the medium the ray comes from, and of the one it goes to; > 0.

    Returns
    -------
    (3,) or (3, n) float64
        ϱ, of the same length as `delta`; NaN at total internal reflection.

    Raises
    ------
    InputError
        Shapes that do not fit, zero vectors, indices that are not positive and finite.

    Examples
    --------
    >>> refract([0, -1, 0], [0, 1, 0], 1.0, 1.5).tolist()
    [0.0, -1.0, 0.0]
    >>> refract([3, -1, 0], [0, 1, 0], 1.5, 1.0).tolist()
    [nan, nan, nan]

    Source: S16, E1, E2.
    """
    (delta_, s_), single = vectors(delta=delta, s=s)
    nonzero(delta=delta, s=s)
    n = next((k for k in (delta_.shape[1], np.size(nu), np.size(nu_t)) if k != 1), 1)
    indices = [numbers(nu, "nu", n), numbers(nu_t, "nu_t", n)]
    if not all((index > 0).all() for index in indices):
        raise InputError("an index of refraction must be positive", where="nu, nu_t")
    length = norm(delta_)
    columns = [np.broadcast_to(v, (3, n)) for v in (delta_ / length, s_ / norm(s_))]
    single = single and np.ndim(nu) == 0 and np.ndim(nu_t) == 0
    result: Floats = shaped(length * refracted_direction(*columns, *indices), single)
    return result
