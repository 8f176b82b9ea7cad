"""Draw scenes, compare, shrink what fails, until scenes or time are used up."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial

from minirt import load_scene
from minirt.scene import Scene
from reference.fuzz.bench import Bench, Trial
from reference.fuzz.scenes import mesh_folder, scene_document
from reference.fuzz.shrink import Shrunk, shrink
from reference.jobs.cluster import Cluster, Job, in_order
from reference.source import Reference
from reference.verify.options import TIMEOUT

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


#: A scene, how it ended before each reference, and what fails, shrunk when it is asked for.
Taken = tuple[Scene, Mapping[str, Trial], Iterable[Failure]]
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
    cluster: Cluster | None = None,
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
    cluster : Cluster, optional
        Whose workers take a scene each, and shrink it, in place of `bench`, with `jobs` processes
        of each kind; which references are missing is found out there.
    """
    if bench is None and cluster is None:
        with Bench(jobs, timeout) as own:
            return hunt(
                seed, references, scenes, seconds,
                bench=own, shrink_seconds=shrink_seconds, progress=progress, found=found,
            )  # fmt: skip
    start, tally = time.perf_counter(), _Tally()
    drawn = _drawn(seed, scenes, start + seconds)
    if cluster is not None:
        taken = _taken_on(cluster, drawn, references, (jobs, timeout, shrink_seconds))
    elif bench is not None:
        taken = _taken(bench, drawn, tally.present(references), shrink_seconds)
    with closing(taken):
        for done, (scene, trials, failures) in enumerate(taken, start=1):
            if not tally.note(scene, trials):
                break
            for failure in failures:
                tally.failures.append(failure)
                if found is not None:
                    found(failure)
            if progress is not None:
                progress(done, len(tally.failures))
            if len(tally.failures) >= MOST:
                break
    return tally.hunt(seed, time.perf_counter() - start)


def drawn_scene(seed: int, number: int) -> Scene:
    """Scene `number` of a hunt."""
    return load_scene(scene_document(seed, number), folder=mesh_folder())


def _drawn(seed: int, scenes: int, deadline: float) -> Iterator[tuple[int, Scene]]:
    """The scenes of a hunt with their numbers, as long as there is time."""
    for number in range(scenes):
        if time.perf_counter() > deadline:
            return
        yield number, drawn_scene(seed, number)


def _taken(
    bench: Bench,
    drawn: Iterable[tuple[int, Scene]],
    references: Sequence[Reference],
    seconds: float,
) -> Generator[Taken]:
    """Each scene before every reference, here."""
    for number, scene in drawn if references else ():
        trials = dict(zip(_names(references), bench.trials(scene, references), strict=True))
        yield scene, trials, _shrunk(bench, number, scene, references, trials, seconds)


def _taken_on(
    cluster: Cluster,
    drawn: Iterable[tuple[int, Scene]],
    references: Sequence[Reference],
    how: tuple[int, float, float],
) -> Generator[Taken]:
    """Each scene before every reference, by the workers of a cluster."""
    sent: deque[Scene] = deque()

    def jobs() -> Iterator[Job]:
        for number, scene in drawn if references else ():
            sent.append(scene)
            yield _take, (number, scene, tuple(references), *how)

    with closing(cluster.outcomes(jobs())) as ended:
        for outcome in in_order(ended):
            scene = sent.popleft()
            if outcome.state == "done":
                yield scene, *outcome.value
            else:
                lost = Trial("unjudged", reason=f"on the cluster: {outcome.reason}")
                yield scene, dict.fromkeys(_names(references), lost), ()


def _take(
    number: int,
    scene: Scene,
    references: Sequence[Reference],
    jobs: int,
    timeout: float,
    seconds: float,
) -> tuple[Mapping[str, Trial], list[Failure]]:
    """One scene before every reference, on a worker, and what fails there, shrunk."""
    with Bench(jobs, timeout) as bench:
        _, trials, failures = next(_taken(bench, [(number, scene)], references, seconds))
        return trials, list(failures)


def _shrunk(
    bench: Bench,
    number: int,
    scene: Scene,
    references: Sequence[Reference],
    trials: Mapping[str, Trial],
    seconds: float,
) -> Iterator[Failure]:
    """What fails, shrunk."""
    for reference in references:
        trial = trials[reference.name]
        if trial.state == "failed":
            ask = partial(bench.trial, reference=reference)
            small = shrink(scene, trial, ask, seconds)
            yield Failure(number, reference.name, scene, trial, small)


def _names(references: Iterable[Reference]) -> list[str]:
    return [reference.name for reference in references]


class _Tally:
    """What a hunt has found so far."""

    def __init__(self) -> None:
        self._trials: list[Trial] = []
        self._missing: dict[str, str] = {}
        self._unjudged: list[str] = []
        self._scenes = 0
        self.failures: list[Failure] = []

    def present(self, references: Sequence[Reference]) -> list[Reference]:
        """Those that can run here; of the others, it is noted why not."""
        for reference in references:
            if why := reference.missing():
                self._missing[reference.name] = why
        return [reference for reference in references if reference.name not in self._missing]

    def note(self, scene: Scene, trials: Mapping[str, Trial]) -> bool:
        """Add a scene's trials; whether any reference was there at all."""
        self._missing |= {n: t.reason for n, t in trials.items() if t.state == "missing"}
        if all(trial.state == "missing" for trial in trials.values()):
            return False
        self._scenes += 1
        self._trials += trials.values()
        why = dict.fromkeys(t.reason for t in trials.values() if t.state == "unjudged")
        self._unjudged += [f"{scene.name}: {reason}" for reason in why]
        return True

    def hunt(self, seed: int, seconds: float) -> Hunt:
        """The finished record."""
        states = [trial.state for trial in self._trials]
        return Hunt(
            seed=seed,
            scenes=self._scenes,
            compared=states.count("passed") + states.count("failed"),
            unsupported=states.count("not supported"),
            certain=sum(trial.certain for trial in self._trials),
            judged=sum(trial.judged for trial in self._trials),
            missing=tuple(self._missing.items()),
            unjudged=tuple(self._unjudged),
            failures=tuple(self.failures),
            seconds=seconds,
        )
