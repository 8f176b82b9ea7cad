"""The kill matrix: every mutant through the same checks as a renderer, on a few small scenes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from minirt.quantities import STAGES, Stage
from minirt.scene import Facets
from reference.mutants import CATALOGUE, ORIGINAL
from reference.mutants.mutant import Mutant
from reference.mutants.scenes import MeasuredScene, matrix_scenes

#: Largest number of faces on which a mutant with a changed rule is run: for some rules a
#: replacement is called for every pair of a ray and a face.
_MOST_FACES = 500


@dataclass(frozen=True)
class Kill:
    """The result of the checks on one mutant: a row of the matrix.

    Attributes
    ----------
    mutant, rule, mistake : str
    stage : str
        The first stage that it really breaks.
    scenes : int
        Number of scenes on which it was run.
    failed : tuple of str
        The scenes on which a check failed.
    charged : dict of str to int
        By stage: the pixels of all scenes whose first wrong stage it is.
    """

    mutant: str
    rule: str
    mistake: str
    stage: Stage
    scenes: int
    failed: tuple[str, ...]
    charged: dict[str, int]

    @property
    def killed(self) -> bool:
        """Whether a check failed on at least one scene."""
        return bool(self.failed)

    @property
    def found(self) -> str | None:
        """The first stage to which wrong pixels are charged; None if there is none."""
        return next((stage for stage in STAGES if self.charged[stage]), None)

    @property
    def right_stage(self) -> bool:
        """Whether that is the stage that the mutant really breaks."""
        return self.found == self.stage


def can_run(mutant: Mutant, measured: MeasuredScene) -> bool:
    """Whether a mutant is run on a scene: on a large mesh only with the lecture's own rules."""
    faces = sum(len(t.faces) for t in measured.scene.objects if isinstance(t, Facets))
    return faces <= _MOST_FACES or not mutant.rules.changed()


def run_mutant(mutant: Mutant) -> Kill:
    """One row of the matrix."""
    charged: dict[str, int] = dict.fromkeys(STAGES, 0)
    failed = []
    chosen = [measured for measured in matrix_scenes() if can_run(mutant, measured)]
    for measured in chosen:
        comparison = measured.compare(mutant.render(measured.scene), pictures=mutant is ORIGINAL)
        if not comparison.passed:
            failed.append(measured.scene.name)
        stages, counts = np.unique(comparison.first_stage, return_counts=True)
        for stage, count in zip(stages, counts, strict=True):
            if stage >= 0:
                charged[STAGES[stage]] += int(count)
    return Kill(
        mutant.name, mutant.rule, mutant.mistake, mutant.stage, len(chosen), tuple(failed), charged
    )


def kill(name: str) -> Kill:
    """The row of the mutant of that name, or of 'none'. Runs in a child process."""
    return run_mutant(ORIGINAL if name == ORIGINAL.name else CATALOGUE[name])


def kill_matrix(names: Iterable[str] = (ORIGINAL.name, *CATALOGUE)) -> Iterator[Kill]:
    """The rows of some mutants; 'none' is the lecture's own rules."""
    for name in names:
        yield kill(name)
