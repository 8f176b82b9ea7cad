"""S7 and S13 for one ray: the terms of Phong's formula, and the tree of rays with its colours."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from minirt.explain.steps import Step, Value, named, number, vector
from minirt.hits import RayHits
from minirt.points import Branch, Points
from minirt.rays import Rays
from minirt.shading import in_total_reflection
from minirt.vectors import Floats, column, dot
from minirt.whitted import Whitted

#: Most rays of the tree that are explained; the others contribute to the colour without a step.
MAX_RAYS = 63


def local_step(whitted: Whitted, points: Points) -> Step:
    """S13: the local colour at the only point, term by term.

    Parameters
    ----------
    whitted : Whitted
    points : Points
        A single point.

    Source: S13.
    """
    dark = whitted.shadow(points)
    local, surface = whitted.local_color(points, dark), points.material
    s = whitted.rules.toward_viewer(points.s, points.delta)
    mirror = whitted.rules.reflect(-whitted.to_light, s)
    facing = number(dot(s, whitted.to_light))
    if dark[0]:
        given = whitted.scene.shadow_color is not None
        sentence = "In shadow: " + ("the scene's shadow colour." if given else "ambient alone.")
    else:
        sentence = "Lit: ambient + light ∘ (diffuse · s·L + specular · (ρ·(−δ))^shininess)."
    values: dict[str, Value] = {
        "ambient": vector(surface.ambient),
        "diffuse": vector(surface.diffuse),
        "specular": vector(surface.specular),
        "shininess": int(surface.shininess[0]),
        "s·L": facing,
        "ρ(−L)·(−δ)": number(dot(mirror, -points.delta)),
        "local": vector(local),
        "alpha": number(surface.alpha),
    }
    return Step("S13", "the local colour", sentence, values)


def color_steps(whitted: Whitted, rays: Rays, hits: RayHits) -> Iterator[Step]:
    """S7: a step for the colour of the ray, then one for each ray it spawns, depth first.

    Parameters
    ----------
    whitted : Whitted
    rays : Rays
        A single ray.
    hits : RayHits
        What it meets.

    Source: S7.
    """
    steps: list[Step] = []
    _color(whitted, rays, hits, 0, "primary", steps)
    return iter(steps[:MAX_RAYS])


def _color(
    whitted: Whitted, rays: Rays, hits: RayHits, generation: int, kind: str,
    steps: list[Step],
) -> Floats:  # fmt: skip
    """The colour (3, 1) of a ray; inserts its step in front of those of the rays it spawns."""
    place = len(steps)
    points = whitted.points(rays, hits)
    if len(points.rays):
        color, sentence, values = _color_at(whitted, points, generation, steps)
    else:
        color, values = column(whitted.scene.background), {}
        sentence = "It brings the background."
    title = "the pixel's colour" if kind == "primary" else f"generation {generation}, {kind}"
    entry = {"generation": generation, "kind": kind, "color": vector(color), **values}
    sentence = f"The {kind} ray meets {named(whitted, hits)}. {sentence}"
    steps.insert(place, Step("S7", title, sentence, entry))
    return color


def _color_at(
    whitted: Whitted, points: Points, generation: int, steps: list[Step]
) -> tuple[Floats, str, dict[str, Value]]:
    material = points.material
    through = whitted.refracted(points) if material.transmittance[0] > 0 else None
    total = np.array([through is not None and bool(np.isnan(through.direction[0, 0]))])
    k_r, k_t = in_total_reflection(material.reflectance, material.transmittance, total)
    mirrored = transmitted = np.zeros((3, 1))
    last = generation >= whitted.scene.max_depth
    if k_r[0] > 0 and not last:
        back = whitted.reflected(points)
        mirrored = _branch_color(whitted, back, generation, "reflected", steps)
    if through is not None and k_t[0] > 0 and not last:
        transmitted = _branch_color(whitted, through, generation, "refracted", steps)
    local = whitted.local_color(points, whitted.shadow(points))
    color = whitted.rules.combine(local, mirrored, transmitted, k_r, k_t)
    shares = number(1.0 - k_r - k_t), number(k_r), number(k_t)
    sentence = "Colour = {:.4g}·local + {:.4g}·C(ρ) + {:.4g}·C(ϱ).".format(*shares)
    if last and shares[0] < 1:
        sentence += " Beyond max_depth rays bring black."
    values: dict[str, Value] = {"shares": shares, "local": vector(local)}
    return color, sentence, {**values, "C(ρ)": vector(mirrored), "C(ϱ)": vector(transmitted)}


def _branch_color(
    whitted: Whitted, branch: Branch, generation: int, kind: str, steps: list[Step]
) -> Floats:
    return _color(whitted, branch.rays, branch.hits, generation + 1, kind, steps)
