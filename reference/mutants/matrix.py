"""The kill matrix: every mutant through the same checks as a renderer, on a few small scenes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from minirt import load_scene
from minirt.frame import Frame
from minirt.quantities import STAGES, Stage
from minirt.scene import Facets, Scene
from reference.compare.comparison import Comparison, compare
from reference.compare.stability import Exact, Stability, exact_answer, stability_of
from reference.mutants import CATALOGUE, ORIGINAL
from reference.mutants.mutant import Mutant
from reference.mutants.thin_gap import THIN_GAP
from reference.source import Declared

#: Columns and rows of the pictures.
SIZE = (48, 36)

#: The atlas scenes that the mutants are run on. Beside the usual ones: off-axis screens, another
#: handedness, ν of either sign and not 1, pixels that are not square, an observer inside
#: a sphere and inside glass, polygons of many corners, objects behind the observer,
#: mirrors, total reflection, a closed mesh of 5,000 triangles.
SCENES = (
    "ball-on-quad", "alpha", "left-handed-frame", "negative-nu", "non-square-pixels",
    "behind-the-observer", "pentagon-and-octagon", "inside-a-sphere", "inside-glass",
    "snells-window", "closed-mesh",
)  # fmt: skip

#: A mutant with a changed rule is not run on more faces: some rules, once replaced, are asked
#: about every pair of a ray and a face.
_MOST_FACES = 500


@dataclass(frozen=True, eq=False)
class Bench:
    """A scene with minirt's own answer and its stability under float64's rounding."""

    scene: Scene
    exact: Exact
    stability: Stability

    def judge(self, frame: Frame, pictures: bool = False) -> Comparison:
        """Compare a frame with minirt's: pixel by pixel, which must do; or as pictures too."""
        return compare(self.scene, self.exact.frame, self.stability, frame, {}, pictures=pictures)


@dataclass(frozen=True)
class Kill:
    """What the checks say of one mutant.

    Attributes
    ----------
    mutant, rule, mistake : str
    stage : str
        The first stage that it really breaks.
    scenes : int
        On which it was run.
    failed : tuple of str
        The scenes on which a check failed.
    charged : dict of str to int
        By stage: pixels of all scenes that are wrong there first.
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
        """The first stage that wrong pixels are charged to; None where none is."""
        return next((stage for stage in STAGES if self.charged[stage]), None)

    @property
    def right_stage(self) -> bool:
        """Whether that is the stage that the mutant really breaks."""
        return self.found == self.stage


def reduced(scene: Scene, size: tuple[int, int] = SIZE) -> Scene:
    """The same scene in fewer, larger pixels."""
    document = scene.to_dict()
    document["screen"] |= {"nx": size[0], "ny": size[1]}
    return load_scene(document, folder=scene.folder)


def float64_rounding(scene: Scene) -> Declared:
    """The error of a renderer in float64: 256 roundings of 2⁻⁵² at the scale of the scene."""
    delta = 2.0**-44 * scene.extent
    return Declared(delta, 0.0, 2.0**-44, 2.0**-44, None, "256 roundings of 2⁻⁵²")


def bench_of(scene: Scene) -> Bench:
    """Measure a scene once for everybody who is judged on it."""
    exact = exact_answer(scene)
    return Bench(scene, exact, stability_of(exact, float64_rounding(scene)))


@cache
def atlas_bench(name: str) -> Bench:
    """A scene of the atlas in the matrix's size, measured once a process."""
    return bench_of(reduced(load_scene(f"atlas:{name}")))


@cache
def benches() -> tuple[Bench, ...]:
    """The scenes of the matrix, measured once a process."""
    return (*map(atlas_bench, SCENES), bench_of(load_scene(THIN_GAP)))


def judges(bench: Bench, mutant: Mutant) -> bool:
    """Whether a mutant is run on a scene: on a large mesh only with the lecture's own rules."""
    faces = sum(len(t.faces) for t in bench.scene.objects if isinstance(t, Facets))
    return faces <= _MOST_FACES or not mutant.rules.changed()


def run_mutant(mutant: Mutant) -> Kill:
    """One row of the matrix."""
    charged: dict[str, int] = dict.fromkeys(STAGES, 0)
    failed = []
    chosen = [bench for bench in benches() if judges(bench, mutant)]
    for bench in chosen:
        comparison = bench.judge(mutant.render(bench.scene), pictures=mutant is ORIGINAL)
        if not comparison.passed:
            failed.append(bench.scene.name)
        stages, counts = np.unique(comparison.first_stage, return_counts=True)
        for stage, count in zip(stages, counts, strict=True):
            if stage >= 0:
                charged[STAGES[stage]] += int(count)
    return Kill(
        mutant.name, mutant.rule, mutant.mistake, mutant.stage, len(chosen), tuple(failed), charged
    )


def kill(name: str) -> Kill:
    """The row of the mutant of that name; of no mistake at all for 'none'. For child processes."""
    return run_mutant(ORIGINAL if name == ORIGINAL.name else CATALOGUE[name])


def kill_matrix(names: Iterable[str] = (ORIGINAL.name, *CATALOGUE)) -> Iterator[Kill]:
    """The rows of some mutants, and of no mistake at all."""
    for name in names:
        yield kill(name)
