"""Render scenes with minirt and with references, compare, and say how each cell ended."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from minirt.render import require_room
from minirt.scene import Scene
from reference.cache import usual_folder
from reference.compare.check import without_answer
from reference.jobs.cluster import Cluster
from reference.jobs.isolate import Job, Workers
from reference.source import Reference
from reference.verify.options import DEFAULTS, Options
from reference.verify.rendering import RenderedFrame, render_to_file, rendered_frame
from reference.verify.results import ReferenceResult, SceneResult
from reference.verify.scene import SceneComparison, compare_scene


def verify(
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    options: Options = DEFAULTS,
    cluster: Cluster | None = None,
) -> Iterator[SceneResult]:
    """Compare minirt with references on scenes; yield each scene's result when it is known.

    Every reference runs in a child process: one that aborts, hangs or is missing costs its own
    cells only. minirt runs in children of its own, which no renderer's library ever enters.

    Parameters
    ----------
    scenes : sequence of Scene
    references : sequence of Reference
    options : Options
    cluster : Cluster, optional
        Whose workers do a scene each, with a process of each kind, in place of this machine;
        the cache is a folder of theirs then.

    Yields
    ------
    SceneResult
        In the order of `scenes`; from a cluster as they are known.

    Raises
    ------
    InputError
        A scene's image does not fit in this machine's memory.
    """
    if cluster is not None:
        yield from _verify_on(cluster, scenes, references, options)
        return
    for scene in scenes:
        require_room(scene)
    with (
        TemporaryDirectory(prefix="minirt-") as scratch,
        Workers(_within(options.jobs, len(scenes) * len(references))) as renderers,
        Workers(_within(options.jobs, len(scenes))) as ours,
    ):
        started = [
            (scene, _start(scene, references, renderers, Path(scratch) / str(number), options))
            for number, scene in enumerate(scenes)
        ]
        comparing: deque[_Comparing] = deque()
        for scene, jobs in started:
            comparing.append(_compare_when_rendered(scene, jobs, ours, options))
            while comparing and comparing[0].job.future.done():
                yield comparing.popleft().result(options)
        while comparing:
            yield comparing.popleft().result(options)


def _verify_on(
    cluster: Cluster, scenes: Sequence[Scene], references: Sequence[Reference], options: Options
) -> Iterator[SceneResult]:
    """The same by the workers of a cluster; a scene that no worker survives has crashed."""
    jobs = ((_verify_one, (scene, tuple(references), options)) for scene in scenes)
    for number, outcome in cluster.outcomes(jobs):
        scene = scenes[number]
        if outcome.state == "done":
            yield replace(outcome.value, scene=scene)
        else:
            reason = f"on the cluster: {outcome.reason}"
            checks = without_answer(options.quantities, "crashed", reason)
            yield SceneResult(
                scene, tuple(ReferenceResult(each.name, each.name, checks) for each in references)
            )


def _verify_one(scene: Scene, references: Sequence[Reference], options: Options) -> SceneResult:
    """One scene on a worker, with the worker's own cache."""
    cache = None if options.cache is None else replace(options.cache, folder=usual_folder())
    (result,) = verify([scene], references, replace(options, jobs=1, cache=cache))
    return result


def _within(jobs: int, work: int) -> int:
    return max(1, min(jobs, work))


#: References with the jobs that render by them; None for one that is missing.
_Rendering = Sequence[tuple[Reference, Job | None]]


def _start(
    scene: Scene, references: Sequence[Reference], workers: Workers, folder: Path, options: Options
) -> _Rendering:
    """Hand one scene to every reference that is not missing."""
    started: list[tuple[Reference, Job | None]] = []
    for reference in references:
        if reference.missing():
            started.append((reference, None))
            continue
        scratch = folder / reference.name
        scratch.mkdir(parents=True)
        job = workers.submit(
            options.timeout, render_to_file, reference, scene, scratch, options.cache
        )
        started.append((reference, job))
    return started


@dataclass(frozen=True)
class _Comparing:
    """A scene whose frames are being compared: what each reference gave, and the job."""

    scene: Scene
    given: Sequence[ReferenceResult | RenderedFrame]
    job: Job

    def result(self, options: Options) -> SceneResult:
        """The scene's result, when the job has ended."""
        outcome = self.job.outcome()
        if outcome.state != "done":
            reason = f"minirt itself failed: {outcome.reason}"
            checks = without_answer(options.quantities, "crashed", reason)
            return SceneResult(
                self.scene,
                tuple(
                    ReferenceResult(each.reference, each.program, checks, output=outcome.output)
                    for each in self.given
                ),
            )
        found: SceneComparison = outcome.value
        return SceneResult(
            self.scene,
            tuple(reference_result(each, found) for each in self.given),
            found.seconds,
            found.peak_memory,
            found.quorum,
            found.judgement,
            found.thumbnail,
        )


def _compare_when_rendered(
    scene: Scene, jobs: _Rendering, workers: Workers, options: Options
) -> _Comparing:
    """Wait for all renderings of a scene, and start to compare them."""
    given = [rendered_frame(reference, job, options.quantities) for reference, job in jobs]
    rendered = [
        (reference, frame)
        for (reference, _), frame in zip(jobs, given, strict=True)
        if isinstance(frame, RenderedFrame)
    ]
    return _Comparing(scene, given, workers.submit(None, compare_scene, scene, rendered, options))


def reference_result(
    given: ReferenceResult | RenderedFrame, compared: SceneComparison
) -> ReferenceResult:
    """What a reference gave, with its comparison; as it is where it gave no frame."""
    if isinstance(given, ReferenceResult):
        return given
    found = compared.references[given.reference]
    return ReferenceResult(
        given.reference, given.program, found.checks, found.declared, given.seconds, "",
        found.details, found.diagnosis, given.kept,
    )  # fmt: skip
