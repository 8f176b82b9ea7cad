"""How far the exact answer itself moves under another renderer's declared error.

Each pixel is traced four times: once as the lecture says, and three times with displaced rays.
There the secondary rays start as the other renderer starts them, and every ray that is cast
(primary, shadow, reflected, refracted) is moved sideways by 2·δ, in three directions perpendicular
to it, a third of a turn apart. The triangle of the three contains the circle of radius δ: a
straight edge within δ of the ray is crossed by one of them, whatever its direction. An answer that
changes in proportion to the displacement changes most at a corner of the triangle, so that the
largest of the three changes bounds all changes within δ. If only first hits are asked for, the six
corners of a hexagon, 2/√3·δ away, are used: then fewer pixels are near an edge. A ray that leaves a
point is displaced to the same side as the point, mirrored or turned as the ray is, so that the two
add up; behind a second mirror they may not.

If δ grows with the distance, primary rays are also tilted, to the same side. Facets are tilted as
far as the rounding of their vertices can turn them, and the cosine of a refracted ray is changed by
the rounding of its square. If other surfaces lie within the error of the first (coplanar or
touching ones), the other renderer may see any of them, and the hit is contested: it agrees with no
answer.

A polygon adds to δ the distance of its vertices from its plane, since each renderer chooses a plane
of its own. A facet may or may not shade itself if the light grazes it at an angle by which the
error of its vertices can turn it: the traces never agree there.

A discrete quantity is certain where all of them agree; a continuous one where the discrete answers
that lead to it are. There its tolerance is a base, from δ and the local geometry, plus κ times
the largest change among the traces.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from minirt.culling import squares
from minirt.frame import Array, Frame
from minirt.geometry import Geometry, Kind
from minirt.hits import RayHits
from minirt.quantities import QUANTITIES
from minirt.render import (
    BEFORE_POINTS,
    Tile,
    blank_frame,
    chosen_quantities,
    fill,
    frame_meta,
)
from minirt.rules import SLIDES
from minirt.scene import Scene
from minirt.vectors import Bools, Floats, Index
from minirt.whitted import primary_directions
from reference.compare.displaced import Displaced, perpendicular
from reference.compare.paths import SIGNATURE, SignedPaths
from reference.compare.surfaces import Surfaces, warp
from reference.source import Declared

#: Safety factor on the largest change, which bounds all that is in proportion to δ: a margin for
#: the curvature of an answer, and for errors that do not have the same direction.
KAPPA = 2.0

#: By number of displaced rays, their displacement in δ: a triangle, and a hexagon, of that
#: circumradius contains a circle of radius 1.
_STEP = {3: 2.0, 6: 2.0 / 3.0**0.5}

#: Quantities that must agree for a quantity to be certain, besides itself if it is discrete.
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
    """Which pixels a comparison may judge, and with which tolerance.

    Attributes
    ----------
    certain : dict of str to (ny, nx) bool
        By quantity: whether the exact answer is stable under the declared error.
    tolerance : dict of str to (ny, nx) float64
        By continuous quantity: largest allowed error, Euclidean for vectors, in its unit; 0 where
        it does not apply.
    """

    certain: dict[str, Bools]
    tolerance: dict[str, Floats]


@dataclass(frozen=True, eq=False)
class Exact:
    """minirt's own answer to a scene, which serves for every declared error.

    Attributes
    ----------
    scene : Scene
    frame : Frame
        Every quantity, bit for bit what `minirt.render` gives.
    signature : (ny, nx) uint64
        Of each pixel's tree of rays: see `reference.compare.paths.SignedPaths`.
    """

    scene: Scene
    frame: Frame
    signature: Array

    def tile(self, pixels: Index) -> Tile:
        """Some pixels' values, (n,) or (3, n), as `minirt.render.trace_pixels` gives them."""
        tile: Tile = {SIGNATURE: self.signature.reshape(-1)[pixels]}
        for name, array in self.frame.items():
            flat = array.reshape(self.signature.size, -1).take(pixels, axis=0)
            tile[name] = flat[:, 0] if array.ndim == 2 else flat.T.copy()
        return tile


def exact_answer(scene: Scene) -> Exact:
    """Render every quantity of a scene, and the signature of each pixel."""
    arrays = blank_frame(scene)
    signature = np.zeros((scene.screen.ny, scene.screen.nx), dtype=np.uint64)
    whitted, wanted = SignedPaths(scene), frozenset(arrays)
    for pixels in squares(scene.screen.nx, scene.screen.ny):
        rays = whitted.rays_of(pixels)
        tile = whitted.signed_tile(rays, whitted.first_hits(rays), wanted)
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
    collector = _Collector(scene, chain)
    wanted = frozenset({*judged, *links})
    directions = 6 if wanted <= BEFORE_POINTS else 3
    sides = [(k, _STEP[directions]) for k in range(directions)]
    others = [Displaced(scene, declared, surfaces.levers, *side) for side in sides]
    for pixels in squares(scene.screen.nx, scene.screen.ny):
        tile, d = exact.tile(pixels), primary_directions(scene, SLIDES, pixels)
        around = perpendicular(d)
        moved = [other.tile(d, around, wanted) for other in others]
        collector.add(pixels, tile, moved, _bases(tile, declared, geometry, surfaces))
    return Stability(collector.certain, collector.tolerance)


def _with_warp(declared: Declared, off_plane: float) -> Declared:
    """The error, plus the distance of polygons' vertices from their planes: see `warp`."""
    return replace(declared, delta=declared.delta + off_plane, vertex=declared.vertex + off_plane)


def measure(
    scene: Scene, declared: Declared, quantities: Iterable[str] | None = None
) -> tuple[Frame, Stability]:
    """A scene's whole frame, and how stable some quantities are: see `stability_of`."""
    exact = exact_answer(scene)
    return exact.frame, stability_of(exact, declared, quantities)


def _chain(judged: Iterable[str], declared: Declared) -> dict[str, tuple[str, ...]]:
    """By quantity, the quantities that must agree for it to be certain.

    If facets that share an edge may leave a gap, all of them depend on the facet that is hit.
    """
    gaps = () if declared.watertight else ("object", "triangle")
    itself = {name: (name,) if QUANTITIES[name].discrete else () for name in judged}
    return {name: tuple(dict.fromkeys((*gaps, *_CHAIN[name], *itself[name]))) for name in judged}


class _Collector:
    """Collects, tile by tile, which pixels are certain and their tolerances."""

    def __init__(self, scene: Scene, chain: dict[str, tuple[str, ...]]) -> None:
        size = (scene.screen.ny, scene.screen.nx)
        self.chain = chain
        self.certain = {name: np.zeros(size, dtype=np.bool_) for name in chain}
        self.tolerance = {name: np.zeros(size) for name in chain if not QUANTITIES[name].discrete}

    def add(self, pixels: Index, tile: Tile, moved: list[Tile], bases: dict[str, Floats]) -> None:
        """Add one tile: the exact answers, the displaced ones, and the bases of tolerances."""
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


def _movement(base: Array, moved: list[Array]) -> Floats:
    """Largest change (n,) from the base, Euclidean for vectors; 0 if either is not a number."""
    largest = np.zeros(base.shape[-1])
    for other in moved:
        with np.errstate(invalid="ignore"):
            change = other - base
            np.fmax(largest, change * change if base.ndim == 1 else _squares(change), out=largest)
    return np.where(largest < np.inf, np.sqrt(largest), 0.0)


def _squares(vectors: Floats) -> Floats:
    """The square (n,) of the length of vectors (k, n)."""
    squares: Floats = (vectors * vectors).sum(axis=0)
    return squares


def _bases(
    base: Tile, declared: Declared, geometry: Geometry, surfaces: Surfaces
) -> dict[str, Floats]:
    """The part (n,) of each tolerance that does not depend on the displaced rays.

    For a length: δ along the ray, and the grain; twice that if both of its ends are computed. For a
    ratio: δ over the length that is its unit. For a normal: δ over the local radius of curvature,
    or twice the vertices' error over a facet's height, and the rounding of a unit vector. Slender
    facets add to it (`_slenderness`), and so do the steps of the other's format.
    """
    n = len(base["object"])
    nan = np.full(n, np.nan)
    hits = RayHits(base["t"], base["object"], base["triangle"], nan, nan)
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


def _slenderness(base: Tile, hits: RayHits, surfaces: Surfaces) -> tuple[Floats, Floats]:
    """The largest error in δ along the ray (n,), and within a facet (n,): both ≥ 1.

    A facet of height h and longest edge L, hit at an angle of cosine c, in a scene of extent
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
