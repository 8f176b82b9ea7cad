"""One cell of a comparison: one quantity of one scene against one reference, and its state."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from minirt.quantities import QUANTITIES, Stage

#: Share of pixels that must be certain on a scene that states no floor of its own.
CERTAIN_FLOOR = 0.99

#: How a cell can end. `known` is a failure that a baseline excuses, with a reason and for a time.
State = Literal[
    "passed", "failed", "known", "not given", "not supported", "missing", "crashed", "timed out"
]

#: States in which pixels were compared.
COMPARED: tuple[State, ...] = ("failed", "known", "passed")
#: States of a reference that gave no answer where it should have.
UNANSWERED: tuple[State, ...] = ("crashed", "timed out", "missing")


@dataclass(frozen=True)
class WorstPixel:
    """The pixel at which a quantity is furthest from minirt's, relative to the tolerance.

    Attributes
    ----------
    column, row : int
        From the left, and from the TOP.
    ours, theirs : tuple of float
        The components of both values.
    error, tolerance : float
        In the quantity's unit, Euclidean for vectors; the tolerance is 0 for a discrete quantity.
    """

    column: int
    row: int
    ours: tuple[float, ...]
    theirs: tuple[float, ...]
    error: float
    tolerance: float


@dataclass(frozen=True)
class Check:
    """One quantity of one scene against one reference.

    Attributes
    ----------
    quantity, stage : str
        Its name, and the stage of the lecture's algorithm that computes it.
    state : str
    reason : str
        Why it is not 'passed', in a sentence; empty where it is.
    pixels, certain, compared : int
        Pixels of the image; those where the exact answer is stable; of those, the ones with a
        value.
    wrong, first_wrong : int
        Certain pixels that are wrong, and those of them where no earlier stage is.
    ratio : float or None
        The largest error over its tolerance; +inf for a discrete mismatch; None where nothing was
        compared.
    worst : WorstPixel or None
        Where that is; None where nothing was compared, or where it was not kept.
    floor : float
        Least share of certain pixels.
    ssim, ssim_floor : float or None
        Structural similarity of the whole picture, and its least value: for hit, depth and shadow.
    flip, flip_ceiling : float or None
        Mean FLIP difference of the whole picture, and its largest value: for colour.
    """

    quantity: str
    stage: Stage
    state: State
    reason: str = ""
    pixels: int = 0
    certain: int = 0
    compared: int = 0
    wrong: int = 0
    first_wrong: int = 0
    ratio: float | None = None
    worst: WorstPixel | None = None
    floor: float = CERTAIN_FLOOR
    ssim: float | None = None
    ssim_floor: float | None = None
    flip: float | None = None
    flip_ceiling: float | None = None

    @property
    def fault(self) -> str:
        """What is wrong with its figures, in a sentence; empty where they pass."""
        if self.wrong:
            return f"{self.wrong} of {self.certain} certain pixels wrong" + (
                "" if self.first_wrong else ", all wrong in an earlier stage already"
            )
        if self.certain < self.floor * self.pixels:
            share, least = 100 * self.certain / self.pixels, 100 * self.floor
            return f"only {share:.2f} % of the pixels are certain, expected {least:.4g} %"
        return self._dissimilarity()

    def _dissimilarity(self) -> str:
        if self.ssim is not None and self.ssim_floor is not None and self.ssim < self.ssim_floor:
            return f"SSIM {self.ssim:.5f} is below its floor {self.ssim_floor}"
        if (
            self.flip is not None
            and self.flip_ceiling is not None
            and self.flip > self.flip_ceiling
        ):
            return f"FLIP {self.flip:.5f} is above its ceiling {self.flip_ceiling:.3g}"
        return ""


def without_answer(names: Iterable[str], state: State, reason: str) -> tuple[Check, ...]:
    """One check for each quantity, for a reference that gave no frame at all."""
    return tuple(Check(name, QUANTITIES[name].stage, state, reason) for name in names)
