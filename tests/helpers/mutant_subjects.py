"""Mutants as unknown subjects: each with a small noise that has nothing to do with its mistake."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from minirt.frame import Array, Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.compare.comparison import compare
from reference.compare.stability import stability_of
from reference.mutants import Mutant
from reference.mutants.scenes import MeasuredScene, float64_rounding
from reference.source import Declared
from reference.verify.results import Evidence


def in_float32(frame: Frame) -> Frame:
    return _rounded(frame, np.float32)


def in_half_precision(frame: Frame) -> Frame:
    return _rounded(frame, np.float16)


def _rounded(frame: Frame, kind: type) -> Frame:
    def rounded(array: Array) -> Array:
        if array.dtype != np.float64:
            return array
        with np.errstate(over="ignore"):
            return array.astype(kind).astype(np.float64)

    return Frame({name: rounded(array) for name, array in frame.items()})


def without_border(frame: Frame) -> Frame:
    """The outermost pixels hold nothing."""
    arrays = {}
    for name, array in frame.items():
        arrays[name] = QUANTITIES[name].missing(*frame.size)
        arrays[name][1:-1, 1:-1] = array[1:-1, 1:-1]
    return Frame(arrays)


def float32_rounding(scene: Scene) -> Declared:
    """Two roundings of each number, of 2⁻²⁴ of it; of a vector's length, √3 < 2 times as much."""
    angle = 2.0**-22
    return Declared(angle * scene.extent, 0.0, angle, angle, None, "rounding to float32")


def half_precision(scene: Scene) -> Declared:
    """A rounding of 2⁻¹¹ of each number; of vectors, √3 < 2 times as much. Colours here are < 4."""
    exact = float64_rounding(scene)
    step = {"ratio": 1.0, "length": scene.extent, "direction": 1.0, "colour": 4.0}
    steps = tuple(
        (name, 2.0**-10 * (scene.extent if name == "t" else step[quantity.kind]))
        for name, quantity in QUANTITIES.items()
        if not quantity.discrete
    )
    return Declared(exact.delta, 0.0, exact.angle, exact.color, None, "half precision", steps=steps)


@dataclass(frozen=True)
class Noise:
    """What happens to every value, and what the subject declares of it."""

    name: str
    disturb: Callable[[Frame], Frame]
    declare: Callable[[Scene], Declared]


NOISES = (
    Noise("float32", in_float32, float32_rounding),
    Noise("half precision", in_half_precision, half_precision),
    Noise("no border", without_border, float64_rounding),
)


def evidence_of(bench: MeasuredScene, frame: Frame, declared: Declared | None = None) -> Evidence:
    """What a run of verify knows of a subject that gave this frame."""
    stability = bench.stability if declared is None else stability_of(bench.exact, declared)
    comparison = compare(bench.scene, bench.exact.frame, stability, frame, {}, pictures=False)
    return Evidence(bench.scene, "subject", bench.exact.frame, frame, stability, comparison)


def subject(bench: MeasuredScene, mutant: Mutant, noise: Noise) -> Evidence:
    """A mutant's frame with a noise on it."""
    frame = noise.disturb(mutant.render(bench.scene))
    return evidence_of(bench, frame, noise.declare(bench.scene))
