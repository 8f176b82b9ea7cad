"""The error of an implementation that states only the number format in which it computes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from converters.placement import IDENTITY, Placement, reach
from minirt.errors import InputError
from minirt.geometry import Geometry
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.source import AlongRay, Declared

Precision = Literal["float64", "float32", "half"]

#: Largest relative errors of rounding to the formats.
ROUNDING: dict[Precision, float] = {"float64": 2.0**-53, "float32": 2.0**-24, "half": 2.0**-11}
#: Half the spacing of numbers that are too small for the formats' relative error.
_LEAST: dict[Precision, float] = {"float64": 2.0**-1075, "float32": 2.0**-150, "half": 2.0**-25}
#: Rays are not traced in half precision: such frames were computed in float32.
_COMPUTED: dict[Precision, Precision] = {
    "float64": "float64", "float32": "float32", "half": "float32",
}  # fmt: skip
#: Number of roundings at the scale of the scene up to a hit, and of a colour.
_STEPS, _COLOR_STEPS = 16, 64

#: Secondary rays that start within the errors would hit the surface that they leave. This many δ
#: along the ray avoid that at all angles above 1.3° with the surface: √2·δ/sin 1.3° = 62·δ.
_CLEAR = 64

_DERIVATION = (
    "{what}, u = {u:.3g}; R the largest coordinate, E the scene's extent, r the least radius. "
    "Rounding a point moves it by at most √3·u·R: the observer, and the vertices or the centre of "
    "what is met, 3·√3·u·R together; direction and intersection add {steps} roundings at the scale "
    "of E; {sphere}"
    "δ = {delta:.3g} scene units. {start}{handed}"
)

_SPHERE = {
    "float64": "the textbook's discriminant b² − 4ac moves a sphere's outline by 5·u·E²/r. ",
    "float32": "a sphere's discriminant is taken from the distance of its centre to the line. ",
}


@dataclass(frozen=True)
class Claim:
    """What the author of an implementation states about its errors.

    Attributes
    ----------
    precision : str
        The number format in which it computes, float64 or float32; half means computed in float32
        and written in half.
    delta : float or None
        A length in scene units, instead of the one that follows from the precision.
    start : float or None
        Where its secondary rays start along the ray, in scene units; None: at the scene's ε, or, if
        that is within the errors, well beyond them.
    handed : str
        The coarsest format through which its numbers reach us.
    """

    precision: Precision = "float64"
    delta: float | None = None
    start: float | None = None
    handed: Precision = "float64"


def declared(
    scene: Scene, claim: Claim, most: float | None = None, placement: Placement = IDENTITY
) -> Declared:
    """The bounds that follow from a claim on one scene.

    Parameters
    ----------
    scene : Scene
    claim : Claim
    most : float, optional
        The largest δ that is allowed, in scene units.
    placement : Placement
        From scene units to the coordinates in which the implementation computes and writes.

    Raises
    ------
    InputError
        The claim is wider than allowed, or not a length.
    """
    _require_lengths(delta=claim.delta, start=claim.start, max_delta=most)
    u = ROUNDING[_COMPUTED[claim.precision]]
    R = reach(scene, placement) / placement.scale
    delta = _delta(scene, u, R) if claim.delta is None else claim.delta
    if most is not None and delta > most:
        raise InputError(
            "the declared error is wider than allowed",
            where=scene.name[:80],
            got=f"δ = {delta:.3g} scene units",
            expected=f"at most {most:.3g}",
        )
    vertex, angle = math.sqrt(3) * u * R, _STEPS * u
    if claim.delta is not None:
        vertex, angle = delta, max(angle, delta / scene.extent)
    coarsest = max(claim.precision, claim.handed, key=ROUNDING.__getitem__)
    handed = 0.0 if coarsest == "float64" else ROUNDING[coarsest]
    start = _start(scene, claim, delta)
    return Declared(
        delta=delta,
        vertex=vertex,
        angle=angle,
        color=max(_COLOR_STEPS * u, angle) + math.sqrt(3) * handed,
        start=start,
        derivation=_derivation(claim, u, delta, start, handed),
        grain=handed,
        steps=_steps(scene, handed, R, _LEAST[coarsest]) if handed else (),
        watertight=False,
    )


def _require_lengths(**claimed: float | None) -> None:
    for name, length in claimed.items():
        if length is not None and not (0 <= length < math.inf):
            raise InputError(
                "not a length", where=f"--{name.replace('_', '-')}", got=f"{length:g}",
                expected="a finite number, at least 0",
            )  # fmt: skip


def _delta(scene: Scene, u: float, R: float) -> float:
    """δ in a format of rounding u.

    The textbook's b² − 4ac moves a sphere's outline by 5·u·E²/r. In float64 that is negligible and
    allowed. In float32 it is up to a pixel: such an implementation must compute Δ from the distance
    between centre and line (E8), or declare more.
    """
    E, least = scene.extent, float(Geometry.of(scene).spheres.radius.min(initial=np.inf))
    textbook = 5 * E * E / least if u == ROUNDING["float64"] else 0.0
    return u * (3 * math.sqrt(3) * R + _STEPS * E + textbook)


def _start(scene: Scene, claim: Claim, delta: float) -> AlongRay | None:
    """Where secondary rays start: at an ε within the errors they would hit their own surface."""
    if claim.start is not None:
        return AlongRay(claim.start)
    return None if _CLEAR * delta <= scene.epsilon else AlongRay(_CLEAR * delta)


def _steps(scene: Scene, u: float, R: float, least: float) -> tuple[tuple[str, float], ...]:
    """Absolute errors of a format with relative error u, or `least` near zero.

    A position's components are at most R, the largest coordinate that is hit; a secondary ray's
    length at most 2·E in a scene whose extent is E; components of unit vectors and barycentric
    weights are at most 1. Depths, distances and colours have their relative error elsewhere.
    """
    sizes = {"position": R, "reflection_t": 2 * scene.extent, "refraction_t": 2 * scene.extent}
    unit = [n for n, q in QUANTITIES.items() if q.kind == "direction" or n == "barycentric"]
    sizes |= dict.fromkeys(unit, 1.0) | dict.fromkeys(("depth", "distance", "color"), 0.0)
    return tuple(
        (name, math.sqrt(QUANTITIES[name].components) * max(u * s, least))
        for name, s in sizes.items()
    )


def _derivation(claim: Claim, u: float, delta: float, start: AlongRay | None, handed: float) -> str:
    begins = "" if start is None else f"Secondary rays start at {start.length:.3g} along the ray. "
    via = f"Numbers are handed over with a relative error of {handed:.3g}." if handed else ""
    if claim.delta is not None:
        return f"declared: δ = {delta:.3g} scene units. {begins}{via}".rstrip()
    what = _COMPUTED[claim.precision]
    return _DERIVATION.format(
        what=what, u=u, steps=_STEPS, sphere=_SPHERE[what], delta=delta, start=begins, handed=via
    ).rstrip()
