"""The algorithm's steps at one pixel, rule by rule, with their numbers."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from minirt.errors import InputError
from minirt.explain.candidates import candidate_steps
from minirt.explain.color import color_steps, local_step
from minirt.explain.steps import Step, Value, length_in_words, named, number, plain, vector
from minirt.hits import RayHits
from minirt.points import Branch, Points
from minirt.rays import Rays
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene
from minirt.vectors import Floats, column, dot, norm
from minirt.whitted import Whitted

Steps: TypeAlias = Iterator[Step]


@dataclass(frozen=True)
class Explanation:
    """How one pixel came about.

    Attributes
    ----------
    scene : str
        The scene's name.
    column, row : int
        From the left, and from the TOP of the image; from 0.
    steps : tuple of Step
    """

    scene: str
    column: int
    row: int
    steps: tuple[Step, ...]

    def to_dict(self) -> dict[str, Any]:
        """As JSON data; a number that is not finite is 'inf', '-inf' or 'nan'."""
        steps = [{**vars(step), "values": plain(step.values)} for step in self.steps]
        return {"scene": self.scene, "column": self.column, "row": self.row, "steps": steps}


def explain(scene: Scene, column: int, row: int, rules: Rules = SLIDES) -> Explanation:
    """What the algorithm does at one pixel; every number is, bit for bit, what `render` has.

    Parameters
    ----------
    scene : Scene
    column, row : int
        From the left, and from the TOP of the image; from 0.
    rules : Rules, optional

    Returns
    -------
    Explanation

    Raises
    ------
    InputError
        A pixel outside the image, or not a loaded scene.

    Examples
    --------
    >>> import minirt
    >>> steps = explain(minirt.load_scene("atlas:one-sphere"), 128, 96).steps
    >>> steps[0].rule, steps[0].title
    ('S1', 'the viewing frame')

    Source: S4.
    """
    whitted = Whitted(scene, rules)
    nx, ny = scene.screen.nx, scene.screen.ny
    for what, value, stop in (("column", column, nx), ("row", row, ny)):
        if not 0 <= value < stop:
            raise InputError(
                "the pixel lies outside the image",
                where=what,
                got=str(value),
                expected=f"0 to {stop - 1}",
            )
    steps = _steps(whitted, column, ny - 1 - row)
    return Explanation(scene.name, column, row, tuple(steps))


def _steps(whitted: Whitted, i: int, j: int) -> Steps:
    d = yield from _ray_steps(whitted, i, j)
    rays = Rays.of(column(whitted.scene.screen.P0), d)
    hits = whitted.first_hits(rays)
    yield from candidate_steps(whitted, rays.P0, d, hits)
    yield _chosen_step(whitted, hits)
    points = whitted.points(rays, hits)
    if len(points.rays):
        yield _point_step(whitted, d, points)
        yield _normal_step(points, whitted)
        yield _shadow_step(whitted, points)
        yield _reflection_step(whitted, points)
        yield from _refraction_steps(whitted, points)
        yield local_step(whitted, points)
    yield from color_steps(whitted, rays, hits)


def _ray_steps(whitted: Whitted, i: int, j: int) -> Generator[Step, None, Floats]:
    """The steps of S1, S2, S3 and S5; returns d (3, 1)."""
    screen, rules = whitted.scene.screen, whitted.rules
    frame = rules.view_frame(screen)
    yield Step(
        "S1",
        "the viewing frame",
        f"The observer is at P0; the screen lies in the plane n = {screen.nu:.6g}.",
        {name: getattr(screen, name) for name in ("P0", "u", "v", "n", "nu", "l", "r", "b", "t")},
    )
    u_s, v_s = rules.pixel_center(screen, np.array([float(i)]), np.array([float(j)]))
    yield Step(
        "S2",
        "the pixel's centre",
        f"Column {i} from the left, row {j} from the bottom, half a pixel further each.",
        {"i": i, "j": j, "u": number(u_s), "v": number(v_s), "n": screen.nu},
    )
    across = rules.model_from_view(frame, u_s, v_s)
    d: Floats = rules.ray_direction(across)
    point = column(screen.P0) + across
    yield Step(
        "S3",
        "in modelling coordinates",
        "The change-of-frame matrix takes the pixel's centre to P.",
        {"P": vector(point), "P - P0": vector(across)},
    )
    length = norm(d)
    yield Step(
        "S5",
        "the ray",
        f"r(t) = P0 + t·d with d = P − P0, {length_in_words(number(length))}; t = 1 at the screen.",
        {"P0": screen.P0, "d": vector(d), "ray": vector(d / length), "length of d": number(length)},
    )
    return d


def _chosen_step(whitted: Whitted, hits: RayHits) -> Step:
    if hits.object[0] < 0:
        sentence = "Nothing is hit: the pixel shows the background."
    else:
        sentence = f"The smallest t is {number(hits.t):.6g}: {named(whitted, hits)}."
    values = {"hit": bool(hits.object[0] >= 0), **_hit_values(hits), "t": number(hits.t)}
    return Step("S4", "the first object hit", sentence, values)


def _point_step(whitted: Whitted, d: Floats, points: Points) -> Step:
    t, rules = points.hits.t, whitted.rules
    depth = number(rules.depth_of(t, whitted.scene.screen.nu))
    return Step(
        "S5",
        "the point",
        f"The ray is at M = P0 + t·d, {depth:.6g} deep.",
        {
            "t": number(t),
            "depth": depth,
            "distance": number(rules.distance_of(t, norm(d))),
            "position": vector(points.M),
            "barycentric": (number(points.hits.beta), number(points.hits.gamma)),
        },
    )


def _normal_step(points: Points, whitted: Whitted) -> Step:
    thing = whitted.scene.objects[int(points.hits.object[0])]
    rule = {"sphere": "S8", "polygon": "S10"}.get(thing.type, "S9")
    behind = number(dot(points.normal, points.delta)) > 0
    side = "inside, so that it is turned for shading" if behind else "outside"
    return Step(
        rule,
        "the normal",
        f"The unit normal s points outward; the ray arrives from the {side}.",
        {"normal": vector(points.normal), "from inside": behind},
    )


def _shadow_step(whitted: Whitted, points: Points) -> Step:
    rays = whitted.secondary_rays(points, whitted.to_light)
    blocker = whitted.first_hits(rays)
    dark = bool(whitted.shadow(points)[0])
    sentence = f"M is in shadow of {named(whitted, blocker)}." if dark else "M is lit: RT gives ∅."
    values: dict[str, Value] = {
        "shadow": int(dark),
        "-l": vector(rays.d),
        "epsilon": number(rays.t0),
    }
    values |= {**_hit_values(blocker), "t": number(blocker.t)}
    return Step("S12", "the shadow ray", sentence, values)


def _reflection_step(whitted: Whitted, points: Points) -> Step:
    back = whitted.reflected(points)
    return Step(
        "S14",
        "the reflected ray",
        f"ρ = δ − 2(δ·s)s meets {named(whitted, back.hits)}.",
        {"delta": vector(points.delta), **_branch_values("reflection", back)},
    )


def _refraction_steps(whitted: Whitted, points: Points) -> Steps:
    if len(points.refractive):
        yield _snell_step(whitted, points)
        yield _refracted_step(whitted, points)


def _snell_step(whitted: Whitted, points: Points) -> Step:
    cosine = number(dot(points.delta, points.s))
    leaving = cosine > 0
    nu, nu_t = whitted.rules.indices(points.material.ior, np.array([leaving]))
    sine = math.sqrt(max(0.0, 1.0 - cosine * cosine))
    bent = sine * number(nu) / number(nu_t)
    values = {"nu": number(nu), "nu_t": number(nu_t), "theta": math.degrees(math.asin(sine))}
    if bent > 1:
        outcome = f"sin φ = {bent:.6g} > 1 has no answer."
    else:
        values["phi"] = math.degrees(math.asin(min(1.0, bent)))
        outcome = f"φ = {values['phi']:.6g}°."
    way = "leaves" if leaving else "enters"
    sentence = f"The ray {way} the object at θ = {values['theta']:.6g}°; {outcome}"
    return Step("S15", "Snell's law", sentence, values)


def _refracted_step(whitted: Whitted, points: Points) -> Step:
    through = whitted.refracted(points)
    tir = bool(np.isnan(through.direction[0, 0]))
    sentence = "Total internal reflection: there is no refracted ray (E2)."
    if not tir:
        sentence = f"ϱ, with s turned along δ (E1), meets {named(whitted, through.hits)}."
    return Step(
        "S16",
        "the refracted ray",
        sentence,
        {"tir": int(tir), **_branch_values("refraction", through)},
    )


def _hit_values(hits: RayHits) -> dict[str, Value]:
    return {"object": int(hits.object[0]), "triangle": int(hits.triangle[0])}


def _branch_values(name: str, branch: Branch) -> dict[str, Value]:
    return {
        name: vector(branch.direction),
        f"{name}_object": int(branch.hits.object[0]),
        f"{name}_t": number(branch.length),
    }
