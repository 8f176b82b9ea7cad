"""S9 where float64 cannot decide: rays through an edge or a vertex, triangles seen edge-on."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from minirt.shapes.compensated import pair_cross, pair_dot, two_difference
from minirt.shapes.plane import steeper
from minirt.vectors import Bools, Floats, dot

#: Numbers of some ray–triangle pairs: one array for each axis of the pairs.
Pairs: TypeAlias = tuple[NDArray[np.intp], ...]

#: A ray meets a plane at a small angle where |d·N| is less than this share of ‖d‖‖N‖. Above it
#: plane_t errs by less than 4 · 2⁻⁵³ · 3 · 2⁸ < 2⁻⁴¹ of the distances in play, which is what the
#: culling's boxes allow for.
_GRAZING = 2.0**-8


def slack(P0: Floats, d: Floats, a: Floats, b: Floats, c: Floats) -> Floats:
    """An upper bound on the rounding error of the three volumes d·((B + C) × (b − c)).

    With S = |B| + |C| and Y = |b − c| the volume's error is at most 8 · 2⁻⁵³ Σ |dᵢ|(SⱼYₖ + SₖYⱼ):
    two roundings for S, one each for Y, the product, the difference and the last product, two for
    the sum. S is at most 2(max|P0| + r) and Y at most 2r', with r and r' the largest coordinates of
    the vertices and of an edge; so 64 · 2⁻⁵³ of the factors below, and 2⁻⁴⁶ covers their rounding.
    """
    reach = np.maximum(np.maximum(_largest(a), _largest(b)), _largest(c))
    edge = np.maximum(np.maximum(_largest(b - c), _largest(c - a)), _largest(a - b))
    size = np.abs(d[0]) + np.abs(d[1]) + np.abs(d[2])
    result: Floats = (_largest(P0) + reach) * (2.0**-46 * size * edge)
    return result


def edge_volumes(
    pairs: Pairs, P0: Floats, d: Floats, a: Floats, b: Floats, c: Floats
) -> tuple[Floats, Floats, Floats]:
    """2d·(C × B), 2d·(A × C), 2d·(B × A) of some pairs, with 106 bits.

    What is not above the rounding error is zero: the ray meets the edge itself.
    """
    P0, d, a, b, c = _chosen(pairs, P0, d, a, b, c)
    A, B, C = (two_difference(vertex, P0) for vertex in (a, b, c))
    exact_d = d, np.zeros_like(d)
    length = np.abs(d).sum(axis=0)
    volumes = []
    for x, y in ((C, B), (A, C), (B, A)):
        volume = 2.0 * pair_dot(exact_d, pair_cross(x, y))[0]
        noise = 2.0**-96 * length * _largest(x[0]) * _largest(y[0])
        volumes.append(np.where(np.abs(volume) <= noise, 0.0, volume))
    return volumes[0], volumes[1], volumes[2]


def edge_on_t(
    t: Floats, inside: Bools, weights: tuple[Floats, Floats, Floats],
    P0: Floats, d: Floats, a: Floats, b: Floats, c: Floats, N: Floats,
) -> Floats:  # fmt: skip
    """t, with a number for +inf where the ray, if not parallel, is too nearly so for float64.

    The number is the mean of the vertices' own t, by the weights.
    """
    infinite = np.isinf(t)
    if not infinite.any():
        return t
    total = weights[0] + weights[1] + weights[2]
    met = np.nonzero(inside & infinite & (total != 0) & (N != 0).any(axis=0))
    if not len(met[0]):
        return t
    ends = _ends(*_chosen(met, P0, d, a, b, c))
    shares = np.stack([weight[met] for weight in weights])
    result = t.copy()
    result[met] = (shares * ends).sum(axis=0) / total[met]
    return result


def within_span(
    t: Floats, inside: Bools, P0: Floats, d: Floats, a: Floats, b: Floats, c: Floats, N: Floats
) -> Floats:
    """t, brought to where the ray passes the triangle where it is met nearly edge-on.

    There the plane's t may err by more than the triangle is long. The point met lies in the
    triangle, so its t lies between the vertices' own, and while the ray is in the box around them.
    """
    slope = dot(d, N)
    if steeper(slope, _GRAZING, d, N):
        return t
    grazing = slope * slope < _GRAZING**2 * dot(d, d) * dot(N, N)
    pairs = np.nonzero(inside & grazing & np.isfinite(t))
    if not len(pairs[0]):
        return t
    some = _chosen(pairs, P0, d, a, b, c)
    ends = _ends(*some)
    enters, leaves = _in_box(*some)
    between = np.clip(t[pairs], ends.min(axis=0), ends.max(axis=0))
    result = t.copy()
    result[pairs] = np.maximum(np.minimum(between, leaves), enters)
    return result


def _in_box(P0: Floats, d: Floats, a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats]:
    """t (k,) at which lines enter and leave the box around three vertices; once if they miss it."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # along the box
        low = (np.minimum(np.minimum(a, b), c) - P0) / d
        high = (np.maximum(np.maximum(a, b), c) - P0) / d
    enters = np.fmax.reduce(np.fmin(low, high), axis=0)
    leaves = np.fmin.reduce(np.fmax(low, high), axis=0)
    return enters, np.maximum(enters, leaves)


def _ends(P0: Floats, d: Floats, a: Floats, b: Floats, c: Floats) -> Floats:
    """t of the points of the rays next to each vertex, (3, k)."""
    return np.stack([dot(vertex - P0, d) / dot(d, d) for vertex in (a, b, c)])


def _chosen(pairs: Pairs, *vectors: Floats) -> list[Floats]:
    """Each of the vectors, which broadcast against each other, of some pairs: (3, k)."""
    return [np.stack([axis[pairs] for axis in v]) for v in np.broadcast_arrays(*vectors)]


def _largest(v: Floats) -> Any:
    return np.maximum(np.maximum(np.abs(v[0]), np.abs(v[1])), np.abs(v[2]))
