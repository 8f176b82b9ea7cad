"""S7, S13: the colour of a point, and of a pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from minirt.scene import Scene
from minirt.vectors import Bools, Floats, Index, Ints, column, dot


@dataclass(frozen=True)
class Surfaces:
    """Materials of n points: colours (3, n), shares and indices (n,), shininess (n,) int."""

    ambient: Floats
    diffuse: Floats
    specular: Floats
    shininess: Ints
    reflectance: Floats
    transmittance: Floats
    ior: Floats
    alpha: Floats

    def take(self, index: Index | Ints) -> Surfaces:
        """The materials of some of the points, or of objects by number."""
        return Surfaces(*(np.take(value, index, axis=-1) for value in vars(self).values()))


def object_materials(scene: Scene) -> Surfaces:
    """The material of each object of a scene; ior is NaN where there is none."""
    number = {name: k for k, name in enumerate(scene.materials)}
    each = scene.materials.values()

    def colors(name: str) -> Floats:
        return np.array([getattr(m, name) for m in each], dtype=np.float64).reshape(-1, 3).T

    def numbers(name: str) -> Floats:
        return np.array([getattr(m, name) for m in each], dtype=np.float64)

    return Surfaces(
        colors("ambient"),
        colors("diffuse"),
        colors("specular"),
        np.array([m.shininess for m in each], dtype=np.int32),
        numbers("reflectance"),
        numbers("transmittance"),
        numbers("ior"),
        numbers("alpha"),
    ).take(np.array([number[thing.material] for thing in scene.objects], dtype=np.intp))


def illuminate(
    surface: Surfaces, light_color: Floats, to_light: Floats,
    s: Floats, delta: Floats, mirror: Floats,
) -> Floats:  # fmt: skip
    """Phong's model at a lit point: ambient + light ∘ (diffuse + specular).

    The slides leave the formula open; this is the one that OpenGL courses teach:
    ambient + light ∘ (diffuse · max(0, s·L) + specular · max(0, ρ(−L, s)·(−δ))^shininess), the
    specular term only where s·L > 0.

    Parameters
    ----------
    surface : Surfaces
    light_color : (3, 1) float64
    to_light : (3, 1) float64
        L = −l/‖l‖.
    s : (3, n) float64
        Unit normal turned to the viewer.
    delta : (3, n) float64
        Unit direction of the ray that arrived.
    mirror : (3, n) float64
        ρ(−L, s): the light's direction reflected (S14).

    Returns
    -------
    (3, n) float64
        Linear RGB, not clamped.

    Source: S13; B. T. Phong 1975, doi:10.1145/360825.360839.
    """
    facing = dot(s, to_light)
    highlight = np.where(facing > 0, np.maximum(0.0, dot(mirror, -delta)), 0.0)
    specular = surface.specular * integer_power(highlight, surface.shininess)
    return surface.ambient + light_color * (surface.diffuse * np.maximum(0.0, facing) + specular)


def shadow_color(surface: Surfaces, color: tuple[float, float, float] | None) -> Floats:
    """The colour of a point in shadow: the scene's own, or the ambient term alone. Source: S13."""
    if color is None:
        return surface.ambient
    return np.broadcast_to(column(color), surface.ambient.shape)


def combine(
    local: Floats, mirrored: Floats, transmitted: Floats, k_r: Floats, k_t: Floats
) -> Floats:
    """(1 − k_r − k_t)·local + k_r·C(ρ) + k_t·C(ϱ). Source: S7."""
    return (1.0 - k_r - k_t) * local + k_r * mirrored + k_t * transmitted


def integer_power(base: Floats, exponent: Ints) -> Floats:
    """base**exponent by repeated squaring: products only, so the same bits on every CPU.

    Parameters
    ----------
    base : (n,) float64
    exponent : (n,) int32, ≥ 1
    """
    result = np.ones_like(base)
    remaining = exponent.copy()
    square = base
    while remaining.any():
        result = np.where(remaining & 1, result * square, result)
        square = square * square
        remaining >>= 1
    return result


def in_total_reflection(k_r: Floats, k_t: Floats, total: Bools) -> tuple[Floats, Floats]:
    """Shares of the mirrored and the transmitted ray: at total reflection k_t's goes to ρ (E2)."""
    return np.where(total, k_r + k_t, k_r), np.where(total, 0.0, k_t)
