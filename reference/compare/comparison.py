"""Compare a frame with minirt's, quantity by quantity, where the exact answer is stable."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from minirt.frame import Array, Frame, has_numbers, planes
from minirt.quantities import QUANTITIES, STAGES, Quantity
from minirt.scene import Scene
from minirt.vectors import Bools, Floats
from reference.compare.check import CERTAIN_FLOOR, Check, State, WorstPixel
from reference.compare.flip import flip_ceiling, flip_of
from reference.compare.similarity import ssim_floor, ssim_of
from reference.compare.stability import Stability


@dataclass(frozen=True, eq=False)
class Comparison:
    """All quantities of one scene against one reference.

    Attributes
    ----------
    checks : tuple of Check
        In the table's order.
    ratio : dict of str to (ny, nx) float64
        Error over tolerance: NaN where it was not judged, +inf for a discrete mismatch.
    first_stage : (ny, nx) int8
        Number of the first wrong stage in `STAGES`; −1 where nothing is wrong.
    error : dict of str to (ny, nx) float64
        On every pixel, judged or not: see `error_of`.
    """

    checks: tuple[Check, ...]
    ratio: dict[str, Floats] = field(default_factory=dict)
    first_stage: Array = field(default_factory=lambda: np.zeros((0, 0), dtype=np.int8))
    error: dict[str, Floats] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """Whether something was compared and nothing failed."""
        states = {check.state for check in self.checks}
        return "passed" in states and states <= {"passed", "not given", "not supported"}


def compare(
    scene: Scene,
    ours: Frame,
    stability: Stability,
    theirs: Frame,
    unsupported: Mapping[str, str],
    names: Iterable[str] = tuple(QUANTITIES),
    required: Collection[str] = (),
    pictures: bool = True,
) -> Comparison:
    """Judge every quantity that the other frame gives.

    On certain pixels a discrete quantity must be equal, and a continuous one within its
    tolerance; where minirt has no value (nothing is hit, no index) the other must have none
    either. Wrong pixels are charged to the first stage, in causal order, that is wrong there.

    Parameters
    ----------
    scene : Scene
    ours : Frame
        All quantities, by minirt.
    stability : Stability
        Of `ours`, under the other's declared error; of every quantity that is compared.
    theirs : Frame
        Any subset of the quantities.
    unsupported : dict of str to str
        Reasons for quantities that the other cannot give.
    names : iterable of str
        The quantities to compare.
    required : collection of str
        Those of them that must be given: without one the check fails.
    pictures : bool
        Whether whole pictures are compared too, by SSIM and FLIP, beside the pixels.
    """
    names = tuple(names)
    errors = {
        name: error_of(QUANTITIES[name], ours[name], theirs[name])
        for name in names
        if name in theirs and theirs[name].shape == ours[name].shape
    }
    ratios = {name: _ratio(name, error, stability) for name, error in errors.items()}
    first_stage = _first_wrong_stage(ratios, ours.size)
    floor = scene.floor[0] if scene.floor else CERTAIN_FLOOR
    checks = []
    for name in names:
        if name not in ratios:
            checks.append(_incomparable(name, ours, theirs, unsupported, required))
            continue
        worst = _worst(name, ours, theirs, stability, ratios[name], errors[name])
        check = _check(name, ours, stability, ratios[name], first_stage, floor, worst)
        checks.append(_with_pictures(check, ours, theirs, stability) if pictures else check)
    return Comparison(tuple(checks), ratios, first_stage, errors)


def _incomparable(
    name: str, ours: Frame, theirs: Frame, unsupported: Mapping[str, str], required: Collection[str]
) -> Check:
    """The check of a quantity that is not there, or of another size."""
    stage = QUANTITIES[name].stage
    if name in theirs:
        got = "×".join(map(str, theirs[name].shape[1::-1]))
        reason = f"the image is {got}, expected {ours.size[1]}×{ours.size[0]}"
        return Check(name, stage, "failed", reason)
    lacking: State = "not supported" if name in unsupported else "not given"
    reason = unsupported.get(name, "the frame does not hold it")
    if name in required:
        lacking, reason = "failed", f"required, and {lacking}: {reason}"
    return Check(name, stage, lacking, reason)


def error_of(quantity: Quantity, ours: Array, theirs: Array) -> Floats:
    """Absolute error (ny, nx), Euclidean for vectors; +inf where only one of the two is a number.

    0 where minirt has none and the other says so in the same way, which is the table's: a −inf
    would come before everything. Discrete quantities: 0 or +inf.
    """
    if quantity.discrete:
        return np.where(ours == theirs, 0.0, np.inf)
    pairs = list(zip(planes(ours), planes(theirs), strict=True))
    ours_finite, theirs_finite = has_numbers(ours), has_numbers(theirs)
    with np.errstate(invalid="ignore", over="ignore"):
        error = np.sqrt(sum((a - b) ** 2 for a, b in pairs))
    same = np.logical_and.reduce([(a == b) | (np.isnan(a) & np.isnan(b)) for a, b in pairs])
    none = ~ours_finite & same
    return np.where(ours_finite & theirs_finite, error, np.where(none, 0.0, np.inf))


def _ratio(name: str, error: Floats, stability: Stability) -> Floats:
    if not QUANTITIES[name].discrete:
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(np.isinf(error), error, error / stability.tolerance[name])
        error = np.where(error == 0, 0.0, np.where(np.isnan(ratio), np.inf, ratio))
    return np.where(stability.certain[name], error, np.nan)


def _first_wrong_stage(ratios: Mapping[str, Floats], size: tuple[int, int]) -> Array:
    first = np.full(size, -1, dtype=np.int8)
    for number, stage in enumerate(STAGES):
        for name, ratio in ratios.items():
            if QUANTITIES[name].stage == stage:
                first[(ratio > 1) & (first < 0)] = number
    return first


def _check(
    name: str, ours: Frame, stability: Stability, ratio: Floats, first_stage: Array, floor: float,
    worst: WorstPixel | None,
) -> Check:  # fmt: skip
    quantity = QUANTITIES[name]
    certain: Bools = stability.certain[name]
    given = _has_value(quantity, ours[name])
    wrong = ratio > 1
    here = STAGES.index(quantity.stage)
    check = Check(
        quantity=name,
        stage=quantity.stage,
        state="passed",
        pixels=certain.size,
        certain=int(certain.sum()),
        compared=int((certain & given).sum()),
        wrong=int(wrong.sum()),
        first_wrong=int((wrong & (first_stage == here)).sum()),
        ratio=None if worst is None else float(ratio[worst.row, worst.column]),
        worst=worst,
        floor=floor,
    )
    return _judged(check)


def _with_pictures(check: Check, ours: Frame, theirs: Frame, stability: Stability) -> Check:
    """The check with the similarity of the whole pictures, judged again."""
    name = check.quantity
    certain = stability.certain[name]
    ssim = ssim_of(name, ours, theirs, _usual_tolerance(stability.tolerance.get(name), certain))
    flip = flip_of(name, ours, theirs)
    if ssim is None and flip is None:
        return check
    return _judged(
        replace(
            check,
            ssim=ssim,
            ssim_floor=None if ssim is None else ssim_floor(name, 1 - float(certain.mean())),
            flip=flip,
            flip_ceiling=None if flip is None else flip_ceiling(1 - float(certain.mean())),
        )
    )


def _judged(check: Check) -> Check:
    fault = check.fault
    return replace(check, state="failed", reason=fault) if fault else check


def _usual_tolerance(tolerance: Floats | None, certain: Bools) -> float:
    """The median over the certain pixels; 0 where nothing is tolerated or certain."""
    if tolerance is None or not certain.any():
        return 0.0
    return float(np.median(tolerance[certain]))


def _has_value(quantity: Quantity, values: Array) -> Bools:
    if quantity.discrete:
        return np.ones(values.shape, dtype=np.bool_)
    return has_numbers(values)


def _worst(
    name: str, ours: Frame, theirs: Frame, stability: Stability, ratio: Floats, error: Floats
) -> WorstPixel | None:
    if np.isnan(ratio).all():
        return None
    row, column = np.unravel_index(int(np.nanargmax(ratio)), ratio.shape)
    pixel = (int(row), int(column))
    allowed = 0.0 if QUANTITIES[name].discrete else float(stability.tolerance[name][pixel])
    return WorstPixel(
        column=int(column),
        row=int(row),
        ours=tuple(np.atleast_1d(ours[name][pixel]).astype(float).tolist()),
        theirs=tuple(np.atleast_1d(theirs[name][pixel]).astype(float).tolist()),
        error=float(error[pixel]),
        tolerance=allowed,
    )
