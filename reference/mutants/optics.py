"""Wrong versions of S14–S16: reflection, Snell's law, refraction."""

from __future__ import annotations

import numpy as np

from minirt.optics import refracted_direction, refractive_indices
from minirt.rules import SLIDES
from minirt.vectors import Bools, Floats, dot
from reference.mutants.mutant import Mutant


def _reflection_sign(delta: Floats, s: Floats) -> Floats:
    return delta + 2.0 * dot(delta, s) * s


def _projection_once(delta: Floats, s: Floats) -> Floats:
    return delta - dot(delta, s) * s


def _reversed(delta: Floats, s: Floats) -> Floats:
    return 2.0 * dot(delta, s) * s - delta


def _reflected_in_float32(delta: Floats, s: Floats) -> Floats:
    return SLIDES.reflect(delta, s).astype(np.float32).astype(np.float64)


def _indices_exchanged(ior: Floats, leaving: Bools) -> tuple[Floats, Floats]:
    nu, nu_t = refractive_indices(ior, leaving)
    return nu_t, nu


def _always_entering(ior: Floats, leaving: Bools) -> tuple[Floats, Floats]:
    return np.ones_like(ior), ior


def _index_rounded(ior: Floats, leaving: Bools) -> tuple[Floats, Floats]:
    return refractive_indices(ior * (1 + 1e-4), leaving)


def _incident_side(delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
    """The printed formula with δ·s ≤ 0."""
    cosine = dot(delta, s)
    s = np.where(cosine > 0, -s, s)
    cosine = -np.abs(cosine)
    ratio = nu / nu_t
    radicand = 1.0 - ratio * ratio * (1.0 - cosine * cosine)
    root = np.sqrt(np.where(radicand < 0, 0.0, radicand))
    return np.where(radicand < 0, np.nan, ratio * delta + (root - ratio * cosine) * s)


def _total_reflection_ignored(delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
    right = refracted_direction(delta, s, nu, nu_t)
    cosine = dot(delta, s)
    ratio = nu / nu_t
    along_surface = ratio * (delta - cosine * s)
    return np.where(np.isnan(right), along_surface, right)


def _outer_normal(delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
    """As if every ray came from the outside: s is turned inward, however δ goes."""
    cosine = -dot(delta, s)
    ratio = nu / nu_t
    radicand = 1.0 - ratio * ratio * (1.0 - cosine * cosine)
    root = np.sqrt(np.where(radicand < 0, 0.0, radicand))
    return np.where(radicand < 0, np.nan, ratio * delta - (root - ratio * cosine) * s)


def _ratio_not_squared(delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
    cosine = dot(delta, s)
    s = np.where(cosine <= 0, -s, s)
    cosine = np.abs(cosine)
    ratio = nu / nu_t
    radicand = 1.0 - ratio * (1.0 - cosine * cosine)
    root = np.sqrt(np.where(radicand < 0, 0.0, radicand))
    return np.where(radicand < 0, np.nan, ratio * delta + (root - ratio * cosine) * s)


def _straight_on(delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
    return np.where(np.isnan(refracted_direction(delta, s, nu, nu_t)), np.nan, delta)


MUTANTS = (
    Mutant("reflection-sign", "S14", "with + in the place of −",
           "The slide's projection (−δ·s)s has a minus of its own (E6).",
           "reflection", SLIDES.replace(reflect=_reflection_sign)),
    Mutant("reflection-without-2", "S14", "without the factor 2",
           "δ − (δ·s)s is the projection on the surface: the ray slides along it.",
           "reflection", SLIDES.replace(reflect=_projection_once)),
    Mutant("reflection-of-minus-delta", "S14", "with −δ in the place of δ",
           "Shading languages reflect the direction TO the viewer.",
           "reflection", SLIDES.replace(reflect=_reversed)),
    Mutant("reflection-in-float32", "S14", "with ρ rounded to float32",
           "One array of the default type of a graphics card, among others of float64.",
           "reflection", SLIDES.replace(reflect=_reflected_in_float32)),
    Mutant("indices-exchanged", "S15", "with ν and ν_t exchanged",
           "ν sin θ = ν_t sin φ was solved for the wrong angle.",
           "refraction", SLIDES.replace(indices=_indices_exchanged)),
    Mutant("index-not-inverted-on-leaving", "S15", "with the index not inverted on leaving",
           "Every hit was taken for an entry into the glass.",
           "refraction", SLIDES.replace(indices=_always_entering)),
    Mutant("index-off-by-1e-4", "S15", "with the index larger by a ten-thousandth",
           "A table of glasses with four digits.",
           "refraction", SLIDES.replace(indices=_index_rounded)),
    Mutant("s-on-the-incident-side", "S16", "with s on the incident side",
           "It is the slide's letter (E1), and sends the ray back where it came from.",
           "refraction", SLIDES.replace(refract=_incident_side)),
    Mutant("s-not-turned-on-leaving", "S16", "with s turned inward on leaving too",
           "The normal was turned for rays that enter; those that leave need the other one.",
           "refraction", SLIDES.replace(refract=_outer_normal)),
    Mutant("total-reflection-ignored", "S16", "with a negative radicand taken for 0",
           "It keeps the square root from failing, and glass lets light out at any angle.",
           "refraction", SLIDES.replace(refract=_total_reflection_ignored)),
    Mutant("ratio-not-squared", "S16", "with ν/ν_t not squared under the root",
           "√(1 − ν(1−(δ·s)²)/ν_t): one exponent is missing.",
           "refraction", SLIDES.replace(refract=_ratio_not_squared)),
    Mutant("refraction-straight-on", "S16", "with ϱ = δ",
           "Transparency without Snell's law: right at ν = ν_t only.",
           "refraction", SLIDES.replace(refract=_straight_on)),
)  # fmt: skip
