"""S4: the basic algorithm, pixel by pixel: Scene → Frame."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator

import numpy as np

from minirt.culling import squares, visible_pixels
from minirt.errors import InputError
from minirt.frame import Array, Frame
from minirt.hits import RayHits
from minirt.memory import keep_freed_memory, require_memory
from minirt.points import Branch, Points, SecondaryRays
from minirt.quantities import QUANTITIES
from minirt.rays import Rays
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene
from minirt.vectors import Index, norm, put
from minirt.version import __version__
from minirt.whitted import Whitted

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
        Called with pixels done and pixels in all, again and again until all are done.

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
    keep_freed_memory()
    whitted = Whitted(scene, rules)
    names = chosen_quantities(quantities)
    if progress is not None and not callable(progress):
        got = type(progress).__name__
        raise InputError("not a function", where="progress", got=got, expected="f(done, total)")
    arrays = blank_frame(scene, names)
    if "color" in arrays:
        arrays["color"][...] = scene.background
    wanted = frozenset(names)
    for pixels, done in _batches(whitted, wanted):
        fill(arrays, pixels, trace_pixels(whitted, pixels, wanted))
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


def _batches(whitted: Whitted, wanted: frozenset[str]) -> Iterator[tuple[Index, int]]:
    """Pixels (n,) to be traced together, and how many of the image are dealt with then.

    Pixels that can show nothing are left out, unless their rays are wanted or a rule is replaced.
    """
    screen, done = whitted.scene.screen, 0
    if "ray" not in wanted and not whitted.rules.changed():
        yield from visible_pixels(whitted.world.index, screen.nx, screen.ny, whitted.rays_of)
        return
    for pixels in squares(screen.nx, screen.ny):
        done += len(pixels)
        yield pixels, done


def trace_pixels(whitted: Whitted, pixels: Index, wanted: frozenset[str]) -> Tile:
    """The wanted quantities of pixels (n,), counted along rows from the top left."""
    rays = whitted.rays_of(pixels)
    return quantities_at(whitted, rays, whitted.first_hits(rays), wanted)


def quantities_at(whitted: Whitted, rays: Rays, hits: RayHits, wanted: frozenset[str]) -> Tile:
    """The wanted quantities (n,) or (3, n) of the observer's rays, which meet those hits."""
    n, d, rules = rays.count, rays.directions, whitted.rules
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
    points = whitted.points(rays, hits)
    tile["position"] = _scatter(points, points.M, n, "position")
    tile["normal"] = _scatter(points, points.normal, n, "normal")
    tile["alpha"] = _scatter(points, points.material.alpha, n, "alpha")
    dark = reflected = refracted = None
    if not wanted.isdisjoint({"color", "shadow"}):
        dark = whitted.shadow(points)
        tile["shadow"] = _scatter(points, dark.astype(np.int8), n, "shadow")
    if wanted & _REFLECTION:
        reflected = whitted.reflected(points)
        tile.update(_branch_tile("reflection", points, reflected, n))
    if wanted & _REFRACTION:
        some = points.take(points.refractive)
        refracted = whitted.refracted(some)
        tile.update(_branch_tile("refraction", some, refracted, n))
        total = np.isnan(refracted.direction[0]).astype(np.int8)
        tile["tir"] = _scatter(some, total, n, "tir")
    if "color" in wanted:
        traced = SecondaryRays(dark, reflected, refracted)
        tile["color"] = whitted.color_of(points, n, traced=traced)
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
