"""Compare the references' frames of one scene with minirt's, in a process of minirt's own."""

from __future__ import annotations

import resource
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from converters.frames.io import read_frame
from minirt.frame import Frame
from minirt.scene import Scene
from reference.cache import Cache
from reference.compare.check import Check
from reference.compare.comparison import Comparison, compare
from reference.compare.quorum import Quorum, quorum_of
from reference.compare.stability import Exact, Stability, exact_answer, stability_of
from reference.exact import JUDGED, Judgement, judge_pixels, pixels_to_judge
from reference.source import Declared, Reference
from reference.verify.options import DEFAULTS, Options
from reference.verify.rendering import RenderedFrame
from reference.verify.results import Evidence

#: References with the frames that they gave.
Rendered = Sequence[tuple[Reference, RenderedFrame]]


@dataclass(frozen=True)
class ReferenceComparison:
    """One reference's frame compared with minirt's; fields as in `ReferenceResult`."""

    declared: Declared
    checks: tuple[Check, ...]
    details: Any
    diagnosis: tuple[Any, ...] | None


@dataclass(frozen=True)
class SceneComparison:
    """All frames of one scene compared with minirt's; the other fields as in `SceneResult`."""

    references: dict[str, ReferenceComparison]
    quorum: tuple[Quorum, ...]
    judgement: Judgement
    seconds: float
    peak_memory: int
    thumbnail: Any


def compare_scene(scene: Scene, rendered: Rendered, options: Options = DEFAULTS) -> SceneComparison:
    """Compare the references' frames of one scene with minirt's. Runs in a child process.

    References that declare the same error share one measurement of stability, and all of them
    minirt's own frame. What they declare is asked here, where no renderer's code has run.
    """
    start = time.perf_counter()
    exact = exact_answer(scene) if options.cache is None else options.cache.exact(scene)
    declared = {reference.name: reference.declare(scene) for reference, _ in rendered}
    evidence = _evidence(exact, declared, [frame for _, frame in rendered], options)
    references = {
        each.reference: _reference_comparison(each, declared[each.reference], options)
        for each in evidence
    }
    comparisons = {each.reference: each.comparison for each in evidence}
    make_thumbnail = options.callbacks.thumbnail
    return SceneComparison(
        references=references,
        quorum=quorum_of(comparisons, options.quantities, options.callbacks.draw),
        judgement=_judgement(exact, comparisons, options.quantities),
        seconds=time.perf_counter() - start,
        peak_memory=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
        thumbnail=None if make_thumbnail is None else make_thumbnail(exact.frame),
    )


def _evidence(
    exact: Exact,
    declared: Mapping[str, Declared],
    frames: Sequence[RenderedFrame],
    options: Options,
) -> list[Evidence]:
    """Compare every frame; those of references that declare the same error after each other."""
    by_error: dict[Declared, list[RenderedFrame]] = {}
    for frame in frames:
        error = replace(declared[frame.reference], derivation="")
        by_error.setdefault(error, []).append(frame)
    comparisons: dict[str, Comparison] = {}
    evidence = []
    for error, alike in by_error.items():
        given = {name for frame in alike for name in frame.given}.intersection(options.quantities)
        stability = _stability(exact, error, given, options.cache)
        for frame in alike:
            theirs = read_frame(frame.frame) if frame.given else Frame({})
            comparison = compare(
                exact.scene, exact.frame, stability, theirs, frame.unsupported,
                options.quantities, options.required,
            )  # fmt: skip
            name = frame.reference
            comparisons[name] = comparison
            evidence.append(
                Evidence(exact.scene, name, exact.frame, theirs, stability, comparison, comparisons)
            )
    return evidence


def _stability(exact: Exact, error: Declared, given: set[str], cache: Cache | None) -> Stability:
    if not given:
        return Stability({}, {})
    return (
        stability_of(exact, error, given) if cache is None else cache.stability(exact, error, given)
    )


def _reference_comparison(
    evidence: Evidence, declared: Declared, options: Options
) -> ReferenceComparison:
    make_details, diagnose = options.callbacks.details, options.callbacks.diagnose
    checks = evidence.comparison.checks
    failed = any(check.wrong for check in checks)
    return ReferenceComparison(
        declared,
        checks,
        None if make_details is None else make_details(evidence),
        None if diagnose is None or not failed else diagnose(evidence),
    )


def _judgement(
    exact: Exact, comparisons: Mapping[str, Comparison], names: Iterable[str]
) -> Judgement:
    """minirt's own frame against exact arithmetic, in those of the quantities that it knows."""
    known = Frame({name: exact.frame[name] for name in JUDGED if name in set(names)})
    return judge_pixels(exact.scene, known, pixels_to_judge(exact.scene, dict(comparisons)))
