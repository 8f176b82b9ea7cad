"""How Embree errs: float32 rays and triangles, and secondary rays that we start off the surface."""

from __future__ import annotations

import math

from converters.placement import Placement, reach
from minirt.scene import Scene
from reference.source import Declared, NormalOffset

#: Largest relative error of rounding to float32.
U32 = 2.0**-24
#: Secondary rays start this far off the surface, in a placement whose extent is at most 1: four
#: times the error of the point and of the next ray's test together (15·u each, see below).
START_OFFSET = 128 * U32

_DERIVATION = (
    "float32, u = 2⁻²⁴, in coordinates in which R is the largest coordinate and E the scene's "
    "extent. Rounding a point moves it by at most √3·u·R: a ray's start and the vertices it is "
    "tested against, 2·√3·u·R. Rounding the direction turns the ray by u: u·E. Embree's test "
    "subtracts the start from the vertices, u·E; edges and their product err like vertices moved "
    "by 5·u·E; the two scalar products of t by 3·u·E each, the quotient and its rounding by "
    "2·u·E. δ = u·(2·√3·R + 15·E) = {delta:.3g} scene units. Spheres are met in float64. "
    "Placement: scale {scale:g}, centre {center}."
)


def declared(scene: Scene, placement: Placement) -> Declared:
    """Bounds on Embree's errors on a scene that stands where `placement` puts it.

    A facet's normal is the product of its edges: they are rounded by u of their length each, the
    product adds three roundings, 5·u of ‖e‖‖f‖ in all, which turns the normal as far as
    moving a vertex by 5·u·E/√2.
    """
    R, E = reach(scene, placement), placement.length(scene.extent)
    point = math.sqrt(3) * R
    delta = U32 * (2 * point + 15 * E) / placement.scale
    return Declared(
        delta=delta,
        vertex=U32 * (point + 4 * E) / placement.scale,
        angle=4 * U32,
        color=0.0,
        start=NormalOffset(START_OFFSET, placement.scale, placement.center),
        derivation=_DERIVATION.format(delta=delta, scale=placement.scale, center=placement.center),
    )
