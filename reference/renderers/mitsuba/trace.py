"""Mitsuba's answers for one ray, or for all rays at once, by the same code.

In the vectorised variants each value is an array over the pixels and the functions below run once;
in the scalar variants each is a number and they run once for each pixel. Every ray, hit, normal,
spawned ray and sampled direction is Mitsuba's own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

#: Columns of an answer, in their order.
ORIGIN, DIRECTION = slice(0, 3), slice(3, 6)
VALID, OBJECT, TRIANGLE, T = 6, 7, 8, 9
UV, POSITION, NORMAL = slice(10, 12), slice(12, 15), slice(15, 18)
SHADOW, REFLECTED, REFRACTED, TOTAL = 18, slice(19, 28), slice(28, 37), 37
COLUMNS = 38
#: Columns within a secondary ray's answer.
DIRECTION_2, ORIGIN_2 = slice(0, 3), slice(3, 6)
VALID_2, OBJECT_2, T_2 = 6, 7, 8
#: Columns of a bounce's answer.
RADIANCE, SPAWNED, SHARE, MIRRORED = slice(0, 3), slice(3, 9), slice(9, 12), 12
BOUNCE_COLUMNS = 13


@dataclass(frozen=True)
class World:
    """The Mitsuba objects that a ray needs.

    Attributes
    ----------
    mi, dr : modules
        With the variant set.
    scene, sensor : Mitsuba objects
    to_light : Vector3f
        The direction towards the light.
    mirror : BSDF
        A two-sided perfect conductor.
    glasses : list of (BSDF, Any)
        A dielectric for each index of refraction, and ``uses(object, active)``: whether an
        object has it.
    """

    mi: Any
    dr: Any
    scene: Any
    sensor: Any
    to_light: Any
    mirror: Any
    glasses: Sequence[tuple[Any, Any]]


def primary(world: World, x: Any, y: Any) -> list[Any]:
    """All answers for one pixel's ray, in the order of the columns.

    Parameters
    ----------
    x, y : Float
        Where the ray crosses the image, in [0, 1]² from its upper left corner.
    """
    mi = world.mi
    ray, _ = world.sensor.sample_ray(0.0, 0.5, mi.Point2f(x, y), mi.Point2f(0.5))
    hit = world.scene.ray_intersect_preliminary(ray, coherent=True)
    valid = hit.is_valid()
    if valid is False:  # a number, not an array: nothing was hit
        return [*ray.o, *ray.d, *[0.0] * (COLUMNS - 6)]
    si = hit.compute_surface_interaction(ray, mi.RayFlags.All, valid)
    si.sh_frame = mi.Frame3f(si.n)
    si.wi = si.to_local(-ray.d)
    shadow = world.scene.ray_test(si.spawn_ray(world.to_light), valid)
    answers = [
        *ray.o, *ray.d, valid, hit.shape_index, hit.prim_index, hit.t, *hit.prim_uv,
        *si.p, *si.n, shadow,
    ]  # fmt: skip
    answers += _secondary(world, si, _reflected(world, si, valid), valid)
    direction, weight, glassy = _refracted(world, si, hit.shape_index, valid)
    answers += _secondary(world, si, direction, glassy)
    return [*answers, weight == 0]


def _reflected(world: World, si: Any, active: Any) -> Any:
    mi = world.mi
    sample, _ = world.mirror.sample(mi.BSDFContext(), si, 0.0, mi.Point2f(0.0), active)
    return si.to_world(sample.wo)


def _refracted(world: World, si: Any, number: Any, active: Any) -> tuple[Any, Any, Any]:
    """Direction, transmitted share (0: total reflection), and where there is an index."""
    mi, dr = world.mi, world.dr
    flags = int(mi.BSDFFlags.DeltaTransmission)
    context = mi.BSDFContext(mi.TransportMode.Radiance, flags)
    direction, weight, glassy = mi.Vector3f(0.0), mi.Float(0.0), mi.Bool(False)
    for glass, uses in world.glasses:
        this = uses(number, active)
        sample, shares = glass.sample(context, si, 0.0, mi.Point2f(0.0), this)
        direction = dr.select(this, si.to_world(sample.wo), direction)
        weight = dr.select(this, shares[0], weight)
        glassy = glassy | this
    return direction, weight, glassy


def _secondary(world: World, si: Any, direction: Any, active: Any) -> list[Any]:
    """A ray that Mitsuba spawns at the hit, and what it hits."""
    ray = si.spawn_ray(direction)
    hit = world.scene.ray_intersect_preliminary(ray, coherent=False, active=active)
    return [*direction, *ray.o, active & hit.is_valid(), hit.shape_index, hit.t]


def bounce(world: World, *ray_components: Any) -> list[Any]:
    """One generation of Whitted's recursion in Mitsuba's own terms, for a ray (origin, direction).

    The radiance that the surface reflects of the light, by the emitter's own visibility test and
    the material's own BSDF; then the ray that a mirror spawns, the share of it that is reflected,
    and whether there is one. All are deterministic, since light and mirror are delta functions.
    """
    mi, dr, scene = world.mi, world.dr, world.scene
    ray = mi.Ray3f(mi.Point3f(*ray_components[:3]), mi.Vector3f(*ray_components[3:]))
    si = scene.ray_intersect(ray)
    active = si.is_valid()
    if active is False:
        return [0.0] * BOUNCE_COLUMNS
    bsdf, context = si.bsdf(ray), mi.BSDFContext()
    light, irradiance = scene.sample_emitter_direction(si, mi.Point2f(0.5), True, active)
    sent = irradiance * bsdf.eval(context, si, si.to_local(light.d), active)
    sample, share = bsdf.sample(context, si, 0.0, mi.Point2f(0.5), active)
    mirrored = active & mi.has_flag(sample.sampled_type, mi.BSDFFlags.DeltaReflection)
    spawned = si.spawn_ray(si.to_world(sample.wo))
    return [*dr.select(active, sent, mi.Color3f(0.0)), *spawned.o, *spawned.d, *share, mirrored]
