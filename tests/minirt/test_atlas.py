"""The atlas: every scene is whole, and a mistake in any rule that it lists changes its picture."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.frame import Array, Frame
from minirt.optics import refracted_direction
from minirt.quantities import QUANTITIES
from minirt.rules import SLIDES, Rules
from minirt.scene import Scene, Sphere
from minirt.scene_file.atlas import atlas_names
from minirt.screen import ViewFrame, VirtualScreen
from minirt.shading import Surfaces
from minirt.shapes.polygon import PolygonHits
from minirt.shapes.triangle import TriangleCase, TriangleHits
from minirt.vectors import Bools, Floats, dot, norm, unit
from tests.helpers.tiers import tiered

NAMES = atlas_names()
#: Pictures are compared at a smaller size; 2 pixels there are some 80 of the whole image.
NX, NY, LEAST_PIXELS = 40, 30, 2
#: float32's rounding, which one relative error of a right renderer may reach, times 16.
SAME = 2.0**-20


def document(name: str) -> dict[str, Any]:
    text = resources.files("minirt").joinpath("atlas", f"{name}.json").read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text)
    return found


@cache
def small(name: str) -> Scene:
    """The scene with fewer pixels of the same shape."""
    content = document(name)
    content["screen"] |= {"nx": NX, "ny": NY}
    return minirt.load_scene(content, str(resources.files("minirt").joinpath("atlas")))


@cache
def right(name: str) -> Frame:
    return minirt.render(small(name))


def changed_pixels(scene: Scene, one: Frame, other: Frame) -> int:
    """Pixels at which any quantity differs by more than rounding."""
    changed = np.zeros((NY, NX), dtype=np.bool_)
    for name in other:
        quantity = QUANTITIES[name]
        a, b = one[name].reshape(NY, NX, -1), other[name].reshape(NY, NX, -1)
        if quantity.discrete:
            same: Array = a == b
        else:
            slack = SAME * scene.extent if quantity.kind == "length" else SAME
            same = np.isclose(a, b, rtol=SAME, atol=slack, equal_nan=True)
        changed |= ~same.all(axis=2)
    return int(changed.sum())


# --- one mistake for each rule -------------------------------------------------------------------


def looking_back(screen: VirtualScreen) -> ViewFrame:
    return SLIDES.view_frame(screen)._replace(nu=-screen.nu)


def no_half_pixel(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
    u_s, v_s = SLIDES.pixel_center(screen, i - 0.5, j - 0.5)
    return u_s, v_s


def transposed(frame: ViewFrame, u_s: Floats, v_s: Floats) -> Floats:
    w = np.stack((u_s, v_s, np.full_like(u_s, frame.nu)))
    return np.stack([dot(axis, w) for axis in (frame.u, frame.v, frame.n)])


def lowest_number(t: Floats, object_: Array, triangle: Array, *best: Array) -> Bools:
    """Not the nearest hit, but that on the object that the scene names first."""
    return np.isfinite(t) & ((best[1] < 0) | (object_ < best[1]))


def behind_too(t: Floats, t0: Floats, t1: Floats) -> Bools:
    return np.isfinite(t) & (t <= t1)


def local_only(local: Floats, mirrored: Floats, passed: Floats, k_r: Floats, k_t: Floats) -> Floats:
    """What the reflected and the refracted ray bring is forgotten."""
    return (1.0 - k_r - k_t) * local


def far_root(near: Floats, far: Floats, near_counts: Bools, far_counts: Bools) -> Floats:
    return np.where(far_counts, far, np.inf)


def parallelogram(*given: Any) -> TriangleHits:
    """β + γ ≤ 1 forgotten."""
    hits = SLIDES.triangle(*given)
    inside = (hits.beta >= 0) & (hits.gamma >= 0) & (hits.beta <= 1) & (hits.gamma <= 1)
    inside &= hits.case != TriangleCase.NONE
    case = np.where(inside, TriangleCase.INSIDE, hits.case).astype(np.int32)
    return hits._replace(case=case)


def plane_through_origin(P0: Floats, d: Floats, P1: Floats, p: Floats) -> Floats:
    """The observer's position forgotten: P1·p / (d·p)."""
    return SLIDES.plane(np.zeros_like(P0), d, P1, p)


def short_fan(*given: Any) -> PolygonHits:
    """The last triangle of the fan left out."""
    hits = SLIDES.polygon(*given)
    last = hits.triangle == given[2][0].shape[1] - 1
    return hits._replace(
        t=np.where(last, np.inf, hits.t), triangle=np.where(last, -1, hits.triangle)
    )


def light_not_negated(travel: Floats) -> Floats:
    return unit(travel)


def flat_color(surface: Surfaces, *_: Any) -> Floats:
    return surface.ambient + surface.diffuse


def wrong_sign(delta: Floats, s: Floats) -> Floats:
    return delta + 2.0 * dot(delta, s) * s


def swapped(ior: Floats, leaving: Bools) -> tuple[Floats, Floats]:
    return SLIDES.indices(ior, ~leaving)


def unbent(delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
    return delta


def to_the_letter(delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
    """The slide's formula with its figure's s, on the incident side (E1)."""
    s = np.where(dot(delta, s) > 0, -s, s)
    cosine, ratio = dot(delta, s), nu / nu_t
    root = np.sqrt(np.maximum(0.0, 1.0 - ratio * ratio * (1.0 - cosine * cosine)))
    return unit(ratio * delta + (root - ratio * cosine) * s)


def never_total(delta: Floats, s: Floats, nu: Floats, nu_t: Floats) -> Floats:
    """Total internal reflection ignored: the ray goes on unbent (E2)."""
    bent = refracted_direction(delta, s, nu, nu_t)
    return np.where(np.isnan(bent), delta, bent)


def textbook_in_single(P0: Floats, d: Floats, C: Floats, R: Floats) -> tuple[Floats, Floats]:
    """−b ± √Δ with P0·P0 − 2P0·C + C·C multiplied out, in float32 (what E8 departs from)."""
    p, e, c = (np.asarray(v, dtype=np.float32) for v in (P0, d, C))  # type: Any, Any, Any
    a, b = dot(e, e), 2 * (dot(e, p) - dot(e, c))
    delta = b * b - 4 * a * (dot(p, p) - 2 * dot(p, c) + dot(c, c) - np.float32(R) ** 2)
    root = np.where(delta >= 0, np.sqrt(np.maximum(delta, 0)), np.nan)
    near, far = ((-b - root) / (2 * a)).astype(float), ((-b + root) / (2 * a)).astype(float)
    return np.where(np.isnan(near), np.inf, near), np.where(np.isnan(far), np.inf, far)


#: By rule: the mistake, and the quantities that show it first.
MISTAKES: dict[str, tuple[dict[str, Callable[..., Any]], tuple[str, ...]]] = {
    "S1": ({"view_frame": looking_back}, ("ray", "object")),
    "S2": ({"pixel_center": no_half_pixel}, ("ray",)),
    "S3": ({"model_from_view": transposed}, ("ray",)),
    "S4": ({"closer": lowest_number}, ("object",)),
    "S5": ({"ray_direction": unit}, ("t",)),
    "S6": ({"in_interval": behind_too}, ("hit", "t", "shadow", "reflection_object")),
    "S7": ({"combine": local_only}, ("color",)),
    "S8": ({"smallest_root": far_root}, ("t",)),
    "S9": ({"triangle": parallelogram}, ("object", "triangle")),
    "S10": ({"plane": plane_through_origin}, ("t",)),
    "S11": ({"polygon": short_fan}, ("object", "triangle")),
    "S12": ({"to_light": light_not_negated}, ("shadow",)),
    "S13": ({"illuminate": flat_color}, ("color",)),
    "S14": ({"reflect": wrong_sign}, ("reflection", "reflection_object")),
    "S15": ({"indices": swapped}, ("refraction",)),
    "S16": ({"refract": unbent}, ("refraction", "refraction_object")),
    "E1": ({"refract": to_the_letter}, ("refraction",)),
    "E2": ({"refract": never_total}, ("tir", "color")),
    "E8": ({"sphere": textbook_in_single}, ("t",)),
}
#: Scenes that take ten times as long as others.
LARGE = ("closed-mesh", "everything", "thousand-spheres")
#: S17 is the lecture's exercises: they have tests of their own below.
LISTED = [(name, rule) for name in NAMES for rule in document(name)["rules"] if rule != "S17"]


@pytest.mark.parametrize(("name", "rule"), tiered(LISTED, lambda case: case[0] not in LARGE))
def test_a_mistake_in_a_listed_rule_changes_the_picture(name: str, rule: str) -> None:
    scene, (mistake, shown_by) = small(name), MISTAKES[rule]
    with np.errstate(all="ignore"):
        wrong = minirt.render(scene, SLIDES.replace(**mistake), shown_by)
    assert changed_pixels(scene, right(name), wrong) >= LEAST_PIXELS


def test_the_same_rules_change_nothing() -> None:
    again = minirt.render(small("everything"))
    assert changed_pixels(small("everything"), right("everything"), again) == 0


def test_each_mistake_is_in_the_rule_that_it_stands_for() -> None:
    for rule, (mistake, _) in MISTAKES.items():
        numbers = {Rules.number(name) for name in mistake}
        assert numbers == {{"E1": "S16", "E2": "S16", "E8": "S8"}.get(rule, rule)}


@pytest.mark.parametrize("name", NAMES)
def test_scene_is_whole(name: str) -> None:
    scene = minirt.load_scene(f"atlas:{name}")
    assert scene.name == name
    assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name)
    assert (scene.screen.nx, scene.screen.ny) == (256, 192)
    assert 30 <= len(scene.about) <= 130
    assert "\n" not in scene.about
    for paragraph in (scene.proves, scene.failure_means):
        assert 100 <= len(paragraph) <= 700
        assert paragraph.endswith(".")
        assert 2 <= len(re.findall(r"[.!?](?= |$)", paragraph)) <= 5
    assert len(set(scene.rules)) == len(scene.rules) >= 2
    assert scene.floor is None or 0 < scene.floor[0] < 0.99


@pytest.mark.parametrize("name", NAMES)
def test_picture_is_worth_looking_at(name: str) -> None:
    frame = right(name)
    assert frame["hit"].any() != (name == "nothing-hit")
    assert frame["color"].min() >= 0
    assert np.isfinite(frame["color"]).all()
    objects = np.unique(frame["object"])
    assert name == "nothing-hit" or len(objects) >= 2
    rules = small(name).rules
    if "S12" in rules:
        assert min((frame["shadow"] == value).sum() for value in (0, 1)) >= LEAST_PIXELS
    if "S16" in rules:
        assert np.isfinite(frame["refraction"]).all(axis=2).sum() >= LEAST_PIXELS
        assert (frame["refraction_object"] >= 0).sum() >= LEAST_PIXELS
    if "S14" in rules:
        assert (frame["reflection_object"] >= 0).sum() >= LEAST_PIXELS


def test_atlas_covers_every_rule_twice() -> None:
    assert len(NAMES) >= 28
    count = Counter(rule for name in NAMES for rule in document(name)["rules"])
    required = [f"S{k}" for k in range(1, 17)] + ["E1", "E2"]
    assert {rule: count[rule] for rule in required if count[rule] < 2} == {}
    assert sum("floor" in document(name) for name in NAMES) <= 4


def test_total_reflection_is_seen_directly_in_three_scenes() -> None:
    seen = [name for name in NAMES if (right(name)["tir"] == 1).sum() >= LEAST_PIXELS]
    assert len(seen) >= 3


def test_colours_that_any_path_tracer_confirms() -> None:
    """Diffuse and mirrors alone, before black: at least five scenes."""

    def plain(scene: Scene) -> bool:
        used = [scene.material_of(k) for k in range(len(scene.objects))]
        diffuse = (m.reflectance == 0 and not any((*m.ambient, *m.specular)) for m in used)
        mirror = (m.reflectance == 1 for m in used)
        pairs = zip(diffuse, mirror, used, strict=True)
        return not any(scene.background) and all((d or r) and m.ior is None for d, r, m in pairs)

    assert sum(plain(small(name)) for name in NAMES) >= 5


FOUR_TIMES = {
    "ball-on-quad-millimetres": (1e-3, 0.0),
    "ball-on-quad-ten-kilometres": (1e4, 0.0),
    "ball-on-quad-far-away": (1.0, 1e5),
}


@pytest.mark.parametrize("name", FOUR_TIMES)
def test_unit_and_place_change_lengths_only(name: str) -> None:
    scale, distance = FOUR_TIMES[name]
    scene, frame, base = small(name), right(name), right("ball-on-quad")
    middle = np.array(scene.objects[0].center if isinstance(scene.objects[0], Sphere) else ())
    assert norm(middle) == distance
    for quantity in ("hit", "object", "triangle", "shadow"):
        assert np.array_equal(frame[quantity], base[quantity])
    hit = base["hit"]
    # 64 roundings of the largest coordinate, over the least angle at which a surface is seen here
    slack = 64 * 2.0**-53 * max(distance, 12 * scale) * 100
    assert np.abs(frame["distance"][hit] - scale * base["distance"][hit]).max() < slack


def ray_of_pixel(name: str, column: int, row: int) -> Floats:
    frame = minirt.render(minirt.load_scene(f"atlas:{name}"), quantities=["ray"])
    direction: Floats = frame["ray"][row, column]
    return direction


def distance_to_line(P0: Floats, direction: Floats, C: Floats) -> float:
    return float(norm(np.cross(unit(direction), C - P0)))


# Derivations. Pixel (column, row) has its centre at i = column, j = 191 − row. Exercise 1: the
# screen puts i = 63, j = 96 at u = −1, v = 0, that is d = (1, −1, 0). Exercise 2: i = 128, j = 96
# lies on the axis (1, 2, 1).
@pytest.mark.parametrize(
    ("name", "pixel", "direction", "touching"),
    [
        ("tangent-rays", (63, 95), (1, -1, 0), 1),
        ("tangent-spheres", (128, 95), (1, 2, 1), 8),
    ],
)
def test_exercises_1_and_2_touch(
    name: str, pixel: tuple[int, int], direction: tuple[int, int, int], touching: int
) -> None:
    ray = ray_of_pixel(name, *pixel)
    assert norm(ray - unit(np.array(direction, dtype=float))) <= 4 * 2.0**-53
    scene = minirt.load_scene(f"atlas:{name}")
    spheres = [thing for thing in scene.objects if isinstance(thing, Sphere)][:touching]
    assert len(spheres) == touching
    for ball in spheres:
        gap = distance_to_line(np.array(scene.screen.P0), ray, ball.center) - ball.radius
        # 16 roundings of lengths up to the scene's extent
        assert abs(gap) <= 16 * 2.0**-53 * scene.extent


def test_exercise_3_is_reflected_to_3_1_2() -> None:
    """i = 128, j = 96 looks along (3, 2, 1) at the mirror; its reflection meets the gold ball."""
    frame = minirt.render(minirt.load_scene("atlas:grazing-mirror"))
    row, column = 95, 128
    assert norm(frame["ray"][row, column] - unit(np.array([3.0, 2, 1]))) <= 8 * 2.0**-53
    assert norm(frame["reflection"][row, column] - unit(np.array([3.0, 1, 2]))) <= 16 * 2.0**-53
    assert frame["reflection_object"][row, column] == 1
