"""Mistakes in the output: the algorithm is right, a finished value is not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from minirt.frame import Array
from minirt.quantities import QUANTITIES
from minirt.render import Tile
from minirt.scene import Scene
from minirt.screen import view_frame
from minirt.vectors import Index, dot
from reference.mutants.mutant import Change, Mutant


def _each(name: str, change: Callable[[Array], Array]) -> Change:
    """A change of one quantity, if it is given."""

    def changed(scene: Scene, pixels: Index, tile: Tile) -> Tile:
        return {name: change(tile[name])} if name in tile else {}

    return changed


def _half(values: Array) -> Array:
    with np.errstate(over="ignore"):
        rounded: Array = values.astype(np.float16).astype(values.dtype)
    return rounded


def _gamma(values: Array) -> Array:
    shown: Array = np.maximum(values, 0.0) ** (1 / 2.2)
    return shown


def _cut(values: Array) -> Array:
    return np.clip(values, 0.0, 1.0)


def _bytes(values: Array) -> Array:
    rounded: Array = np.rint(values * 255) / 255
    return rounded


def _packed(values: Array) -> Array:
    packed: Array = values * 0.5 + 0.5
    return packed


def _zero_for_none(values: Array) -> Array:
    return np.where(np.isinf(values), 0.0, values)


def _lit(values: Array) -> Array:
    return np.where(values < 0, values, 1 - values).astype(values.dtype)


def _far_for_none(values: Array) -> Array:
    return np.where(np.isinf(values), 1e10, values)


def _depth_for_distance(scene: Scene, pixels: Index, tile: Tile) -> Tile:
    """The depth is the distance times the cosine of the ray with the view axis."""
    if "distance" not in tile or "ray" not in tile:
        return {}
    cosine = np.abs(dot(tile["ray"], view_frame(scene.screen).n))
    return {"distance": tile["distance"] * cosine}


def _distance_for_depth(scene: Scene, pixels: Index, tile: Tile) -> Tile:
    if "depth" not in tile or "ray" not in tile:
        return {}
    cosine = np.abs(dot(tile["ray"], view_frame(scene.screen).n))
    return {"depth": tile["depth"] / cosine}


def _normal_in_view(scene: Scene, pixels: Index, tile: Tile) -> Tile:
    if "normal" not in tile:
        return {}
    frame = view_frame(scene.screen)
    return {"normal": np.stack([dot(tile["normal"], axis) for axis in frame[:3]])}


def _normal_to_viewer(scene: Scene, pixels: Index, tile: Tile) -> Tile:
    if "normal" not in tile or "ray" not in tile:
        return {}
    away = dot(tile["normal"], tile["ray"]) > 0
    return {"normal": np.where(away, -tile["normal"], tile["normal"])}


def _last_row_dropped(scene: Scene, pixels: Index, tile: Tile) -> Tile:
    """The lowest row of the image is never traced: it holds each quantity's miss value."""
    last = pixels // scene.screen.nx == scene.screen.ny - 1
    return {
        name: np.where(last, np.asarray(QUANTITIES[name].miss, values.dtype), values)
        for name, values in tile.items()
    }


MUTANTS = (
    Mutant("last-row-dropped", "S2", "without the image's last row",
           "range(ny − 1), or a file that was cut short by a few bytes.",
           "ray", change=_last_row_dropped),
    Mutant("normal-in-viewing-coordinates", "S3", "with the normal left in viewing coordinates",
           "Shaders light in the camera's coordinates, and write those out.",
           "normal", change=_normal_in_view),
    Mutant("no-hit-as-zero", "S6", "with t = 0 for ∅",
           "An image starts out black: nothing hit looks nearest of all.",
           "t", change=_each("t", _zero_for_none)),
    Mutant("no-hit-as-far-depth", "S6", "with a depth of 1e10 for ∅",
           "A large number in the place of ∞ is a surface far away.",
           "t", change=_each("depth", _far_for_none)),
    Mutant("depth-in-float16", "S5", "with the depth rounded to float16",
           "Image formats have a half-precision type, with eleven bits.",
           "t", change=_each("depth", _half)),
    Mutant("depth-given-as-distance", "S5", "with the depth given as the distance",
           "A z-buffer's z is measured along the view axis, not along the ray.",
           "t", change=_depth_for_distance),
    Mutant("distance-given-as-depth", "S5", "with the distance given as the depth",
           "Ray tracers have the distance at hand; depth is along the view axis.",
           "t", change=_distance_for_depth),
    Mutant("normal-packed", "S10", "with the normal packed into [0, 1]",
           "½ + ½·s is how a picture of normals is coloured.",
           "normal", change=_each("normal", _packed)),
    Mutant("normal-turned-to-viewer", "S8", "with the normal given turned to the viewer",
           "Light needs it so; the surface's own normal points outward.",
           "normal", change=_normal_to_viewer),
    Mutant("shadow-mask-inverted", "S12", "with 1 for lit",
           "A mask of light in the place of a mask of shadow.",
           "shadow", change=_each("shadow", _lit)),
    Mutant("gamma-applied", "S7", "with gamma applied",
           "The colour was made for a screen: c^(1/2.2) in the place of c.",
           "colour", change=_each("color", _gamma)),
    Mutant("colour-cut", "S13", "with the colour cut to [0, 1]",
           "It is what a screen shows; the sum of the terms may be larger.",
           "colour", change=_each("color", _cut)),
    Mutant("colour-of-8-bits", "S7", "with the colour rounded to 8 bits",
           "It went through a PNG.",
           "colour", change=_each("color", _bytes)),
)  # fmt: skip
