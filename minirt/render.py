"""S4: the basic algorithm, pixel by pixel: Scene → Frame."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from functools import cache

import numpy as np

from minirt.errors import InputError
from minirt.frame import Array, Frame
from minirt.memory import require_memory
from minirt.quantities import QUANTITIES
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene
from minirt.screen import image_pixels
from minirt.vectors import Floats, Index, norm, put
from minirt.version import __version__
from minirt.whitted import Branch, Onward, Points, Whitted, refractive

#: Pixels along the side of the squares that are traced together: bounds the working memory
#: whatever the image's size.
SIDE = 256

#: What a tile hands over beside the public quantities: see `Whitted.color`.
SIGNATURE = "signature"

Tile = dict[str, Array]


def render(
    scene: Scene,
    rules: Rules = SLIDES,
    quantities: str | Iterable[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Frame:
    """Render a scene by the lecture's algorithm.

    Parameters
    ----------
    scene : Scene
    rules : Rules, optional
        The record of rules to follow; one of them may be replaced.
    quantities : iterable of str, or str with commas, optional
        Names from `minirt.QUANTITIES`; all of them when left out. Only what they need is traced.
    progress : callable, optional
        Called with pixels done and pixels in all, after each tile.

    Returns
    -------
    Frame
        Arrays (ny, nx) or (ny, nx, k), row 0 at the top.

    Raises
    ------
    InputError
        Not a loaded scene, not a record of rules, an unknown quantity, or an image that does not
        fit in memory.

    Examples
    --------
    >>> import minirt
    >>> frame = minirt.render(minirt.load_scene("atlas:one-sphere"), quantities=["hit", "depth"])
    >>> frame["hit"].shape, frame["hit"].dtype.name
    ((192, 256), 'bool')

    Source: S4.
    """
    whitted = Whitted(scene, rules)
    names = chosen_quantities(quantities)
    if progress is not None and not callable(progress):
        got = type(progress).__name__
        raise InputError("not a function", where="progress", got=got, expected="f(done, total)")
    arrays = blank_frame(scene, names)
    done = 0
    for pixels, tile in tiles(whitted, names):
        fill(arrays, pixels, tile)
        done += len(pixels)
        if progress is not None:
            progress(done, scene.screen.nx * scene.screen.ny)
    return Frame(arrays, frame_meta(scene))


def blank_frame(scene: Scene, names: Collection[str] = tuple(QUANTITIES)) -> dict[str, Array]:
    """Arrays for some quantities of a scene's image, with nothing hit anywhere.

    Raises
    ------
    InputError
        If they do not fit in memory.
    """
    require_room(scene, names)
    ny, nx = scene.screen.ny, scene.screen.nx
    return {name: QUANTITIES[name].missing(ny, nx) for name in names}


def require_room(scene: Scene, names: Collection[str] = tuple(QUANTITIES)) -> None:
    """Refuse an image that does not fit in memory.

    Raises
    ------
    InputError
    """
    ny, nx = scene.screen.ny, scene.screen.nx
    each = [QUANTITIES[name] for name in names]
    bytes_ = sum(q.components * np.dtype(q.dtype).itemsize for q in each) * nx * ny
    of = "every quantity" if len(each) == len(QUANTITIES) else ", ".join(q.name for q in each)
    require_memory(bytes_, f"{scene.name}: {nx} × {ny} pixels of {of}")


def fill(arrays: dict[str, Array], pixels: Index, tile: Tile) -> None:
    """Put a tile's values, (n,) or (3, n), into pixels (n,) of each array."""
    for name, array in arrays.items():
        components = QUANTITIES[name].components
        put(array.reshape(-1, components).T, pixels, tile[name].reshape(components, len(pixels)))


def frame_meta(scene: Scene) -> dict[str, str]:
    """Which scene and which version a frame comes from."""
    return {"scene": scene.name, "sceneSha256": scene.sha256, "version": __version__}


def chosen_quantities(names: str | Iterable[str] | None) -> tuple[str, ...]:
    """Checked names in the table's order; all for None.

    Raises
    ------
    InputError

    Examples
    --------
    >>> chosen_quantities("depth, hit")
    ('hit', 'depth')
    """
    if names is None:
        return tuple(QUANTITIES)
    if isinstance(names, str):
        names = [name.strip() for name in names.split(",")]
    if not isinstance(names, Iterable):
        raise InputError("not names of quantities", got=repr(names)[:80], expected="as 'hit,depth'")
    wanted = list(names)
    unknown = [name for name in wanted if not isinstance(name, str) or name not in QUANTITIES]
    if unknown or not wanted:
        raise InputError(
            "unknown quantity" if unknown else "no quantity was asked for",
            got=", ".join(map(repr, unknown))[:200],
            expected=", ".join(QUANTITIES),
        )
    return tuple(name for name in QUANTITIES if name in wanted)


def tiles(whitted: Whitted, names: Iterable[str]) -> Iterator[tuple[Index, Tile]]:
    """Trace an image tile by tile: the pixels (n,), and arrays (n,) or (3, n).

    Pixels are counted along rows from the top left; the tiles are square, and neighbours follow
    each other. `SIGNATURE` may be among the names.
    """
    wanted = frozenset(names)
    screen = whitted.scene.screen
    for pixels in squares(screen.nx, screen.ny):
        d = primary_directions(whitted.scene, whitted.rules, pixels)
        yield pixels, trace_pixels(whitted, d, wanted)


def squares(nx: int, ny: int) -> Iterator[Index]:
    """The pixels of an image in square tiles, each in the order of a Z: (n,) intp."""
    for top in range(0, ny, SIDE):
        for left in range(0, nx, SIDE):
            yield top * nx + left + _curve(min(SIDE, ny - top), min(SIDE, nx - left), nx)


@cache
def _curve(height: int, width: int, nx: int) -> Index:
    """Pixels of a first tile in blocks of 8 × 8, each in the order of a Z, and so its parts."""
    row, column = np.divmod(np.arange(height * width), width)
    within = np.zeros_like(row)
    for bit in range(3):
        within |= ((column >> bit & 1) << 2 * bit) | ((row >> bit & 1) << 2 * bit + 1)
    order: Index = np.lexsort((within, column >> 3, row >> 3))
    return row[order] * nx + column[order]


def primary_directions(scene: Scene, rules: Rules, pixels: Index) -> Floats:
    """d (3, n) of the rays through the centres of pixels (n,). Source: S1–S3, S5."""
    i, j = image_pixels(scene.screen, pixels)
    frame = rules.view_frame(scene.screen)
    u_s, v_s = rules.pixel_center(scene.screen, i, j)
    return rules.ray_direction(rules.model_from_view(frame, u_s, v_s))


def trace_pixels(whitted: Whitted, d: Floats, wanted: frozenset[str]) -> Tile:
    """The wanted quantities of the rays from the observer along d (3, n)."""
    n, rules = d.shape[1], whitted.rules
    P0 = whitted.primary_origin(d)
    hits = whitted.primary_hits(P0, d)
    tile: Tile = {
        "hit": hits.object >= 0,
        "object": hits.object,
        "triangle": hits.triangle,
        "t": hits.t,
    }
    if wanted & _ALONG:
        length = norm(d)
        tile["ray"] = d / length
        tile["depth"] = rules.depth_of(hits.t, whitted.scene.screen.nu)
        tile["distance"] = rules.distance_of(hits.t, length)
    if "barycentric" in wanted:
        tile["barycentric"] = np.stack((hits.beta, hits.gamma))
    if wanted <= BEFORE_POINTS:
        return tile
    points = whitted.points(P0, d, hits)
    tile["position"] = _scatter(points, points.M, n, "position")
    tile["normal"] = _scatter(points, points.normal, n, "normal")
    tile["alpha"] = _scatter(points, points.material.alpha, n, "alpha")
    colored = not wanted.isdisjoint({"color", SIGNATURE})
    dark = reflected = refracted = None
    if colored or "shadow" in wanted:
        dark = whitted.shadow(points)
        tile["shadow"] = _scatter(points, dark.astype(np.int8), n, "shadow")
    if wanted & _REFLECTION:
        reflected = whitted.reflected(points)
        tile.update(_branch_tile("reflection", points, reflected, n))
    if wanted & _REFRACTION:
        some = points.take(refractive(points))
        refracted = whitted.refracted(some)
        tile.update(_branch_tile("refraction", some, refracted, n))
        total = np.isnan(refracted.direction[0]).astype(np.int8)
        tile["tir"] = _scatter(some, total, n, "tir")
    if colored:
        onward = Onward(dark, reflected, refracted)
        tile["color"], tile[SIGNATURE] = whitted.color_of(points, n, onward=onward)
    return tile


_ALONG = {"ray", "depth", "distance"}
#: Quantities that need no surface points, nor any ray from there.
BEFORE_POINTS = {"hit", "object", "triangle", "t", "barycentric", *_ALONG}
_REFLECTION = {"reflection", "reflection_object", "reflection_t"}
_REFRACTION = {"refraction", "refraction_object", "refraction_t", "tir"}


def _branch_tile(name: str, points: Points, branch: Branch, n: int) -> Tile:
    return {
        name: _scatter(points, branch.direction, n, name),
        f"{name}_object": _scatter(points, branch.hits.object, n, f"{name}_object"),
        f"{name}_t": _scatter(points, branch.length, n, f"{name}_t"),
    }


def _scatter(points: Points, values: Array, n: int, name: str) -> Array:
    """Values of the points at their rays, the quantity's miss value at the others."""
    quantity = QUANTITIES[name]
    k = quantity.components
    result = np.full((k, n), quantity.miss, dtype=quantity.dtype)
    put(result, points.rays, values.reshape(k, len(points.rays)))
    return result[0] if k == 1 else result
