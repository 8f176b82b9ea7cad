"""The comparison finds one wrong pixel, charges it to its first wrong stage, never cries wolf."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from minirt.screen import pixel_center
from minirt.vectors import dot
from reference.compare.check import Check
from reference.compare.comparison import Comparison, compare
from reference.compare.similarity import SSIM_FLOOR, ssim_floor
from reference.compare.stability import Stability, measure
from reference.source import Declared, NormalOffset

U32 = 2.0**-24


def small(name: str, nx: int = 64, ny: int = 48) -> Scene:
    """A scene of the atlas at fewer pixels."""
    scene = minirt.load_scene(f"atlas:{name}")
    document = scene.to_dict()
    document["screen"].update(nx=nx, ny=ny)
    return minirt.load_scene(document, folder=scene.folder)


def as_float32(scene: Scene) -> Declared:
    """What a careful float32 renderer would declare: some ten roundings of the extent."""
    return Declared(
        delta=10 * U32 * scene.extent,
        vertex=2 * U32 * scene.extent,
        angle=10 * U32,
        color=16 * U32,
        start=NormalOffset(1500 * U32),
        derivation="ten roundings",
    )


@cache
def measured(name: str) -> tuple[Scene, Frame, Stability]:
    scene = small(name)
    return scene, *measure(scene, as_float32(scene))


def judged(name: str, theirs: Frame) -> Comparison:
    scene, ours, stability = measured(name)
    return compare(scene, ours, stability, theirs, {})


def altered(name: str, **arrays: np.ndarray[Any, Any]) -> Frame:
    _, ours, _ = measured(name)
    return Frame({**ours.arrays, **arrays})


def check_of(comparison: Comparison, quantity: str) -> Check:
    return next(check for check in comparison.checks if check.quantity == quantity)


def failed(comparison: Comparison) -> set[str]:
    return {check.quantity for check in comparison.checks if check.state == "failed"}


def certain_hit(name: str, quantity: str = "color") -> tuple[int, int]:
    """A pixel in the middle of what is hit, at which the quantity is certain and has a value."""
    _, ours, stability = measured(name)
    value = ours[quantity].reshape(*ours.size, -1)
    usable = stability.certain[quantity] & ours["hit"] & np.isfinite(value).all(axis=2)
    rows, columns = np.nonzero(usable)
    assert len(rows) > 50
    return int(rows[len(rows) // 2]), int(columns[len(rows) // 2])


def test_minirt_passes_against_itself_and_in_float32() -> None:
    for name in ("ball-on-quad", "glass-ball", "curved-mirrors"):
        _, ours, _ = measured(name)
        rounded = {
            key: array.astype(np.float32).astype(array.dtype) for key, array in ours.arrays.items()
        }
        for frame in (ours, Frame(rounded)):
            comparison = judged(name, frame)
            assert comparison.passed, failed(comparison)
            assert all(check.state == "passed" for check in comparison.checks)
            assert check_of(comparison, "hit").compared > 3000


@pytest.mark.parametrize("quantity", [q for q in QUANTITIES if QUANTITIES[q].discrete])
def test_one_wrong_discrete_pixel_fails(quantity: str) -> None:
    pixel = certain_hit("glass-ball", quantity)
    _, ours, _ = measured("glass-ball")
    wrong = ours[quantity].copy()
    wrong[pixel] = not wrong[pixel] if wrong.dtype == np.bool_ else wrong[pixel] + 1
    comparison = judged("glass-ball", altered("glass-ball", **{quantity: wrong}))
    assert failed(comparison) == {quantity}
    check = check_of(comparison, quantity)
    assert check.wrong == check.first_wrong == 1
    assert check.worst is not None
    assert (check.worst.row, check.worst.column) == pixel


@pytest.mark.parametrize("quantity", [q for q in QUANTITIES if not QUANTITIES[q].discrete])
def test_one_pixel_just_beyond_its_tolerance_fails_and_just_within_passes(quantity: str) -> None:
    name = "ball-on-quad" if quantity == "barycentric" else "glass-ball"
    pixel = certain_hit(name, quantity)
    _, ours, stability = measured(name)
    allowed = stability.tolerance[quantity][pixel]
    assert allowed > 0
    for factor, expected in ((0.9, set()), (1.1, {quantity})):
        moved = ours[quantity].copy()
        moved[pixel] += factor * allowed / np.sqrt(QUANTITIES[quantity].components)
        assert failed(judged(name, altered(name, **{quantity: moved}))) == expected


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_no_number_where_one_belongs_is_wrong(value: float) -> None:
    _, ours, _ = measured("ball-on-quad")
    depth = ours["depth"].copy()
    depth[certain_hit("ball-on-quad")] = value
    assert failed(judged("ball-on-quad", altered("ball-on-quad", depth=depth))) == {"depth"}


def test_a_number_where_none_belongs_is_wrong() -> None:
    _, ours, stability = measured("one-sphere")
    row, column = np.argwhere(~ours["hit"] & stability.certain["hit"])[0]
    for name in ("depth", "normal"):
        array = ours[name].copy()
        array[row, column] = 1.0
        assert failed(judged("one-sphere", altered("one-sphere", **{name: array}))) == {name}


@pytest.mark.parametrize(
    ("name", "value"),
    [("t", np.nan), ("depth", -np.inf), ("distance", np.nan), ("position", np.inf),
     ("normal", -np.inf), ("reflection_t", -np.inf), ("barycentric", np.inf)],
)  # fmt: skip
def test_nothing_is_said_in_the_tables_way_or_it_is_wrong(name: str, value: float) -> None:
    _, ours, stability = measured("one-sphere")
    nothing = ~np.isfinite(ours[name].reshape(*ours.size, -1)).all(axis=2)
    row, column = np.argwhere(nothing & stability.certain[name])[0]
    array = ours[name].copy()
    array[row, column] = value
    assert failed(judged("one-sphere", altered("one-sphere", **{name: array}))) == {name}


def test_a_tolerance_that_is_no_number_tolerates_nothing() -> None:
    scene, ours, stability = measured("one-sphere")
    pixel = certain_hit("one-sphere", "depth")
    for broken, moved in ((np.nan, 1e-9), (np.inf, np.inf)):
        tolerance = {**stability.tolerance, "depth": stability.tolerance["depth"].copy()}
        tolerance["depth"][pixel] = broken
        depth = ours["depth"].copy()
        depth[pixel] += moved
        comparison = compare(
            scene, ours, Stability(stability.certain, tolerance),
            altered("one-sphere", depth=depth), {},
        )  # fmt: skip
        assert failed(comparison) == {"depth"}


def test_the_floor_of_similarity_sinks_with_what_is_uncertain() -> None:
    assert ssim_floor("depth", 0.0) == ssim_floor("depth", 0.01) == SSIM_FLOOR["depth"]
    assert ssim_floor("depth", 0.02) == pytest.approx(SSIM_FLOOR["depth"] - 0.49)
    assert ssim_floor("depth", 0.5) == 0.0


def test_a_wall_that_faces_the_observer_is_flat_and_not_noise() -> None:
    """All its depths are 5 but for the last bits; one that is not flat is seen to differ."""
    document = small("ball-on-quad").to_dict()
    document["screen"] |= {"P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1],
                           "nu": -1.0, "l": -1.0, "r": 1.0, "b": -0.75, "t": 0.75}  # fmt: skip
    wall = [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]
    material = document["objects"][0]["material"]
    document["objects"] = [{"type": "polygon", "material": material, "vertices": wall}]
    scene = minirt.load_scene(document)
    ours, stability = measure(scene, as_float32(scene))
    assert ours["depth"].min() > 4.999
    noise = np.random.default_rng(1).uniform(-0.5, 0.5, ours.size) * stability.tolerance["depth"]
    for frame, expected in ((noise, set()), (noise + 0.1 * ours["barycentric"][..., 0], {"depth"})):
        theirs = Frame({"depth": ours["depth"] + frame})
        check = check_of(compare(scene, ours, stability, theirs, {}, ["depth"]), "depth")
        assert check.ssim is not None
        assert check.ssim_floor is not None
        assert (check.ssim < check.ssim_floor) is bool(expected)
        assert ({"depth"} if check.state == "failed" else set()) == expected


def test_absent_and_unsupported_quantities_are_said_and_never_passed() -> None:
    scene, ours, stability = measured("one-sphere")
    comparison = compare(
        scene, ours, stability, Frame({"hit": ours["hit"]}), {"depth": "it has no depth"}
    )
    states = {check.quantity: check.state for check in comparison.checks}
    assert states.pop("hit") == "passed"
    assert states.pop("depth") == "not supported"
    assert set(states.values()) == {"not given"}
    assert check_of(comparison, "depth").reason == "it has no depth"


def test_a_frame_that_gives_nothing_has_not_passed() -> None:
    assert not judged("one-sphere", Frame({})).passed


def test_an_image_of_another_size_fails_and_says_so() -> None:
    comparison = judged("one-sphere", Frame({"hit": np.zeros((48, 63), dtype=np.bool_)}))
    check = check_of(comparison, "hit")
    assert check.state == "failed"
    assert "63×48" in check.reason
    assert "64×48" in check.reason


def test_an_error_declared_too_large_fails_by_its_share_of_certain_pixels() -> None:
    scene = small("ball-on-quad")
    wide = Declared(0.1 * scene.extent, 0.0, 0.0, 0.0, None, "")
    ours, stability = measure(scene, wide)
    comparison = compare(scene, ours, stability, ours, {})
    assert "object" in failed(comparison)
    assert "are certain" in check_of(comparison, "object").reason


def _literal_refraction(delta: Any, s: Any, nu: Any, nu_t: Any) -> Any:
    """S16 with s on the incident side, as the slide draws it (E1)."""
    s = np.where(dot(delta, s) > 0, -s, s)
    ratio, cosine = nu / nu_t, dot(delta, s)
    radicand = 1 - ratio * ratio * (1 - cosine * cosine)
    total = radicand < 0
    root = np.sqrt(np.where(total, 0, radicand))
    return np.where(total, np.nan, ratio * delta + (root - ratio * cosine) * s)


#: Mistakes that people make, the scene that shows each, and the stage it breaks first.
PLANTED: dict[str, tuple[str, str, dict[str, Callable[..., Any]]]] = {
    "E1 taken literally": ("glass-ball", "refraction", {"refract": _literal_refraction}),
    "no half pixel": (
        "ball-on-quad",
        "ray",
        {"pixel_center": lambda screen, i, j: pixel_center(screen, i - 0.5, j - 0.5)},
    ),
    "j from the top": (
        "ball-on-quad",
        "ray",
        {"pixel_center": lambda screen, i, j: pixel_center(screen, i, screen.ny - 1 - j)},
    ),
    "epsilon zero": ("overlapping-spheres", "shadow", {"start_of_secondary": lambda epsilon: 0.0}),
    "z given as distance": ("ball-on-quad", "t", {"distance_of": lambda t, length: t}),
}


@pytest.mark.parametrize("mistake", PLANTED)
def test_planted_mistakes_are_found_in_the_stage_they_break(mistake: str) -> None:
    name, stage, rules = PLANTED[mistake]
    scene, _, _ = measured(name)
    comparison = judged(name, minirt.render(scene, minirt.SLIDES.replace(**rules)))
    assert not comparison.passed
    charged = [check for check in comparison.checks if check.first_wrong]
    assert charged[0].stage == stage, [(c.quantity, c.first_wrong) for c in charged]


def test_what_follows_from_a_wrong_object_is_charged_to_the_object() -> None:
    scene, ours, stability = measured("ball-on-quad")
    arrays = {name: array.copy() for name, array in ours.arrays.items()}
    pixel = certain_hit("ball-on-quad")
    arrays["object"][pixel] = 7
    arrays["t"][pixel] *= 2
    arrays["color"][pixel] += 1
    comparison = compare(scene, ours, stability, Frame(arrays), {})
    assert failed(comparison) == {"object", "t", "color"}
    assert check_of(comparison, "object").first_wrong == 1
    assert check_of(comparison, "t").first_wrong == check_of(comparison, "color").first_wrong == 0
    assert "earlier stage" in check_of(comparison, "t").reason
