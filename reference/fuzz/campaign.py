"""A fuzzing campaign: draw random scenes, compare, and shrink each failure."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial

from minirt import load_scene
from minirt.scene import Scene
from reference.fuzz.scenes import mesh_folder, scene_document
from reference.fuzz.shrink import Shrunk, shrink
from reference.fuzz.trial import Trial, TrialWorkers
from reference.jobs.cluster import Cluster, Job, in_order
from reference.jobs.isolate import Progress
from reference.source import Reference
from reference.verify.options import TIMEOUT

#: Least share of certain pixels over all quantities, references and scenes of a
#: campaign. A single scene may have fewer, since it is built to be delicate; but a renderer whose
#: declared error makes a tenth of all pixels uncertain is not really tested.
CAMPAIGN_FLOOR = 0.9
#: Failures after which a campaign ends: further ones mostly have the same cause.
MOST_FAILURES = 10


@dataclass(frozen=True, eq=False)
class Failure:
    """One scene that one reference fails.

    Attributes
    ----------
    number : int
        Of the scene in the campaign.
    reference : str
    drawn : Scene
        As it was drawn.
    trial : Trial
        How the drawn scene fails.
    shrunk : Shrunk
        The smallest scene that fails in the same first stage.
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
class Campaign:
    """The result of a campaign.

    Attributes
    ----------
    seed, scenes : int
        Scenes 0…scenes−1 of the seed were drawn.
    compared, unsupported : int
        Pairs of scene and reference that were compared, and pairs that could not be.
    certain, judged : int
        Certain pixels, and all pixels, summed over the quantities compared.
    missing : dict of str to str
        By reference that cannot run here: the reason.
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
        """Share of certain pixels; 0 where none was judged."""
        return self.certain / self.judged if self.judged else 0.0

    @property
    def vague(self) -> bool:
        """Whether too few pixels were certain for the campaign to mean anything."""
        return self.judged > 0 and self.certain_share < CAMPAIGN_FLOOR


#: A scene, its trial by each reference, and the failures among them, shrunk when asked for.
Tried = tuple[Scene, Mapping[str, Trial], Iterable[Failure]]


@dataclass(frozen=True)
class CampaignOptions:
    """How long a campaign lasts, and with how many processes.

    Attributes
    ----------
    scenes : int
        At most so many are drawn.
    seconds : float
        No scene is drawn later than this.
    jobs : int
        Processes of each kind.
    timeout : float
        Seconds that a reference may take for one scene.
    shrink_seconds : float
        For each failure.
    """

    scenes: int
    seconds: float = float("inf")
    jobs: int = 1
    timeout: float = TIMEOUT
    shrink_seconds: float = 60.0


def run_campaign(
    seed: int,
    references: Sequence[Reference],
    options: CampaignOptions,
    *,
    workers: TrialWorkers | None = None,
    cluster: Cluster | None = None,
    progress: Progress | None = None,
    on_failure: Callable[[Failure], None] | None = None,
) -> Campaign:
    """Compare references with minirt on random scenes, and shrink what fails.

    Parameters
    ----------
    seed : int
        At least 0; scene k of a seed is always the same.
    references : sequence of Reference
        Renderers, or a program under test.
    options : CampaignOptions
    workers : TrialWorkers, optional
        Processes that are there already; without them new ones are started.
    cluster : Cluster, optional
        Whose workers try and shrink a scene each, in place of this machine; they find out which
        references are missing.
    progress : callable, optional
        Called after each scene, with the number of scenes that are done and of all.
    on_failure : callable, optional
        Called with each failure as soon as it is shrunk.
    """
    if workers is None and cluster is None:
        with TrialWorkers(options.jobs, options.timeout) as own:
            return run_campaign(
                seed, references, options,
                workers=own, progress=progress, on_failure=on_failure,
            )  # fmt: skip
    start, tally = time.perf_counter(), _Tally()
    drawn = _drawn(seed, options.scenes, start + options.seconds)
    if cluster is not None:
        tried = _tried_on(cluster, drawn, references, options)
    elif workers is not None:
        tried = _tried(workers, drawn, tally.present(references), options.shrink_seconds)
    with closing(tried):
        for done, (scene, trials, failures) in enumerate(tried, start=1):
            if not tally.add(scene, trials):
                break
            for failure in failures:
                tally.failures.append(failure)
                if on_failure is not None:
                    on_failure(failure)
            if progress is not None:
                progress(done, options.scenes)
            if len(tally.failures) >= MOST_FAILURES:
                break
    return tally.campaign(seed, time.perf_counter() - start)


def drawn_scene(seed: int, number: int) -> Scene:
    """Scene `number` of a campaign."""
    return load_scene(scene_document(seed, number), folder=mesh_folder())


def _drawn(seed: int, scenes: int, deadline: float) -> Iterator[tuple[int, Scene]]:
    """The scenes of a campaign with their numbers, until the time is used up."""
    for number in range(scenes):
        if time.perf_counter() > deadline:
            return
        yield number, drawn_scene(seed, number)


def _tried(
    workers: TrialWorkers,
    drawn: Iterable[tuple[int, Scene]],
    references: Sequence[Reference],
    seconds: float,
) -> Generator[Tried]:
    """Try each scene by every reference, on this machine."""
    for number, scene in drawn if references else ():
        trials = dict(zip(_names(references), workers.trials(scene, references), strict=True))
        yield scene, trials, _shrunk(workers, number, scene, references, trials, seconds)


def _tried_on(
    cluster: Cluster,
    drawn: Iterable[tuple[int, Scene]],
    references: Sequence[Reference],
    options: CampaignOptions,
) -> Generator[Tried]:
    """Try each scene by every reference, on the workers of a cluster."""
    sent: deque[Scene] = deque()

    def jobs() -> Iterator[Job]:
        for number, scene in drawn if references else ():
            sent.append(scene)
            yield _try_on_worker, (number, scene, tuple(references), options)

    with closing(cluster.outcomes(jobs())) as ended:
        for outcome in in_order(ended):
            scene = sent.popleft()
            if outcome.state == "done":
                yield scene, *outcome.value
            else:
                lost = Trial("unjudged", reason=f"on the cluster: {outcome.reason}")
                yield scene, dict.fromkeys(_names(references), lost), ()


def _try_on_worker(
    number: int,
    scene: Scene,
    references: Sequence[Reference],
    options: CampaignOptions,
) -> tuple[Mapping[str, Trial], list[Failure]]:
    """Try one scene by every reference, on a worker, and shrink each failure."""
    with TrialWorkers(options.jobs, options.timeout) as workers:
        _, trials, failures = next(
            _tried(workers, [(number, scene)], references, options.shrink_seconds)
        )
        return trials, list(failures)


def _shrunk(
    workers: TrialWorkers,
    number: int,
    scene: Scene,
    references: Sequence[Reference],
    trials: Mapping[str, Trial],
    seconds: float,
) -> Iterator[Failure]:
    """The failures among trials, each shrunk when it is asked for."""
    for reference in references:
        trial = trials[reference.name]
        if trial.state == "failed":
            ask = partial(workers.trial, reference=reference)
            small = shrink(scene, trial, ask, seconds)
            yield Failure(number, reference.name, scene, trial, small)


def _names(references: Iterable[Reference]) -> list[str]:
    return [reference.name for reference in references]


class _Tally:
    """What a campaign has found so far."""

    def __init__(self) -> None:
        self._trials: list[Trial] = []
        self._missing: dict[str, str] = {}
        self._unjudged: list[str] = []
        self._scenes = 0
        self.failures: list[Failure] = []

    def present(self, references: Sequence[Reference]) -> list[Reference]:
        """The references that can run here; record why the others cannot."""
        for reference in references:
            if why := reference.missing():
                self._missing[reference.name] = why
        return [reference for reference in references if reference.name not in self._missing]

    def add(self, scene: Scene, trials: Mapping[str, Trial]) -> bool:
        """Add a scene's trials; whether any reference could run at all."""
        self._missing |= {n: t.reason for n, t in trials.items() if t.state == "missing"}
        if all(trial.state == "missing" for trial in trials.values()):
            return False
        self._scenes += 1
        self._trials += trials.values()
        why = dict.fromkeys(t.reason for t in trials.values() if t.state == "unjudged")
        self._unjudged += [f"{scene.name}: {reason}" for reason in why]
        return True

    def campaign(self, seed: int, seconds: float) -> Campaign:
        """The finished record."""
        states = [trial.state for trial in self._trials]
        return Campaign(
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
