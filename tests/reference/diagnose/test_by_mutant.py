"""A failing subject's mistake is named, whatever small noise lies over it; no other is."""

from __future__ import annotations

import pickle
import time
from functools import cache

import numpy as np
import pytest

from minirt.frame import Array, Frame
from minirt.rules import SLIDES
from reference.diagnose.by_mutant import Diagnosis, diagnose
from reference.mutants import CATALOGUE, Mutant
from reference.mutants.matrix import can_run
from reference.mutants.scenes import MeasuredScene, matrix_scenes
from tests.helpers.mutant_subjects import NOISES, Noise, evidence_of, subject

#: The least share of cases in which the right mutant is among the first three.
NAMED = 0.9
#: What one diagnosis of a small scene may take, in seconds of this process.
SECONDS = 3.0


def bench(name: str) -> MeasuredScene:
    (found,) = (each for each in matrix_scenes() if each.scene.name == name)
    return found


@cache
def failing(mutant: str) -> MeasuredScene | None:
    """The first scene of the matrix on which most of a mutant's pixels can be told from noise."""
    wrong = CATALOGUE[mutant]
    for each in matrix_scenes():
        if can_run(wrong, each):
            frame = wrong.render(each.scene)
            if (evidence_of(each, frame).comparison.first_stage >= 0).sum() >= 100:
                return each
    return None


def noisy_cases() -> list[tuple[str, Noise]]:
    """Every mutant, each with one of the noises."""
    return [(name, NOISES[k % len(NOISES)]) for k, name in enumerate(CATALOGUE)]


@pytest.mark.parametrize(("step", "least"), [(8, 8), pytest.param(1, 70, marks=pytest.mark.full)])
def test_the_right_mutant_is_among_the_first_three_under_any_small_noise(
    step: int, least: int
) -> None:
    """Of every mutant, or of one in `step`; at least so many can be told from the noise."""
    ended: dict[tuple[str, str], bool] = {}
    for name, noise in noisy_cases()[::step]:
        where = failing(name)
        if where is None:
            continue
        evidence = subject(where, CATALOGUE[name], noise)
        if noise.name != "no border" and evidence.comparison.passed:
            continue  # the mistake is smaller than the error that the subject declares
        ended[name, noise.name] = name in [found.name for found in diagnose(evidence)]
    assert len(ended) >= least
    assert {noise for _, noise in ended} == {noise.name for noise in NOISES}
    missed = [case for case, named in ended.items() if not named]
    assert len(missed) <= (1 - NAMED) * len(ended), missed


def test_what_is_said_of_a_picture_without_the_half_pixel() -> None:
    evidence = subject(bench("ball-on-quad"), CATALOGUE["no-half-pixel"], NOISES[0])
    start = time.process_time()
    found = diagnose(evidence)
    assert time.process_time() - start < SECONDS
    assert found[0].name == "no-half-pixel"
    assert found[0].sentence == "agrees with rule S2 without the half pixel at 100.0 % of pixels"
    assert pickle.loads(pickle.dumps(found)) == found  # noqa: S301


def test_a_share_is_never_rounded_up() -> None:
    nearly = Diagnosis("m", "S2", "without the half pixel", "ray", 0.99999, 1.0)
    assert nearly.sentence == "agrees with rule S2 without the half pixel at 99.9 % of pixels"


def test_nothing_is_said_where_nothing_is_wrong() -> None:
    honest = bench("ball-on-quad")
    assert diagnose(evidence_of(honest, honest.exact.frame)) == ()


def noise_everywhere(values: Array) -> Array:
    return values * (1 + 0.01 * np.random.default_rng(3).random(values.shape))


def stretched(values: Array) -> Array:
    return values * 1.01


def holes(values: Array) -> Array:
    """The columns 10 to 14 are somebody else's."""
    changed = values.copy()
    changed[:, 10:15] = changed[:, 20:25]
    return changed


def darker(values: Array) -> Array:
    return values * 0.7


@pytest.mark.parametrize(
    ("quantity", "spoil"),
    [("depth", stretched), ("t", noise_everywhere), ("object", holes), ("normal", holes),
     ("color", darker)],
)  # fmt: skip
def test_none_fits_what_is_outside_the_catalogue(quantity: str, spoil: object) -> None:
    assert callable(spoil)
    honest = bench("ball-on-quad")
    with np.errstate(invalid="ignore"):
        spoilt = spoil(honest.exact.frame[quantity])
    evidence = evidence_of(honest, Frame({**honest.exact.frame.arrays, quantity: spoilt}))
    assert not evidence.comparison.passed
    assert diagnose(evidence) == ()


@pytest.mark.parametrize(
    ("first", "second"),
    [("sphere-normal-inward", "no-ambient"), ("rows-from-top", "light-not-negated"),
     ("light-not-negated", "shadow-black"), ("weights-exchanged", "reflection-sign")],
)  # fmt: skip
def test_of_two_mistakes_the_earlier_one_is_named(first: str, second: str) -> None:
    rules = SLIDES.replace(
        **{
            name: getattr(CATALOGUE[mutant].rules, name)
            for mutant in (first, second)
            for name in CATALOGUE[mutant].rules.changed()
        }
    )
    both = Mutant("both", "S4", "with two", "Two mistakes.", "ray", rules)
    where = bench("alpha")
    found = diagnose(evidence_of(where, both.render(where.scene)))
    assert first in [diagnosis.name for diagnosis in found]
    assert second not in [diagnosis.name for diagnosis in found]


def test_quantities_that_are_not_given_do_not_matter() -> None:
    where = bench("ball-on-quad")
    frame = CATALOGUE["rows-from-top"].render(where.scene, "hit,depth")
    assert "rows-from-top" in [found.name for found in diagnose(evidence_of(where, frame))]


def changed(where: MeasuredScene, **arrays: Array) -> list[str]:
    """The sentences about minirt's own frame with other arrays in it."""
    frame = Frame({**where.exact.frame.arrays, **arrays})
    evidence = evidence_of(where, frame)
    assert not evidence.comparison.passed
    return [found.sentence for found in diagnose(evidence)]


def test_an_empty_picture_is_called_empty() -> None:
    where = bench("ball-on-quad")
    said, *_ = changed(where, hit=np.zeros_like(where.exact.frame["hit"]))
    assert said.startswith("hits nothing, where ")


@pytest.mark.parametrize("with_objects", [True, False])
def test_a_kind_of_object_that_is_never_met_is_named(with_objects: bool) -> None:
    where = bench("ball-on-quad")
    exact, things = where.exact.frame, where.scene.objects
    quads = [k for k, thing in enumerate(things) if getattr(thing, "type", "") == "polygon"]
    lost = np.isin(exact["object"], quads)
    assert lost.any()
    arrays = {"hit": exact["hit"] & ~lost}
    if with_objects:
        arrays["object"] = np.where(lost, -1, exact["object"])
    found = diagnose(evidence_of(where, Frame(arrays)))
    assert found[0].sentence == "never meets a polygon: is that kind of object written yet?"


def test_secondary_rays_that_meet_the_surface_they_leave_are_told_so() -> None:
    where = bench("ball-on-quad")
    acne = np.where(where.exact.frame["hit"], 1e-15, np.inf)
    said, *_ = changed(where, reflection_t=acne)
    assert "meet the surface they leave (reflection_t 1e-15 where ε is" in said


def test_float32_arithmetic_is_recognised_and_a_larger_error_is_not() -> None:
    where = bench("ball-on-quad")
    noise = np.random.default_rng(1).normal(size=where.exact.frame["depth"].shape)
    depth = where.exact.frame["depth"]
    (said,) = changed(where, depth=depth * (1 + 3e-7 * noise))
    assert "say --precision float32" in said
    assert changed(where, depth=depth * (1 + 1e-4 * noise)) == []
