"""Draw scenes, compare, shrink what fails, until scenes or time are used up."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

from minirt.scene import Scene, load_scene
from reference.fuzz.bench import Bench, Trial
from reference.fuzz.scenes import mesh_folder, scene_document
from reference.fuzz.shrink import Shrunk, shrink
from reference.source import Reference
from reference.verify import TIMEOUT

#: Least share of certain pixels over all quantities, references and scenes of a hunt. A fuzz
#: scene may lack them, being built to be delicate; a renderer whose declared error makes a
#: tenth of everything uncertain is not being tested.
HUNT_FLOOR = 0.9
#: Failures after which a hunt ends: the next ones mostly have the same cause.
MOST = 10


@dataclass(frozen=True, eq=False)
class Failure:
    """One scene that one reference fails.

    Attributes
    ----------
    number : int
        Of the scene in the hunt.
    reference : str
    drawn : Scene
        As it was drawn.
    trial : Trial
        How that one fails.
    shrunk : Shrunk
        The smallest that fails in the same first stage.
    """

    number: int
    reference: str
    drawn: Scene
    trial: Trial
    shrunk: Shrunk

    @property
    def name(self) -> str:
        """A name for its files."""
        return f"{self.drawn.name}-{self.reference}".replace("-", "_")


@dataclass(frozen=True, eq=False)
class Hunt:
    """A hunt from its first scene to its last.

    Attributes
    ----------
    seed, scenes : int
        Scenes 0…scenes−1 of the seed were drawn.
    compared, unsupported : int
        Pairs of scene and reference that were compared, and that could not be.
    certain, judged : int
        Pixels that were certain, and all, over all quantities compared.
    missing : dict of str to str
        By reference that cannot run here: why.
    unjudged : tuple of str
        Scenes at which minirt itself did not answer, with the reason.
    failures : tuple of Failure
    seconds : float
    """

    seed: int
    scenes: int = 0
    compared: int = 0
    unsupported: int = 0
    certain: int = 0
    judged: int = 0
    missing: tuple[tuple[str, str], ...] = ()
    unjudged: tuple[str, ...] = ()
    failures: tuple[Failure, ...] = ()
    seconds: float = 0.0

    @property
    def certain_share(self) -> float:
        """Of the pixels judged; 0 where there are none."""
        return self.certain / self.judged if self.judged else 0.0

    @property
    def vague(self) -> bool:
        """Whether too few pixels were certain for the hunt to mean anything."""
        return self.judged > 0 and self.certain_share < HUNT_FLOOR


#: Called after each scene with the numbers of scenes done and of failures.
Progress = Callable[[int, int], None]
#: Called with each failure as soon as it is shrunk.
Found = Callable[[Failure], None]


def hunt(
    seed: int,
    references: Sequence[Reference],
    scenes: int,
    seconds: float = float("inf"),
    *,
    bench: Bench | None = None,
    jobs: int = 1,
    timeout: float = TIMEOUT,
    shrink_seconds: float = 60.0,
    progress: Progress | None = None,
    found: Found | None = None,
) -> Hunt:
    """Compare references with minirt on random scenes, and shrink what fails.

    Parameters
    ----------
    seed : int
        At least 0; scene k of a seed is always the same.
    references : sequence of Reference
        Whoever is to be judged: renderers, or a program under test.
    scenes : int
        At most so many.
    seconds : float
        After which no further scene is drawn.
    bench : Bench, optional
        Whose processes to use; those of a new one with `jobs` processes of each kind and
        `timeout` seconds for a reference's scene when left out.
    shrink_seconds : float
        For each failure.
    progress, found : callable, optional
    """
    if bench is None:
        with Bench(jobs, timeout) as own:
            return hunt(
                seed, references, scenes, seconds,
                bench=own, shrink_seconds=shrink_seconds, progress=progress, found=found,
            )  # fmt: skip
    here = [reference for reference in references if not reference.missing()]
    missing = tuple((r.name, r.missing() or "") for r in references if r not in here)
    start, tally = time.perf_counter(), _Tally(bench, here, shrink_seconds)
    for number in range(scenes if here else 0):
        if time.perf_counter() - start > seconds or len(tally.failures) >= MOST:
            break
        for failure in tally.take(number, drawn_scene(seed, number)):
            if found is not None:
                found(failure)
        if progress is not None:
            progress(number + 1, len(tally.failures))
    return tally.hunt(seed, missing, time.perf_counter() - start)


def drawn_scene(seed: int, number: int) -> Scene:
    """Scene `number` of a hunt."""
    return load_scene(scene_document(seed, number), folder=mesh_folder())


class _Tally:
    """What a hunt has found so far."""

    def __init__(self, bench: Bench, references: Sequence[Reference], seconds: float) -> None:
        self._bench, self._references, self._seconds = bench, references, seconds
        self._trials: list[Trial] = []
        self._unjudged: list[str] = []
        self._scenes = 0
        self.failures: list[Failure] = []

    def take(self, number: int, scene: Scene) -> Iterator[Failure]:
        """Compare one scene with every reference; shrink what fails."""
        self._scenes += 1
        trials = self._bench.trials(scene, self._references)
        self._trials += trials
        for reference, trial in zip(self._references, trials, strict=True):
            if trial.state == "unjudged":
                self._unjudged.append(f"{scene.name}: {trial.reason}")
            if trial.state == "failed":
                ask = partial(self._bench.trial, reference=reference)
                small = shrink(scene, trial, ask, self._seconds)
                self.failures.append(Failure(number, reference.name, scene, trial, small))
                yield self.failures[-1]

    def hunt(self, seed: int, missing: Iterable[tuple[str, str]], seconds: float) -> Hunt:
        """The finished record."""
        states = [trial.state for trial in self._trials]
        return Hunt(
            seed=seed,
            scenes=self._scenes,
            compared=states.count("passed") + states.count("failed"),
            unsupported=states.count("not supported"),
            certain=sum(trial.certain for trial in self._trials),
            judged=sum(trial.judged for trial in self._trials),
            missing=tuple(missing),
            unjudged=tuple(self._unjudged),
            failures=tuple(self.failures),
            seconds=seconds,
        )
