"""Wrong versions of S7, S12 and S13: shadow rays and colours."""

from __future__ import annotations

import numpy as np

from minirt.rules import SLIDES
from minirt.shading import Surfaces, illuminate, integer_power
from minirt.vectors import Bools, Floats, dot, norm, unit
from reference.mutants.mutant import Mutant

#: 0.01° in radians, to first order in which the light is turned.
_HUNDREDTH_DEGREE = 0.01 * 3.14159265358979 / 180


def _light_not_negated(l: Floats) -> Floats:
    return l / norm(l)


def _light_turned(l: Floats) -> Floats:
    """Turned towards the axis that it is furthest from."""
    L = SLIDES.to_light(l)
    axis = np.zeros_like(L)
    axis[np.abs(L).argmin()] = 1.0
    return unit(L + _HUNDREDTH_DEGREE * unit(axis - dot(axis, L) * L))


def _no_epsilon(epsilon: float) -> float:
    return 0.0


def _epsilon_tenfold(epsilon: float) -> float:
    return 10.0 * epsilon


def _epsilon_large(epsilon: float) -> float:
    return 1e5 * epsilon


def _shadows_end(t: Floats, t0: Floats, t1: Floats) -> Bools:
    """Secondary rays are the ones with t0 > 0."""
    inside: Bools = SLIDES.in_interval(t, t0, np.where(t0 > 0, 1.0, t1))
    return inside


def _normal_as_it_is(s: Floats, delta: Floats) -> Floats:
    return s


def _black(surface: Surfaces, color: tuple[float, float, float] | None) -> Floats:
    return np.zeros_like(surface.ambient)


def _no_ambient(surface: Surfaces, light: Floats, *vectors: Floats) -> Floats:
    return illuminate(surface, light, *vectors) - surface.ambient


def _blinn(
    surface: Surfaces, light: Floats, to_light: Floats, s: Floats, delta: Floats, mirror: Floats
) -> Floats:
    facing = np.maximum(0.0, dot(s, to_light))
    half = np.where(facing > 0, np.maximum(0.0, dot(s, unit(to_light - delta))), 0.0)
    specular = surface.specular * integer_power(half, surface.shininess)
    return surface.ambient + light * (surface.diffuse * facing + specular)


def _shininess_off_by_one(
    surface: Surfaces, light: Floats, to_light: Floats, s: Floats, delta: Floats, mirror: Floats
) -> Floats:
    facing = np.maximum(0.0, dot(s, to_light))
    highlight = np.where(facing > 0, np.maximum(0.0, dot(mirror, -delta)), 0.0)
    specular = surface.specular * integer_power(highlight, surface.shininess + 1)
    return surface.ambient + light * (surface.diffuse * facing + specular)


def _local_not_reduced(
    local: Floats, mirrored: Floats, transmitted: Floats, k_r: Floats, k_t: Floats
) -> Floats:
    return local + k_r * mirrored + k_t * transmitted


def _shares_exchanged(
    local: Floats, mirrored: Floats, transmitted: Floats, k_r: Floats, k_t: Floats
) -> Floats:
    return SLIDES.combine(local, mirrored, transmitted, k_t, k_r)


def _local_alone(
    local: Floats, mirrored: Floats, transmitted: Floats, k_r: Floats, k_t: Floats
) -> Floats:
    return local


def _no_secondary_light(
    local: Floats, mirrored: Floats, transmitted: Floats, k_r: Floats, k_t: Floats
) -> Floats:
    return SLIDES.combine(local, 0.0 * mirrored, 0.0 * transmitted, k_r, k_t)


MUTANTS = (
    Mutant("light-not-negated", "S12", "with l in the place of −l",
           "l is where the light travels to; the shadow ray goes where it comes from.",
           "shadow", SLIDES.replace(to_light=_light_not_negated)),
    Mutant("light-turned-by-0.01-degrees", "S12", "with the light turned by 0.01°",
           "A direction that went through rounded angles.",
           "shadow", SLIDES.replace(to_light=_light_turned)),
    Mutant("epsilon-zero", "S12", "with ε = 0",
           "The point's own surface is met again where rounding puts it behind: speckles.",
           "shadow", SLIDES.replace(start_of_secondary=_no_epsilon)),
    Mutant("epsilon-tenfold", "S12", "with ε ten times too large",
           "Only what is nearer than a hundred-thousandth of the scene goes unseen.",
           "shadow", SLIDES.replace(start_of_secondary=_epsilon_tenfold)),
    Mutant("epsilon-large", "S12", "with ε a tenth of the scene's size",
           "Speckles were cured by a larger ε: shadows leave the points of contact.",
           "shadow", SLIDES.replace(start_of_secondary=_epsilon_large)),
    Mutant("secondary-rays-end-at-1", "S12", "with t ∈ [ε, 1] for secondary rays",
           "For a lamp at a point t = 1 is the lamp; for a direction t goes on to ∞.",
           "shadow", SLIDES.replace(in_interval=_shadows_end)),
    Mutant("normal-not-turned-to-viewer", "S13", "with the normal not turned to the viewer",
           "A surface seen from behind is lit by the light in front of it.",
           "colour", SLIDES.replace(toward_viewer=_normal_as_it_is)),
    Mutant("shadow-black", "S13", "with black for the shadow colour",
           "The ambient term belongs to points in shadow too.",
           "colour", SLIDES.replace(shadow_color=_black)),
    Mutant("no-ambient", "S13", "without the ambient term where it is lit",
           "It was taken for a light of its own, and left out.",
           "colour", SLIDES.replace(illuminate=_no_ambient)),
    Mutant("halfway-vector", "S13", "with Blinn's halfway vector",
           "The formula of many shading languages; its highlights are broader.",
           "colour", SLIDES.replace(illuminate=_blinn)),
    Mutant("shininess-off-by-one", "S13", "with the shininess larger by 1",
           "The loop of the power runs once too often.",
           "colour", SLIDES.replace(illuminate=_shininess_off_by_one)),
    Mutant("local-colour-not-reduced", "S7", "without the share 1 − k_r − k_t",
           "Mirrored and transmitted light was added on top of the local colour.",
           "colour", SLIDES.replace(combine=_local_not_reduced)),
    Mutant("shares-exchanged", "S7", "with k_r and k_t exchanged",
           "Both are numbers between 0 and 1, and arguments come in some order.",
           "colour", SLIDES.replace(combine=_shares_exchanged)),
    Mutant("local-colour-alone", "S7", "with the local colour alone",
           "Mirrors and glass are still to come: k_r and k_t are not used.",
           "colour", SLIDES.replace(combine=_local_alone)),
    Mutant("no-secondary-light", "S7", "without the light of reflected and refracted rays",
           "The shares are right, and nothing is added for them.",
           "colour", SLIDES.replace(combine=_no_secondary_light)),
)  # fmt: skip
