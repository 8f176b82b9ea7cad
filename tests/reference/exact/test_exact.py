"""The judge: its balls hold the truth, and planted faults do not stand before it.

minirt itself comes before it in test_verify_atlas.py.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb

import minirt
from minirt.frame import Frame
from minirt.rules import SLIDES
from minirt.scene import Scene
from minirt.shapes.polygon import PolygonHits, polygon_hit
from minirt.shapes.sphere import sphere_quadratic, sphere_roots
from minirt.vectors import Bools, Floats, dot
from reference.compare.comparison import Comparison
from reference.exact import JUDGED, Judgement, judge_pixels, pixels_to_judge
from reference.exact.balls import known, precision
from reference.exact.condition import ULP
from reference.exact.pixel import exact_pixels, exact_ray
from reference.exact.sampling import SAMPLE
from reference.exact.shapes import (
    Answer,
    Ray,
    intersect_polygon,
    intersect_sphere,
    intersect_triangle,
)
from reports.results.record import judgement_model
from reports.results.words import judgement_in_words

SCREEN: dict[str, Any] = {
    "P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
    "l": -0.4, "r": 0.4, "b": -0.3, "t": 0.3, "nx": 32, "ny": 24,
}  # fmt: skip


def scene(*objects: dict[str, Any], **changes: Any) -> Scene:
    document = {
        "minirt": 1, "name": "test", "screen": SCREEN, "light": {"direction": [-1, -2, -3]},
        "materials": {"red": {"diffuse": [0.8, 0.1, 0.3]}, "glass": {"ior": 1.5}},
        "objects": list(objects),
    }  # fmt: skip
    return minirt.load_scene(document | changes)


def small(name: str) -> Scene:
    """A scene of the atlas at 64 × 48: a rule that is replaced is asked about every pair."""
    document = minirt.load_scene(f"atlas:{name}").to_dict()
    document["screen"] |= {"nx": 64, "ny": 48}
    return minirt.load_scene(document)


def ball(center: Iterable[float] = (0, 0, 0), radius: float = 1.0, material: str = "red") -> Any:
    return {"type": "sphere", "material": material, "center": list(center), "radius": radius}


def square(z: float, half: float = 2.0) -> dict[str, Any]:
    corners = [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]]
    return {"type": "polygon", "material": "red", "vertices": corners}


def every_pixel(of: Scene) -> list[tuple[int, int]]:
    return [divmod(k, of.screen.nx) for k in range(of.screen.nx * of.screen.ny)]


def by_name(judgement: Judgement) -> dict[str, tuple[int, int, int]]:
    return {c.quantity: (c.judged, c.decided, c.agreed) for c in judgement.counts}


# -- planted faults --------------------------------------------------------------------------------


def far_root(near: Floats, far: Floats, near_counts: Bools, far_counts: Bools) -> Floats:
    return np.where(far_counts, far, np.where(near_counts, near, np.inf))


def size_of_delta(P0: Floats, d: Floats, C: Floats, R: Floats) -> tuple[Floats, Floats]:
    a, b, _, quarter = sphere_quadratic(P0, d, C, R)
    root = np.sqrt(np.abs(quarter))
    return (b - root) / a, (b + root) / a


def drifting(P0: Floats, d: Floats, C: Floats, R: Floats) -> tuple[Floats, Floats]:
    near, far = sphere_roots(P0, d, C, R)
    return near * (1 + 1e-9), far * (1 + 1e-9)


def literal_refraction(delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
    """S16 with s on the incident side, as the slide draws it (E1)."""
    s = np.where(dot(delta, s) > 0, -s, s)
    cosine, ratio = dot(delta, s), nu / nu_t
    radicand = 1 - ratio * ratio * (1 - cosine * cosine)
    root = np.sqrt(np.where(radicand < 0, np.nan, radicand))
    return np.asarray(ratio * delta + (root - ratio * cosine) * s)


def short_fan(P0: Floats, d: Floats, corners: Any, normals: Floats, *rest: Any) -> PolygonHits:
    few = slice(0, max(1, normals.shape[1] - 1))
    return polygon_hit(P0, d, tuple(c[:, few] for c in corners), normals[:, few], *rest)


FAULTS: dict[str, tuple[str, Callable[..., Any], set[str]]] = {
    "the far root": ("smallest_root", far_root, {"t", "position"}),
    "the size of Δ": ("sphere", size_of_delta, {"hit", "object"}),
    "a drift of 1e-9": ("sphere", drifting, {"t", "position"}),
    "the slide's refraction": ("refract", literal_refraction, {"refraction"}),
    "no ε": ("start_of_secondary", lambda epsilon: 0.0, {"shadow", "reflection_object"}),
    "no last triangle": ("polygon", short_fan, {"hit", "object", "triangle"}),
    "no half pixel": (
        "pixel_center",
        lambda s, i, j: (s.l + (s.r - s.l) / s.nx * i, s.b + (s.t - s.b) / s.ny * j),
        {"t", "position"},
    ),
    "the light from below": ("to_light", lambda l: l / np.sqrt(dot(l, l)), {"shadow"}),
    "a reflection back": ("reflect", lambda delta, s: -delta, {"reflection"}),
    "total reflection ignored": (
        "refract",
        lambda delta, s, nu, nu_t: delta,
        {"tir", "refraction"},
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_convicted(name: str) -> None:
    rule, wrong, quantities = FAULTS[name]
    of = small("inside-glass" if name == "total reflection ignored" else "glass-ball")
    frame = minirt.render(of, SLIDES.replace(**{rule: wrong}), quantities=JUDGED)
    judgement = judge_pixels(of, frame, pixels_to_judge(of, {}))
    assert quantities <= {opinion.quantity for opinion in judgement.convictions}
    assert "contradicts minirt" in judgement_in_words(judgement)


@pytest.mark.parametrize(
    ("quantity", "value"),
    [("t", np.nan), ("t", np.inf), ("shadow", 1), ("object", 7), ("normal", np.nan)],
)
def test_one_wrong_value_is_convicted_and_nothing_else(quantity: str, value: float) -> None:
    of = scene(ball())
    frame = minirt.render(of, quantities=JUDGED)
    spoilt = {name: values.copy() for name, values in frame.arrays.items()}
    spoilt[quantity][12, 16] = value
    (opinion,) = judge_pixels(of, Frame(spoilt), every_pixel(of)).convictions
    assert (opinion.quantity, opinion.row, opinion.column) == (quantity, 12, 16)
    assert opinion.exact != opinion.ours


# -- what is certain -------------------------------------------------------------------------------


def test_two_surfaces_in_one_place_are_open_and_nothing_else_is() -> None:
    of = scene(square(0.0), square(0.0))
    judgement = judge_pixels(of, minirt.render(of), every_pixel(of))
    total = 32 * 24
    assert by_name(judgement)["hit"] == (total, total, total)
    assert by_name(judgement)["object"] == (total, 0, 0)
    assert by_name(judgement)["t"] == (total, 0, 0)
    assert judgement.convictions == ()


def test_a_ray_through_a_diagonal_hits_the_polygon_in_an_open_triangle() -> None:
    of = scene(square(0.0), screen=SCREEN | {"l": -0.3, "nx": 7, "ny": 7, "r": 0.3})
    judgement = judge_pixels(of, minirt.render(of), every_pixel(of))
    assert by_name(judgement)["object"] == (49, 49, 49)
    assert by_name(judgement)["triangle"] == (49, 42, 42)


def test_a_ray_along_an_edge_is_open() -> None:
    corners = [[0, -1, 0], [3, -1, 0], [0, 3, 0]]
    triangle = {"type": "triangle", "material": "red", "vertices": corners}
    of = scene(triangle, screen=SCREEN | {"nx": 31})
    judgement = judge_pixels(of, minirt.render(of), every_pixel(of))
    # the middle column, but for its 4 pixels below the edge's end: y < −1 at 1/8 a row from −1.5
    certain = 30 * 24 + 4
    assert by_name(judgement)["hit"] == (31 * 24, certain, certain)


def test_a_tangent_ray_is_open() -> None:
    of = scene(ball((1, 0, 0)), screen=SCREEN | {"nx": 31})
    ray = Ray(known((0, 0, 5)), known((0, 0, -1)), 0.0)
    with precision():
        assert intersect_sphere(ray, known((1, 0, 0)), arb(1)).answer is Answer.OPEN
        assert intersect_sphere(ray, known((1, 0, 0)), arb(1 + 1e-14)).answer is Answer.YES
        assert intersect_sphere(ray, known((1, 0, 0)), arb(1 - 1e-14)).answer is Answer.NO
    assert judge_pixels(of, minirt.render(of), every_pixel(of)).convictions == ()


def test_a_degenerate_triangle_is_never_met() -> None:
    line = [[-1, 0, 0], [0, 0, 0], [1, 0, 0]]
    of = scene({"type": "triangle", "material": "red", "vertices": line})
    judgement = judge_pixels(of, minirt.render(of), every_pixel(of))
    assert by_name(judgement)["hit"] == (768, 768, 768)
    assert by_name(judgement)["object"] == (768, 768, 768)


def test_an_empty_scene_is_certain_everywhere() -> None:
    of = scene()
    judgement = judge_pixels(of, minirt.render(of), every_pixel(of))
    assert by_name(judgement)["hit"] == (768, 768, 768)
    assert judgement.worst is None


# -- exactness -------------------------------------------------------------------------------------


def test_d_is_the_rational_that_the_scene_says() -> None:
    of = minirt.load_scene("atlas:left-handed-frame")
    s = of.screen
    ray = exact_ray(s, 3, 5)
    third = Fraction(s.l) + (Fraction(s.r) - Fraction(s.l)) / s.nx * Fraction(11, 2)
    up = Fraction(s.b) + (Fraction(s.t) - Fraction(s.b)) / s.ny * (s.ny - 4 + Fraction(1, 2))
    for k in range(3):
        exact = Fraction(s.u[k]) * third + Fraction(s.v[k]) * up + Fraction(s.n[k]) * Fraction(s.nu)
        assert Fraction(int(ray.d[k].p), int(ray.d[k].q)) == exact


def test_t_of_a_sphere_seen_along_an_axis_is_known() -> None:
    """P0 at 5, a unit sphere at the origin, the ray through the middle: t = 4."""
    of = scene(ball(), screen=SCREEN | {"nx": 1, "ny": 1})
    with precision():
        (pixel,) = exact_pixels(of, [(0, 0)])
    assert pixel.solution is not None
    assert pixel.solution.t == 4
    # κ = 1 + (n·P0 + n·C + t·n·d + R²) / (n·d·t) with n = (0, 0, 1): (5 + 0 + 4 + 1) / 4
    assert float(pixel.solution.condition) == 1 + 10 / 4
    assert pixel.values["reflection_object"] == -1
    assert "tir" not in pixel.values


def test_balls_hold_what_any_rounding_of_the_inputs_gives() -> None:
    """t of kernels fed with numbers up to 4 ulp away lies in the ball: 600 rays, three shapes."""
    rng = np.random.default_rng(3)
    inside = 0
    for _ in range(200):
        P0, d = rng.normal(size=3) * 5, rng.normal(size=3)
        M = P0 + rng.uniform(0.5, 3) * d
        corners = M + rng.normal(size=(2, 3))
        corners = np.stack((*corners, 3 * M - corners.sum(axis=0)))
        moves = 1 + rng.uniform(-4, 4, (5, 3)) * ULP
        ray = Ray(known(P0), known(d), 0.0)
        P, e = (P0 * moves[0]).reshape(3, 1), (d * moves[1]).reshape(3, 1)
        a, b, c = (corners * moves[2:])[:, :, None]
        C, R = M + 0.3 * rng.normal(size=3), 2.0
        with precision():
            normal = [arb(x, 1e-12) for x in np.cross(corners[1] - corners[0], corners[2] - M)]
            rows = [known(row) for row in corners]
            ball_ = intersect_sphere(ray, known(C), known([R])[0])
            near = minirt.intersect_sphere(P, e, (C * moves[2])[:, None], np.array([R])).near[0]
            far = minirt.intersect_sphere(P, e, (C * moves[2])[:, None], np.array([R])).far[0]
            if ball_.answer is Answer.YES:
                assert ball_.t.contains(arb(float(near if near > 0 else far)))
                inside += 1
            flat = intersect_triangle(ray, rows, normal, 0)
            assert flat.answer is not Answer.NO
            assert minirt.intersect_triangle(P, e, a, b, c).case[0] == 0
            many = intersect_polygon(ray, rows, normal)
            assert many.answer is flat.answer
    assert inside > 150


# -- which pixels ----------------------------------------------------------------------------------


def test_dissenting_and_worst_pixels_are_judged_and_the_sample_is_seeded() -> None:
    of = minirt.load_scene("atlas:one-sphere")
    ratio = np.zeros((192, 256))
    ratio[7, 9], ratio[100:103, 40] = 0.9, np.nan
    wrong = np.where(np.arange(192 * 256).reshape(192, 256) % 9973 == 0, np.inf, 0.0)
    comparisons = {"a": Comparison((), {"t": ratio}), "b": Comparison((), {"hit": wrong})}
    pixels = pixels_to_judge(of, comparisons)
    assert (7, 9) in pixels
    assert set(zip(*np.nonzero(wrong), strict=True)) <= set(pixels)
    assert pixels == sorted(set(pixels)) == pixels_to_judge(of, comparisons)
    assert SAMPLE <= len(pixels) <= SAMPLE + 6
    assert pixels_to_judge(of, {}, seed=1) != pixels_to_judge(of, {})


def test_a_small_image_is_judged_whole() -> None:
    of = scene(ball(), screen=SCREEN | {"nx": 8, "ny": 6})
    assert pixels_to_judge(of, {}) == every_pixel(of)


def test_its_record_is_json() -> None:
    of = scene(ball())
    frame = minirt.render(of, SLIDES.replace(sphere=drifting))
    judgement = judge_pixels(of, frame, every_pixel(of))
    model = judgement_model(judgement)
    assert model is not None
    document = json.loads(model.model_dump_json())
    assert document["convicted"] == len(judgement.convictions) > len(document["convictions"]) == 20
    assert {"quantity": "hit", "judged": 768, "decided": 768, "agreed": 768, "ulps": None} in (
        document["counts"]
    )
