"""How Mitsuba errs: float32 everywhere, and secondary rays that start off the surface."""

from __future__ import annotations

import math

from converters.mitsuba.scene import near_clip
from converters.placement import Placement, reach
from minirt.scene import Scene
from minirt.screen import VirtualScreen
from reference.source import Declared, NormalOffset

#: Largest relative error of rounding to float32.
U32 = 2.0**-24
#: `spawn_ray` moves the start by this factor · (1 + max|p|) along the normal, p in its coordinates.
SPAWN_OFFSET = 1500 * U32

_DERIVATION = (
    "float32, u = 2⁻²⁴, in Mitsuba's coordinates; R the largest coordinate, E the scene's extent. "
    "Rounding a point moves it by at most √3·u·R: the observer, the start of its rays on the near "
    "plane, and the vertices or the centre of what they meet, 3·√3·u·R together. A camera ray's "
    "direction errs by {camera:.1f}·u: 4·u for the matrix and its use, 3·u·f/(2·sin f) since "
    "the angle of view f and its tangent carry 3 roundings, and the rounding of an off-axis "
    "centre; over a distance of at most E. The intersection itself adds 3 roundings at the scale "
    "of E. δ = u·(3·√3·R + ({camera:.1f} + 3)·E) = {delta:.3g} scene units. The length of a "
    "direction errs by 4·u more. Placement: scale {scale:g}, centre {center}."
)


def declared(scene: Scene, placement: Placement) -> Declared:
    """Bounds on Mitsuba's errors on a scene that stands where `placement` puts it.

    A colour is a product of at most a dozen rounded factors, 16·u; what the direction and the
    place of its rays do to it is in δ and the angle.
    """
    R, E = reach(scene, placement), placement.length(scene.extent)
    point = math.sqrt(3) * R
    camera = _camera_roundings(scene.screen)
    delta = U32 * (3 * point + (camera + 3) * E) / placement.scale
    return Declared(
        delta=delta,
        vertex=U32 * point / placement.scale,
        angle=U32 * (camera + 4),
        color=16 * U32,
        near=near_clip(scene, placement) / placement.scale,
        start=NormalOffset(SPAWN_OFFSET, placement.scale, placement.center),
        derivation=_DERIVATION.format(
            camera=camera, delta=delta, scale=placement.scale, center=placement.center
        ),
    )


def _camera_roundings(screen: VirtualScreen) -> float:
    """Error of a camera ray's direction over u.

    A relative error e of tan(f/2) turns the ray at x·tan(f/2) by e·x·tan(f/2)/(1 + x²·tan²(f/2)),
    at most e/2; three roundings of f make e = 3·u·f/sin f.
    """
    view = 2 * math.atan2(screen.r - screen.l, 2 * abs(screen.nu))
    shift = (abs(screen.l + screen.r) + abs(screen.b + screen.t)) / (2 * abs(screen.nu))
    return 4 + 1.5 * view / math.sin(view) + shift
