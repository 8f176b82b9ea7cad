"""Render scenes with minirt and with references, compare, and say how each cell ended."""

from __future__ import annotations

import resource
import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from converters.frames.files import read_frame, write_frame
from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from minirt.render import require_room
from minirt.scene import Scene
from reference.cache import Cache, timed_rendering, usual_folder
from reference.compare.comparison import Check, Comparison, State, compare, without_answer
from reference.compare.quorum import Draw, Quorum, quorum_of
from reference.compare.stability import Exact, Stability, exact_answer, stability_of
from reference.exact import JUDGED, Judgement, judge_pixels, pixels_to_judge
from reference.jobs.cluster import Cluster
from reference.jobs.isolate import Job, Workers
from reference.source import Declared, NoAnswer, Reference, Unsupported

#: Seconds that a reference may take for one scene.
TIMEOUT = 300.0


@dataclass(frozen=True, eq=False)
class Evidence:
    """All that is known about one scene against one reference, while the arrays are at hand.

    `companions` are the comparisons of all references on the scene, by name, this one included.
    """

    scene: Scene
    reference: str
    ours: Frame
    theirs: Frame
    stability: Stability
    comparison: Comparison
    companions: Mapping[str, Comparison] = field(default_factory=dict)


#: Makes something small for a report of the evidence; runs in a child process: must be picklable.
Digest = Callable[[Evidence], Any]
#: Makes a picture of minirt's own frame for a report; runs where the arrays are.
Portray = Callable[[Frame], Any]
#: Names what explains a failure, best first, each with a `sentence`; runs where the arrays are.
Diagnose = Callable[[Evidence], tuple[Any, ...]]
#: What `judge` takes beside a scene and its answers.
Options = tuple[
    tuple[str, ...], Digest | None, Draw | None, tuple[str, ...], Cache | None,
    Diagnose | None, Portray | None,
]  # fmt: skip


@dataclass(frozen=True)
class ReferenceResult:
    """One scene against one reference.

    Attributes
    ----------
    reference, program : str
        Its name, and what really ran.
    checks : tuple of Check
        One a quantity.
    declared : Declared or None
        How it errs on this scene; None where it did not run.
    seconds : float
        Of its own rendering.
    output : str
        Its last output, where it crashed, timed out or failed.
    digest : object
        What the caller's `Digest` made of the evidence; None where there is none.
    diagnosis : tuple or None
        What the caller's `Diagnose` found in a failure, best first; None where nothing failed.
    kept : bool
        Whether its frame was kept from an earlier run.
    """

    reference: str
    program: str
    checks: tuple[Check, ...]
    declared: Declared | None = None
    seconds: float = 0.0
    output: str = ""
    digest: Any = None
    diagnosis: tuple[Any, ...] | None = None
    kept: bool = False


@dataclass(frozen=True)
class SceneResult:
    """One scene against every reference.

    Attributes
    ----------
    scene : Scene
    references : tuple of ReferenceResult
    seconds : float
    peak_memory : int
        In bytes; both are minirt's own.
    quorum : tuple of Quorum
        Who confirms what, a quantity each; empty where minirt itself failed.
    judgement : Judgement or None
        minirt against exact arithmetic; None where minirt itself failed.
    portrait : object
        What the caller's `Portray` made of minirt's frame; None where there is none.
    """

    scene: Scene
    references: tuple[ReferenceResult, ...]
    seconds: float = 0.0
    peak_memory: int = 0
    quorum: tuple[Quorum, ...] = ()
    judgement: Judgement | None = None
    portrait: Any = None


@dataclass(frozen=True)
class Answered:
    """What a reference's job hands back; its frame travels in a file."""

    reference: str
    frame: str
    given: tuple[str, ...]
    unsupported: dict[str, str]
    program: str
    seconds: float
    kept: bool


@dataclass(frozen=True)
class _Verdict:
    """What judging one scene hands back."""

    declared: dict[str, Declared]
    comparisons: dict[str, tuple[tuple[Check, ...], Any]]
    diagnoses: dict[str, tuple[Any, ...]]
    quorum: tuple[Quorum, ...]
    judgement: Judgement
    seconds: float
    peak_memory: int
    portrait: Any


def verify(
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    jobs: int = 2,
    digest: Digest | None = None,
    timeout: float = TIMEOUT,
    quantities: Iterable[str] = tuple(QUANTITIES),
    draw: Draw | None = None,
    required: Collection[str] = (),
    cache: Cache | None = None,
    diagnose: Diagnose | None = None,
    portray: Portray | None = None,
    cluster: Cluster | None = None,
) -> Iterator[SceneResult]:
    """Compare minirt with references on scenes; yield each scene's result when it is known.

    Every reference runs in a child process: one that aborts, hangs or is missing costs its own
    cells only. minirt runs in children of its own, which no renderer's library ever enters.

    Parameters
    ----------
    scenes : sequence of Scene
    references : sequence of Reference
    jobs : int
        Processes of each kind; no more are started than there is work for.
    digest : callable, optional
        Called in a child with each `Evidence`; its answer travels in the result.
    timeout : float
        Seconds a reference may take for one scene.
    quantities : iterable of str
        What to compare.
    draw : callable, optional
        Called in a child with the maps of who agrees; its answer travels in the quorum.
    required : collection of str
        Quantities that every reference must give.
    cache : Cache, optional
        Where frames and their stability are kept from run to run.
    diagnose : callable, optional
        Called in a child with the `Evidence` of each failure.
    portray : callable, optional
        Called in a child with minirt's frame of each scene.
    cluster : Cluster, optional
        Whose workers do a scene each, with a process of each kind, in place of this machine;
        `cache` is a folder of theirs then.

    Yields
    ------
    SceneResult
        In the order of `scenes`; from a cluster as they are known.

    Raises
    ------
    InputError
        A scene's image does not fit in this machine's memory.
    """
    names = tuple(quantities)
    options = names, digest, draw, tuple(required), cache, diagnose, portray
    if cluster is not None:
        yield from _verify_on(cluster, scenes, references, timeout, options)
        return
    for scene in scenes:
        require_room(scene)
    with (
        TemporaryDirectory(prefix="minirt-") as scratch,
        Workers(_within(jobs, len(scenes) * len(references))) as theirs,
        Workers(_within(jobs, len(scenes))) as ours,
    ):
        started = [
            (scene, _start(scene, references, theirs, Path(scratch) / str(k), timeout, cache))
            for k, scene in enumerate(scenes)
        ]
        judging: deque[tuple[Scene, list[ReferenceResult | Answered], Job]] = deque()
        for scene, renderings in started:
            ended = [_ended(reference, job, scene, names) for reference, job in renderings]
            answers = [
                (reference, answer)
                for reference, answer in zip(references, ended, strict=True)
                if isinstance(answer, Answered)
            ]
            judging.append((scene, ended, ours.submit(None, judge, scene, answers, *options)))
            while judging and judging[0][2].future.done():
                yield _result(*judging.popleft(), names)
        while judging:
            yield _result(*judging.popleft(), names)


def _verify_on(
    cluster: Cluster,
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    timeout: float,
    options: Options,
) -> Iterator[SceneResult]:
    """The same by the workers of a cluster; a scene that no worker survives has crashed."""
    jobs = ((_verify_one, (scene, tuple(references), timeout, options)) for scene in scenes)
    for number, outcome in cluster.outcomes(jobs):
        scene = scenes[number]
        if outcome.state == "done":
            yield replace(outcome.value, scene=scene)
        else:
            checks = without_answer(options[0], "crashed", f"on the cluster: {outcome.reason}")
            yield SceneResult(
                scene, tuple(ReferenceResult(each.name, each.name, checks) for each in references)
            )


def _verify_one(
    scene: Scene, references: Sequence[Reference], timeout: float, options: Options
) -> SceneResult:
    """One scene on a worker, with what the worker has."""
    names, digest, draw, required, cache, diagnose, portray = options
    here = None if cache is None else replace(cache, folder=usual_folder())
    (result,) = verify(
        [scene], references, 1, digest, timeout, names, draw, required, here, diagnose, portray
    )
    return result


def _within(jobs: int, work: int) -> int:
    return max(1, min(jobs, work))


def judge(
    scene: Scene,
    answers: Sequence[tuple[Reference, Answered]],
    names: tuple[str, ...],
    digest: Digest | None,
    draw: Draw | None = None,
    required: Collection[str] = (),
    cache: Cache | None = None,
    diagnose: Diagnose | None = None,
    portray: Portray | None = None,
) -> _Verdict:
    """Compare the references' frames of one scene with minirt's. Runs in a child process.

    References that declare the same error share one measurement of stability, and all of them
    minirt's own frame. What they declare is asked here, where nothing of theirs has run.
    """
    start = time.perf_counter()
    comparisons: dict[str, Comparison] = {}
    evidences: list[Evidence] = []
    exact = exact_answer(scene) if cache is None else cache.exact(scene)
    ours = exact.frame
    declared = {reference.name: reference.declare(scene) for reference, _ in answers}
    groups: dict[Declared, list[Answered]] = {}
    for _, answer in answers:
        error = replace(declared[answer.reference], derivation="")
        groups.setdefault(error, []).append(answer)
    for error, alike in groups.items():
        given = {name for answer in alike for name in answer.given}.intersection(names)
        stability = _stability(exact, error, given, cache)
        for answer in alike:
            theirs = read_frame(answer.frame) if answer.given else Frame({})
            comparison = compare(
                scene, ours, stability, theirs, answer.unsupported, names, required
            )
            name = answer.reference
            comparisons[name] = comparison
            evidences.append(
                Evidence(scene, name, ours, theirs, stability, comparison, comparisons)
            )
    digests = {each.reference: digest(each) if digest else None for each in evidences}
    diagnoses = {
        each.reference: diagnose(each)
        for each in evidences
        if diagnose is not None and any(check.wrong for check in each.comparison.checks)
    }
    checks = {name: (c.checks, digests[name]) for name, c in comparisons.items()}
    judgement = _judgement(scene, ours, comparisons, names)
    portrait = None if portray is None else portray(ours)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    seconds = time.perf_counter() - start
    quorum = quorum_of(comparisons, names, draw)
    return _Verdict(declared, checks, diagnoses, quorum, judgement, seconds, peak, portrait)


def _stability(exact: Exact, error: Declared, given: set[str], cache: Cache | None) -> Stability:
    if not given:
        return Stability({}, {})
    return (
        stability_of(exact, error, given) if cache is None else cache.stability(exact, error, given)
    )


def _judgement(
    scene: Scene, frame: Frame, comparisons: dict[str, Comparison], names: tuple[str, ...]
) -> Judgement:
    """minirt's own frame against exact arithmetic, in those of the quantities that it knows."""
    known = Frame({name: frame[name] for name in JUDGED if name in names})
    return judge_pixels(scene, known, pixels_to_judge(scene, comparisons))


def _start(
    scene: Scene,
    references: Sequence[Reference],
    workers: Workers,
    folder: Path,
    timeout: float,
    cache: Cache | None,
) -> list[tuple[Reference, Job | None]]:
    """Hand one scene to every reference that is not missing."""
    started: list[tuple[Reference, Job | None]] = []
    for reference in references:
        if reference.missing():
            started.append((reference, None))
            continue
        room = folder / reference.name
        room.mkdir(parents=True)
        job = workers.submit(timeout, render_by, reference, scene, room, cache)
        started.append((reference, job))
    return started


def render_by(
    reference: Reference, scene: Scene, room: Path, cache: Cache | None = None
) -> Answered:
    """A reference's answer to a scene, its frame in a file. Runs in a child process."""
    if cache is None:
        rendering, seconds, kept = *timed_rendering(reference, scene, room), False
    else:
        rendering, seconds, kept = cache.rendering(reference, scene, room)
    path = room / "frame.npz"
    if rendering.frame:
        write_frame(rendering.frame, path)
    return Answered(
        reference.name,
        str(path),
        tuple(rendering.frame),
        dict(rendering.unsupported),
        rendering.program,
        seconds,
        kept,
    )


def _ended(
    reference: Reference, job: Job | None, scene: Scene, names: tuple[str, ...]
) -> ReferenceResult | Answered:
    """The answer of a reference, or how it failed to give one."""
    if job is None:
        return _unanswered(reference, names, "missing", reference.missing() or "")
    outcome = job.outcome()
    if outcome.state == "done":
        answered: Answered = outcome.value
        return answered
    if isinstance(outcome.value, Unsupported):
        return _unanswered(reference, names, "not supported", str(outcome.value))
    if isinstance(outcome.value, NoAnswer):
        ended = outcome.value
        return _unanswered(reference, names, ended.state, str(ended), outcome.output)
    state: State = "timed out" if outcome.state == "timed out" else "crashed"
    return _unanswered(reference, names, state, outcome.reason, outcome.output)


def _unanswered(
    reference: Reference, names: tuple[str, ...], state: State, reason: str, output: str = ""
) -> ReferenceResult:
    checks = without_answer(names, state, reason)
    return ReferenceResult(reference.name, reference.name, checks, output=output)


def _result(
    scene: Scene, ended: list[ReferenceResult | Answered], job: Job, names: tuple[str, ...]
) -> SceneResult:
    outcome = job.outcome()
    if outcome.state != "done":
        checks = without_answer(names, "crashed", f"minirt itself failed: {outcome.reason}")
        return SceneResult(
            scene,
            tuple(
                ReferenceResult(entry.reference, entry.program, checks, output=outcome.output)
                for entry in ended
            ),
        )
    verdict: _Verdict = outcome.value
    return SceneResult(
        scene,
        tuple(_compared(entry, verdict) for entry in ended),
        verdict.seconds,
        verdict.peak_memory,
        verdict.quorum,
        verdict.judgement,
        verdict.portrait,
    )


def _compared(entry: ReferenceResult | Answered, verdict: _Verdict) -> ReferenceResult:
    if isinstance(entry, ReferenceResult):
        return entry
    name = entry.reference
    checks, digest = verdict.comparisons[name]
    return ReferenceResult(
        name, entry.program, checks, verdict.declared[name], entry.seconds, "", digest,
        verdict.diagnoses.get(name), entry.kept,
    )  # fmt: skip
