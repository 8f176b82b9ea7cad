"""How far the exact answer itself moves under another renderer's declared error.

Each pixel is traced four times. Once as the lecture says; and three times with rays started the way
the other renderer starts them and every ray that is cast (primary, shadow, reflected, refracted)
moved sideways by 2·δ, in three directions perpendicular to it, a third of a turn apart. Their
triangle holds the circle of radius δ: a straight edge within δ of the ray is crossed by one of the
three, whatever its direction. What moves in proportion moves most at one of the triangle's corners,
the start's own part included: the largest of the three movements holds every movement within δ.
Where only first hits are asked for, it is the six corners of a hexagon, 2/√3·δ away: fewer pixels
are near an edge then. A ray that leaves a point is moved to the side that the point was moved to,
mirrored or turned as the ray is, so that the two add up; behind a second mirror they may not.

Where δ grows with the distance, primary rays are also tilted, to the same side. Facets are tilted
by what the rounding of their vertices can turn them, and the cosine of a refracted ray errs by the
rounding of its square. Where other surfaces lie within the error of the first (coplanar or touching
ones), the other renderer may well see any of them, and no answer is given that could agree.

A polygon whose vertices are off its plane adds to δ by how far they are: which plane is met there
is each renderer's own choice. A facet that the light grazes at an angle within which the vertices'
error can turn it may or may not shade itself: the traces never agree on that.

A discrete quantity is certain where all of them agree; a continuous one where the discrete answers
that lead to it are. There its tolerance is a base, from δ and the local geometry, plus κ times
the largest movement seen.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from minirt.frame import Array, Frame
from minirt.geometry import Geometry, Kind
from minirt.quantities import QUANTITIES
from minirt.render import (
    BEFORE_POINTS,
    SIGNATURE,
    Tile,
    blank_frame,
    chosen_quantities,
    fill,
    frame_meta,
    primary_directions,
    squares,
    tiles,
    trace_pixels,
)
from minirt.rules import SLIDES
from minirt.scene import Scene
from minirt.trace import Hits, nearest, nearest_two
from minirt.vectors import Bools, Floats, Index, Ints, column, cross, dot, norm, put, take, unit
from minirt.whitted import Points, Signature, Whitted
from reference.source import AlongRay, Declared, NormalOffset
from reference.surfaces import PerSurface, Surfaces, warp

#: Safety factor on the largest movement seen, which holds all that is in proportion to δ: margin
#: for the curvature of an answer, and for errors that do not go to the same side.
KAPPA = 2.0

#: By number of directions in which rays are moved, how far, in δ: a triangle, and a hexagon, of
#: that circumradius holds a circle of radius 1.
_STEP = {3: 2.0, 6: 2.0 / 3.0**0.5}

#: 1/slope up to which one trace tells whether other surfaces lie within the error of the first.
_STEEP = 16.0

#: Of no object, or of no face, and not nothing either: what is met where the other renderer may
#: well see another one. No exact answer equals it.
_CONTESTED = -2
_CONTESTED_PATH = np.uint64(0xC0)

#: Two vectors that few rays or edges are parallel to.
_ASKEW = column((0.48, 0.6, 0.64)), column((0.8, -0.64, 0.0))

#: Quantities whose agreement makes a quantity certain, beside itself where it is discrete.
_CHAIN: dict[str, tuple[str, ...]] = {
    "ray": (),
    "hit": (),
    "object": (),
    "triangle": ("object",),
    "t": ("object",),
    "depth": ("object",),
    "distance": ("object",),
    "position": ("object",),
    "barycentric": ("object", "triangle"),
    "normal": ("object", "triangle"),
    "shadow": ("object",),
    "reflection": ("object", "triangle"),
    "reflection_object": ("object", "triangle"),
    "reflection_t": ("object", "triangle", "reflection_object"),
    "tir": ("object", "triangle"),
    "refraction": ("object", "triangle", "tir"),
    "refraction_object": ("object", "triangle", "tir"),
    "refraction_t": ("object", "triangle", "tir", "refraction_object"),
    "color": ("object", "triangle", SIGNATURE),
    "alpha": ("object",),
}


@dataclass(frozen=True, eq=False)
class Stability:
    """Where a comparison may judge, and how strictly.

    Attributes
    ----------
    certain : dict of str to (ny, nx) bool
        By quantity that is judged: whether the exact answer is stable under the declared error.
    tolerance : dict of str to (ny, nx) float64
        By continuous quantity: largest allowed error, Euclidean for vectors, in its unit; 0 where
        it does not apply.
    """

    certain: dict[str, Bools]
    tolerance: dict[str, Floats]


@dataclass(frozen=True, eq=False)
class Exact:
    """minirt's own answer to a scene, once for all the errors it is measured against.

    Attributes
    ----------
    scene : Scene
    frame : Frame
        Every quantity, bit for bit what `minirt.render` gives.
    signature : (ny, nx) uint64
        Of each pixel's tree of rays: see `minirt.whitted.Whitted.color`.
    """

    scene: Scene
    frame: Frame
    signature: Array

    def tile(self, pixels: Index) -> Tile:
        """Some pixels' values, (n,) or (3, n), as `minirt.render.tiles` gives them."""
        tile: Tile = {SIGNATURE: self.signature.reshape(-1)[pixels]}
        for name, array in self.frame.items():
            flat = array.reshape(self.signature.size, -1).take(pixels, axis=0)
            tile[name] = flat[:, 0] if array.ndim == 2 else flat.T.copy()
        return tile


def exact_answer(scene: Scene) -> Exact:
    """Render every quantity of a scene, and the signature of each pixel."""
    arrays = blank_frame(scene)
    signature = np.zeros((scene.screen.ny, scene.screen.nx), dtype=np.uint64)
    for pixels, tile in tiles(Whitted(scene), {*arrays, SIGNATURE}):
        fill(arrays, pixels, tile)
        signature.reshape(-1)[pixels] = tile[SIGNATURE]
    return Exact(scene, Frame(arrays, frame_meta(scene)), signature)


def stability_of(
    exact: Exact, declared: Declared, quantities: Iterable[str] | None = None
) -> Stability:
    """How stable some quantities of a scene are under a declared error.

    Parameters
    ----------
    exact : Exact
    declared : Declared
    quantities : iterable of str, optional
        Those to be judged; all when left out.
    """
    scene, judged = exact.scene, chosen_quantities(quantities)
    geometry = Geometry.of(scene)
    declared = _with_warp(declared, warp(geometry))
    chain = _chain(judged, declared)
    links = {link for name in judged for link in chain[name]}
    surfaces = Surfaces.of(geometry, scene.extent)
    sink = _Sink(scene, chain)
    wanted = frozenset({*judged, *links})
    directions = 6 if wanted <= BEFORE_POINTS else 3
    sides = [(k, _STEP[directions]) for k in range(directions)]
    others = [Displaced(scene, declared, surfaces.levers, *side) for side in sides]
    for pixels in squares(scene.screen.nx, scene.screen.ny):
        tile, d = exact.tile(pixels), primary_directions(scene, SLIDES, pixels)
        around = perpendicular(d)
        moved = [other.tile(d, around, wanted) for other in others]
        sink.judge(pixels, tile, moved, _bases(tile, declared, geometry, surfaces))
    return Stability(sink.certain, sink.tolerance)


def _with_warp(declared: Declared, off_plane: float) -> Declared:
    """The error, where polygons are off their plane: whose plane is met is anybody's choice."""
    return replace(declared, delta=declared.delta + off_plane, vertex=declared.vertex + off_plane)


def measure(
    scene: Scene, declared: Declared, quantities: Iterable[str] | None = None
) -> tuple[Frame, Stability]:
    """A scene's whole frame, and how stable some quantities are: see `stability_of`."""
    exact = exact_answer(scene)
    return exact.frame, stability_of(exact, declared, quantities)


def _chain(judged: Iterable[str], declared: Declared) -> dict[str, tuple[str, ...]]:
    """By quantity, those that must agree to make it certain.

    Where facets that share an edge may leave a gap, all of them hang on which facet is met.
    """
    gaps = () if declared.watertight else ("object", "triangle")
    itself = {name: (name,) if QUANTITIES[name].discrete else () for name in judged}
    return {name: tuple(dict.fromkeys((*gaps, *_CHAIN[name], *itself[name]))) for name in judged}


class _Sink:
    """Gathers, tile by tile, which pixels are certain and what is tolerated there."""

    def __init__(self, scene: Scene, chain: dict[str, tuple[str, ...]]) -> None:
        size = (scene.screen.ny, scene.screen.nx)
        self.chain = chain
        self.certain = {name: np.zeros(size, dtype=np.bool_) for name in chain}
        self.tolerance = {name: np.zeros(size) for name in chain if not QUANTITIES[name].discrete}

    def judge(self, pixels: Index, tile: Tile, moved: list[Tile], bases: dict[str, Floats]) -> None:
        agree: dict[str, Bools] = {}

        def agreed(name: str) -> Bools:
            if name not in agree:
                same = [tile[name] == other[name] for other in moved]
                agree[name] = np.logical_and.reduce(same)
            return agree[name]

        for name, links in self.chain.items():
            stable = np.ones(len(pixels), dtype=np.bool_)
            for link in links:
                stable &= agreed(link)
            self.certain[name].reshape(-1)[pixels] = stable
            if name in self.tolerance:
                movement = _movement(tile[name], [other[name] for other in moved])
                allowed = bases[name] + KAPPA * movement
                self.tolerance[name].reshape(-1)[pixels] = allowed


class Displaced(Whitted):
    """The lecture's algorithm with every ray moved sideways by some δ, in direction k of six.

    Secondary rays start as another renderer starts them. What is met where surfaces of several
    objects lie within the error of the first is no object's.

    Parameters
    ----------
    scene : Scene
    declared : Declared
    levers : PerSurface
    k : int
        0…5: the direction around each ray.
    step : float
        How many δ.
    """

    def __init__(
        self, scene: Scene, declared: Declared, levers: PerSurface, k: int, step: float
    ) -> None:
        super().__init__(scene, replace(SLIDES, refract=self.refracted_direction))
        self.declared, self.levers, self.k = declared, levers, k
        self.sample, self.step, self.tilt = step, step * declared.delta, step * declared.slope

    def tile(self, d: Floats, around: tuple[Floats, Floats], wanted: frozenset[str]) -> Tile:
        """The wanted quantities of the pixels whose rays should go along d (3, n).

        `around` is `perpendicular` of d.
        """
        self._aside = turned(around, self.k)
        if self.tilt:
            d = d + self.tilt * norm(d) * self._aside
        self._faces_contested = np.zeros(d.shape[1], dtype=np.bool_)
        tile = trace_pixels(self, d, wanted)
        tile["hit"] = tile["t"] < np.inf
        tile["triangle"] = np.where(self._faces_contested, _CONTESTED, tile["triangle"])
        return tile

    def refracted_direction(self, delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
        """ϱ (3, n) with the square of its cosine a rounding larger, for odd k smaller.

        Whoever takes the root of 1 − η²(1 − cos²), η = ν/ν_t, rounds twice near 1: by u/2·(1 + η²)
        in all, where a unit vector's error is 4·u or more. Where ϱ grazes the surface, that turns
        it by much more than anything else does, even from one side to the other of the same index.
        """
        exact = SLIDES.refract(delta, s, nu, nu_t)
        cosine = dot(exact, s)
        rounding = self.declared.angle / 8.0 * (1.0 + (nu / nu_t) ** 2)
        square = cosine**2 + (rounding if self.k % 2 == 0 else -rounding)
        moved = np.copysign(np.sqrt(np.maximum(square, 0.0)), cosine)
        bent: Floats = exact + (moved - cosine) * s
        return bent

    def primary_origin(self, d: Floats) -> Floats:
        """The observer, moved sideways."""
        moved: Floats = super().primary_origin(d) + self.step * self._aside
        return moved

    def primary_hits(self, P0: Floats, d: Floats) -> Hits:
        """The first hits that are not so near that the other renderer may overlook them."""
        hits, several = self._hits(P0, d, self.declared.near / abs(self.scene.screen.nu))
        self._faces_contested[several] = True
        return hits

    def secondary_start(self, points: Points, direction: Floats) -> tuple[Floats, float]:
        """Where the other renderer starts, moved sideways."""
        start = self.declared.start
        if isinstance(start, NormalOffset):
            origin, t0 = _off_surface(points, self._side(points, direction), start), 0.0
        elif isinstance(start, AlongRay):
            origin, t0 = points.M, start.length
        else:
            origin, t0 = super().secondary_start(points, direction)
        return origin + self.step * carried(points, direction, self.k), t0

    def _side(self, points: Points, direction: Floats) -> Floats:
        """Which side of a surface rays leave on, (n,), by its sign; on either when along it."""
        slope = dot(points.normal, direction)
        return np.where(slope == 0, 1.0 if self.k % 2 == 0 else -1.0, slope)

    def optical_normal(self, normal: Floats, hits: Hits) -> Floats:
        """Facets tilted by what their vertices' rounding turns them, spheres by the angle's."""
        tilt = self.declared.angle + _facet_tilt(hits, self.geometry, self.levers, self.declared)
        return unit(normal + self.sample * tilt * sideways(normal, self.k))

    def shadow(self, points: Points) -> Bools:
        """Shadow; facets that the light may pass on either side shade themselves, then do not.

        A facet exactly parallel to the light, as a wall along an axis is, is so for everybody.
        """
        dark = super().shadow(points)
        slope = np.abs(dot(points.normal, unit(self.to_light)))
        tilt = _facet_tilt(points.hits, self.geometry, self.levers, self.declared)
        return np.where((slope > 0) & (slope < tilt), self.k % 2 == 0, dark)

    def first_hits(self, P0: Floats, d: Floats, t0: float = 0.0) -> Hits:
        """The first hits; of no object, but with their t, where another may be met instead."""
        hits, several = self._hits(P0, d, t0)
        hits.object[several] = _CONTESTED
        return hits

    def color(
        self, P0: Floats, d: Floats, hits: Hits, generation: int = 0
    ) -> tuple[Floats, Signature]:
        """As the lecture's, with a signature of its own for what is contested."""
        result, signature = super().color(P0, d, hits, generation)
        signature[hits.object == _CONTESTED] = _CONTESTED_PATH
        return result, signature

    def _hits(self, P0: Floats, d: Floats, t0: float) -> tuple[Hits, Index]:
        """The first hits, and of which rays other faces of the same object may be met instead.

        Where another object may be, the hit is nobody's.
        """
        apart = 2.0 * _STEEP * self.step / norm(d)
        relative = 2.0 * (_STEEP * self.tilt + self.declared.grain)
        hits, next_t = nearest_two(self.geometry, self.rules, P0, d, t0, apart, relative)
        met = np.flatnonzero(hits.object >= 0)
        first = hits.take(met)
        gap = self._gap(take(P0, met), take(d, met), first)
        watched = first.t * (1.0 + relative) + apart[met]
        contested = np.flatnonzero(np.minimum(next_t[met], watched) <= first.t + gap)
        return hits, self._settle(P0, d, t0, hits, met[contested], gap[contested])

    def _settle(
        self, P0: Floats, d: Floats, t0: float, hits: Hits, rays: Index, gap: Floats
    ) -> Index:
        """What rays meet that may meet something else within the gap: see `_hits`."""

        def others(rays: Index, gap: Floats, face: Ints | None) -> Hits:
            t, known = hits.t[rays], (hits.object[rays], face)
            low, high = np.maximum(t - gap, t0), t + gap
            at, along = take(P0, rays), take(d, rays)
            return nearest(self.geometry, self.rules, at, along, low, high, other_than=known)

        other = others(rays, gap, hits.triangle[rays])
        some = np.flatnonzero(other.object >= 0)
        rays, gap, other = rays[some], gap[some], other.take(some)
        alike = other.object == hits.object[rays]
        alike[alike] = others(rays[alike], gap[alike], None).object < 0
        farther = np.flatnonzero(alike & (other.t > hits.t[rays]))
        hits.put(rays[farther], other.take(farther))
        hits.object[rays[~alike]] = _CONTESTED
        several: Index = rays[alike]
        return several

    def _gap(self, P0: Floats, d: Floats, hits: Hits) -> Floats:
        """How much of t (n,) may lie between two surfaces that the error can exchange."""
        t, length = hits.t, norm(d)
        normal = self.normals(self.rules.point_at(P0, d, t), hits)
        slope = np.maximum(np.abs(dot(normal, d / length)), 2.0**-20)
        gap: Floats = 2.0 * (self.step / length + self.tilt * t) / slope
        return gap + 2.0 * self.declared.grain * t


def perpendicular(d: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors (3, n) perpendicular to d (3, n) and to each other."""
    if d.strides[1] == 0 and d.shape[1] > 1:  # one vector that stands for all
        first, second = perpendicular(d[:, :1])
        return np.broadcast_to(first, d.shape), np.broadcast_to(second, d.shape)
    first = cross(d, _ASKEW[0])
    parallel = np.flatnonzero(dot(first, first) < 0.1 * dot(d, d))
    put(first, parallel, cross(take(d, parallel), _ASKEW[1]))
    first = unit(first)
    return first, unit(cross(d, first))


def sideways(d: Floats, k: int) -> Floats:
    """The k-th of six unit vectors (3, n) perpendicular to d (3, n): see `turned`."""
    return turned(perpendicular(d), k)


def turned(around: tuple[Floats, Floats], k: int) -> Floats:
    """The k-th of six unit vectors (3, n) in the plane of two that are perpendicular.

    The first three are a third of a turn apart, the others their opposites.
    """
    if k >= 3:
        return -turned(around, k - 3)
    first, second = around
    if k == 0:
        return first
    aside: Floats = -0.5 * first + (0.75**0.5 if k == 1 else -(0.75**0.5)) * second
    return aside


def carried(points: Points, direction: Floats, k: int) -> Floats:
    """`sideways` of rays that arrived at points, carried on to unit directions (3, n) from there.

    Mirrored with the ray where that goes back, turned with it where it goes on: the point is aside
    because its ray was, and what is added to that must not take it away.
    """
    delta = points.delta
    aside, along = sideways(delta, k), dot(delta, direction)
    back = np.where(dot(delta, points.normal) * dot(direction, points.normal) < 0, 1.0, -1.0)
    apart = 1.0 - back * along
    share = np.divide(
        back * dot(direction, aside), apart, where=apart > 2.0**-40, out=np.zeros_like(apart)
    )
    onward: Floats = aside + share * (delta - back * direction)
    return onward


def _facet_tilt(hits: Hits, geometry: Geometry, levers: PerSurface, declared: Declared) -> Floats:
    """The angle (n,) by which moving a facet's vertices can turn it; 0 on spheres."""
    flat = geometry.kind[hits.object] != Kind.SPHERE
    return np.where(flat, 2.0 * declared.vertex / levers.at(hits), 0.0)


def _off_surface(points: Points, side: Floats, start: NormalOffset) -> Floats:
    center = np.array(start.center).reshape(3, 1)
    there = np.abs(start.scale * (points.M - center)).max(axis=0)
    offset = start.factor * (1.0 + there) / start.scale
    started: Floats = points.M + np.copysign(offset, side) * points.normal
    return started


def _movement(base: Array, moved: list[Array]) -> Floats:
    """Largest change (n,) from the base, Euclidean for vectors; 0 where either is no number."""
    largest = np.zeros(base.shape[-1])
    for other in moved:
        with np.errstate(invalid="ignore"):
            change = other - base
            np.fmax(largest, change * change if base.ndim == 1 else _squares(change), out=largest)
    return np.where(largest < np.inf, np.sqrt(largest), 0.0)


def _squares(vectors: Floats) -> Floats:
    """The square (n,) of each vector's length, of whatever many components (k, n)."""
    squares: Floats = (vectors * vectors).sum(axis=0)
    return squares


def _bases(
    base: Tile, declared: Declared, geometry: Geometry, surfaces: Surfaces
) -> dict[str, Floats]:
    """The part (n,) of each tolerance that is there when nothing moves.

    δ along the ray, and the grain, for a length, and twice where both of its ends are computed; for
    a ratio, δ over the length it is measured in;
    for a normal, δ over the local radius of curvature, or twice the vertices' error over a facet's
    height, and the rounding of a unit vector. What slender facets add: `_slenderness`. The steps of
    the other's format come on top.
    """
    n = len(base["object"])
    nan = np.full(n, np.nan)
    hits = Hits(base["t"], base["object"], base["triangle"], nan, nan)
    lever = surfaces.levers.at(hits)
    plane, inside = _slenderness(base, hits, surfaces)
    distance = np.where(base["hit"], base["distance"], 0.0)
    delta = declared.delta + declared.slope * distance
    length = delta + declared.grain * distance
    per_t = np.divide(base["t"], base["distance"], out=np.zeros(n), where=base["hit"])
    flat = np.isin(base["object"], np.flatnonzero(geometry.kind != Kind.SPHERE))
    turn = declared.angle + np.where(flat, 2.0 * declared.vertex, delta) / lever
    angle = np.full(n, 2.0 * declared.angle)
    shade = np.abs(base["color"]).max(axis=0)
    bases = {
        "ray": np.full(n, declared.angle + declared.slope),
        "t": length * plane * per_t,
        "depth": length * plane,
        "distance": length * plane,
        "position": length * inside,
        "barycentric": delta / lever,
        "normal": turn,
        "reflection": angle,
        "reflection_t": 2.0 * length,
        "refraction": angle,
        "refraction_t": 2.0 * length,
        "color": declared.color * np.maximum(shade, 1e-6),
        "alpha": np.full(n, declared.color),
    }
    for name, step in declared.steps:
        bases[name] = bases[name] + step * (per_t if name == "t" else 1.0)
    return bases


def _slenderness(base: Tile, hits: Hits, surfaces: Surfaces) -> tuple[Floats, Floats]:
    """How many times δ a renderer may stray along the ray (n,), and within a facet (n,): ≥ 1.

    A facet of height h and longest edge L, met under an angle of cosine c, in a scene of extent
    E. δ is some roundings at the scale of E, so those of the facet's own edges are δ·L/E. Its
    normal, a product of two edges of length L over an area of L·h, is turned by δ·L/E/h, in any
    direction; a plane through one vertex with that normal is off by L times that, and by 1/c more
    along the ray. β and γ, rounded to δ/(h·c), carry an interpolated point off by L times that.
    """
    hit = base["hit"]
    aspect, size = surfaces.shape(hits)
    slope = np.abs((base["normal"] * base["ray"]).sum(axis=0))
    aspect = aspect / np.where(hit, np.maximum(slope, 2.0**-20), 1.0)
    return np.maximum(1.0, aspect * size), np.maximum(1.0, aspect)
