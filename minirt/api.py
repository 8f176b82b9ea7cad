"""The lecture's procedures for any number of rays: RT, all hits, rayColor, and the kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from minirt import trace
from minirt.arguments import interval, nonzero, numbers, rays, shaped, vectors
from minirt.errors import InputError
from minirt.every_hit import every_hit
from minirt.hits import RayHits
from minirt.rays import Rays
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene
from minirt.shapes.plane import edge_normal, plane_t
from minirt.shapes.polygon import PolygonHits, fan, polygon_fault, polygon_hit, polygon_normal
from minirt.shapes.sphere import sphere_roots
from minirt.shapes.triangle import TriangleHits, triangle_hit
from minirt.vectors import Floats, Ints, put
from minirt.whitted import Whitted


@dataclass(frozen=True, eq=False)
class Hits:
    """What rays meet; scalars for a single ray, (n,) for n rays, (k, n) for all hits of n rays.

    Attributes
    ----------
    t : float64
        The parameter of S5; +inf for ∅.
    object, triangle : int32
        Number of the object in the scene, and of the face within it; −1 for ∅.
    beta, gamma : float64
        S9's weights; NaN on spheres and for ∅.
    position, normal : float64, (3,) or (3, n) or (3, k, n)
        Point and unit geometric normal on the outside, in modelling coordinates; NaN for ∅.
    """

    t: Floats
    object: Ints
    triangle: Ints
    beta: Floats
    gamma: Floats
    position: Floats
    normal: Floats


def RT(
    scene: Scene,
    P0: ArrayLike,
    d: ArrayLike,
    t0: float = 0.0,
    t1: float = np.inf,
    rules: Rules = SLIDES,
) -> Hits:
    """The first hit of each ray P0 + t·d with t in [t0, t1] and t > 0; ∅ is t = +inf.

    Parameters
    ----------
    scene : Scene
    P0, d : (3,) or (3, n) array_like
        Origins and directions, in modelling coordinates; d of any length but 0.
    t0, t1 : float
        0 ≤ t0 ≤ t1, in units of ‖d‖.
    rules : Rules, optional

    Returns
    -------
    Hits

    Raises
    ------
    InputError
        Not a loaded scene, shapes that do not fit, numbers that are not finite, d = 0, or an empty
        interval.

    Examples
    --------
    >>> import minirt
    >>> scene = minirt.load_scene("atlas:one-sphere")
    >>> hits = RT(scene, [0, 0, 5], [0, 0, -1])
    >>> float(hits.t), hits.normal.tolist()
    (4.0, [0.0, 0.0, 1.0])
    >>> float(RT(scene, [0, 0, 5], [0, 0, 1]).t)
    inf

    Source: S6.
    """
    interval(t0, t1)
    asked, single = rays(P0, d, t0, t1)
    whitted = Whitted(scene, rules)
    return _described(whitted, asked, trace.RT(whitted.world, asked), single)


def RT_all(
    scene: Scene,
    P0: ArrayLike,
    d: ArrayLike,
    t0: float = 0.0,
    t1: float = np.inf,
    rules: Rules = SLIDES,
) -> Hits:
    """ALL hits of each ray in [t0, t1], sorted by t: entry and exit of spheres, every face.

    Parameters
    ----------
    As `RT`.

    Returns
    -------
    Hits
        Arrays (k, n), or (k,) for a single ray: k is the largest number of hits of any ray, and
        rays with fewer end in ∅. (3, k, n) or (3, k) for points and normals.

    Examples
    --------
    >>> import minirt
    >>> RT_all(minirt.load_scene("atlas:one-sphere"), [0, 0, 5], [0, 0, -1]).t.tolist()
    [4.0, 6.0]

    Source: S4, S6.
    """
    interval(t0, t1)
    asked, single = rays(P0, d, t0, t1)
    whitted = Whitted(scene, rules)
    layers = every_hit(whitted.world, asked)
    k, n = layers.t.shape
    flat = RayHits(*(v.reshape(k * n) for v in vars(layers).values()))
    wide = Rays.of(np.tile(asked.origins, (1, k)), np.tile(asked.directions, (1, k)))
    described = _described(whitted, wide, flat, single=False)
    last = (k,) if single else (k, n)
    return Hits(*(v.reshape(*v.shape[:-1], *last) for v in vars(described).values()))


def ray_color(scene: Scene, P0: ArrayLike, d: ArrayLike, rules: Rules = SLIDES) -> Floats:
    """rayColor: the linear RGB that rays P0 + t·d bring.

    Parameters
    ----------
    scene : Scene
    P0, d : (3,) or (3, n) array_like
        Origins and directions; d of any length but 0.
    rules : Rules, optional

    Returns
    -------
    (3,) or (3, n) float64
        Not clamped; the background where nothing is met.

    Raises
    ------
    InputError
        As `RT`.

    Source: S7.
    """
    asked, single = rays(P0, d)
    whitted = Whitted(scene, rules)
    color: Floats = shaped(whitted.color(asked, whitted.first_hits(asked)), single)
    return color


class SphereHits(NamedTuple):
    """Both roots of S8 and the smallest one in the interval; +inf where there is none."""

    t: Floats
    near: Floats
    far: Floats


def intersect_sphere(
    P0: ArrayLike, d: ArrayLike, center: ArrayLike, radius: ArrayLike,
    t0: float = 0.0, t1: float = np.inf,
) -> SphereHits:  # fmt: skip
    """S8's kernel: rays against a sphere, or against one sphere each.

    Parameters
    ----------
    P0, d : (3,) or (3, n) array_like
    center : (3,) or (3, n) array_like
    radius : float or (n,) array_like, > 0
    t0, t1 : float
        The interval of S6.

    Returns
    -------
    SphereHits
        Each (n,) float64, or a scalar for a single ray: `t` is the smallest positive root in the
        interval, `near` ≤ `far` are both roots, of either sign.

    Raises
    ------
    InputError

    Examples
    --------
    >>> intersect_sphere([0, 0, 5], [0, 0, -1], [0, 0, 0], 1.0).t.item()
    4.0

    Source: S8, E8.
    """
    interval(t0, t1)
    (origins, directions, C), single = vectors(P0=P0, d=d, center=center)
    nonzero(d=d)
    R = numbers(radius, "radius", origins.shape[1])
    if not (R > 0).all():
        raise InputError("a radius must be positive", where="radius")
    near, far = sphere_roots(origins, directions, C, R)
    accept = SLIDES.in_interval
    t = SLIDES.smallest_root(near, far, accept(near, t0, t1), accept(far, t0, t1))
    return SphereHits(*(shaped(v, single and np.ndim(radius) == 0) for v in (t, near, far)))


def intersect_triangle(
    P0: ArrayLike, d: ArrayLike, a: ArrayLike, b: ArrayLike, c: ArrayLike
) -> TriangleHits:
    """S9's kernel: solves P0 + t·d = (1−β−γ)a + βb + γc and says which case it is.

    Parameters
    ----------
    P0, d, a, b, c : (3,) or (3, n) array_like

    Returns
    -------
    TriangleHits
        t, beta, gamma (n,) float64 and case (n,) int32, or scalars for single vectors. The case
        is a `TriangleCase`: INSIDE (β, γ, 1−β−γ ∈ [0, 1]), OUTSIDE (the plane is met elsewhere),
        NONE (parallel ray or degenerate triangle; t = +inf, β = γ = NaN). t is of either sign:
        t < 0 lies behind the observer.

    Raises
    ------
    InputError

    Examples
    --------
    >>> from minirt.shapes.triangle import TriangleCase
    >>> hit = intersect_triangle([0.25, 0.25, 1], [0, 0, -1], [0, 0, 0], [1, 0, 0], [0, 1, 0])
    >>> hit.t.item(), hit.beta.item(), hit.gamma.item(), TriangleCase(int(hit.case)).name
    (1.0, 0.25, 0.25, 'INSIDE')
    >>> TriangleCase.NONE.value
    2

    Source: S9, E3.
    """
    (origins, directions, a_, b_, c_), single = vectors(P0=P0, d=d, a=a, b=b, c=c)
    nonzero(d=d)
    found = triangle_hit(origins, directions, a_, b_, c_, edge_normal(a_, b_, c_))
    return TriangleHits(*(shaped(v, single) for v in found))


def intersect_polygon(P0: ArrayLike, d: ArrayLike, vertices: ArrayLike) -> PolygonHits:
    """S10 and S11's kernel: rays against one convex planar polygon.

    Parameters
    ----------
    P0, d : (3,) or (3, n) array_like
    vertices : (m, 3) array_like
        In order, m ≥ 3.

    Returns
    -------
    PolygonHits
        t (+inf outside), triangle of the fan (−1 outside), beta, gamma; (n,) or scalars.
        t is of either sign.

    Raises
    ------
    InputError
        Also for a polygon that is not planar or not convex.

    Source: S10, S11, E7.
    """
    (origins, directions), single = vectors(P0=P0, d=d)
    nonzero(d=d)
    P = np.asarray(vertices, dtype=np.float64)
    if P.ndim != 2 or P.shape[1] != 3 or len(P) < 3 or not np.isfinite(P).all():
        raise InputError(
            "not a polygon",
            where="vertices",
            got=f"shape {P.shape}",
            expected="(m, 3), m ≥ 3: a corner a row",
        )
    a, b, c = P[fan(len(P))].transpose(1, 2, 0)
    normals = edge_normal(a, b, c)
    fault = polygon_fault(P, normals)
    if fault:
        raise InputError(fault, where="vertices")
    p = polygon_normal(normals)
    found = polygon_hit(origins, directions, (a, b, c), normals, p, plane_t, triangle_hit)
    return PolygonHits(*(shaped(v, single) for v in found))


def _described(whitted: Whitted, rays: Rays, found: RayHits, single: bool) -> Hits:
    points = whitted.points(rays, found)
    position, normal = np.full((2, 3, rays.count), np.nan)
    put(position, points.rays, points.M)
    put(normal, points.rays, points.normal)
    values = (*vars(found).values(), position, normal)
    return Hits(*(shaped(v, single) for v in values))
