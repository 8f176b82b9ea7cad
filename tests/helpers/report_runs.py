"""Runs for the reports' tests, made in this process: real checks, and every other way to end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from minirt.quantities import QUANTITIES
from minirt.render import render
from minirt.scene import Scene
from reference.compare.check import State, without_answer
from reference.source import Reference, Unsupported
from reference.verify.options import Callbacks, Options
from reference.verify.rendering import RenderedFrame, render_to_file
from reference.verify.results import ReferenceResult, SceneResult
from reference.verify.run import reference_result
from reference.verify.scene import compare_scene
from reports.page.inspector.details import details_of
from reports.page.thumbnails import frame_thumbnail
from reports.results.findings import findings_of
from reports.results.provenance import provenance
from reports.results.record import Run
from reports.results.verdict import decide
from tests.helpers.fake_references import (
    HOSTILE,
    CannotSay,
    Faulty,
    Honest,
    Missing,
    OnePixel,
    Partial,
    WrongSize,
    small_scene,
)

NAMES = tuple(QUANTITIES)

#: References that end as a child process does, by name: state, reason, last output.
ENDINGS: dict[str, tuple[State, str, str]] = {
    "aborting": (
        "crashed",
        "the process was ended by SIGABRT",
        f"first line\nLLVM ERROR: {HOSTILE}",
    ),
    "hanging": ("timed out", "no answer within 5 s", "loading the kernel"),
}


def result_of(scene: Scene, references: Sequence[Reference]) -> SceneResult:
    """One scene against references; those named in ENDINGS end so, without a child process."""
    with TemporaryDirectory() as folder:
        ended = [_answer(scene, r, Path(folder) / str(k)) for k, r in enumerate(references)]
        answered = [
            (reference, each)
            for reference, each in zip(references, ended, strict=True)
            if isinstance(each, RenderedFrame)
        ]
        compared = compare_scene(scene, answered, Options(callbacks=Callbacks(details_of)))
    results = []
    for each in ended:
        if isinstance(each, ReferenceResult):
            results.append(each)
            continue
        results.append(replace(reference_result(each, compared), seconds=0.25))
    picture = frame_thumbnail(render(scene))
    return SceneResult(scene, tuple(results), 0.5, 100 * 2**20, thumbnail=picture)


def _answer(scene: Scene, reference: Reference, folder: Path) -> ReferenceResult | RenderedFrame:
    if reference.name in ENDINGS:
        state, reason, output = ENDINGS[reference.name]
        return _none(reference, state, reason, output)
    missing = reference.missing()
    if missing:
        return _none(reference, "missing", missing)
    folder.mkdir()
    try:
        return render_to_file(reference, scene, folder)
    except Unsupported as error:
        return _none(reference, "not supported", str(error))


def _none(reference: Reference, state: State, reason: str, output: str = "") -> ReferenceResult:
    checks = without_answer(NAMES, state, reason)
    return ReferenceResult(reference.name, reference.name, checks, output=output)


def run_of(
    scenes: Sequence[Scene], references: Sequence[Reference], required: Sequence[str] = ()
) -> Run:
    """A run that was not written anywhere."""
    results = tuple(result_of(scene, references) for scene in scenes)
    names = tuple(reference.name for reference in references)
    findings = findings_of(results, names)
    verdict = decide(findings, names, required)
    return Run(findings, names, tuple(required), verdict, provenance(), 1.5, Path("report"))


@cache
def good_run() -> Run:
    """Two scenes that pass."""
    return run_of([small_scene(), small_scene("second")], [Honest()], ["honest"])


@cache
def troubled_run() -> Run:
    """A scene with a hostile name and one without, each ending in every possible way."""
    ended = (Honest("aborting"), Honest("hanging"))
    references = (
        Honest(), OnePixel(), Faulty(), Partial(), WrongSize(), CannotSay(), Missing(), *ended,
    )  # fmt: skip
    scenes = (small_scene(HOSTILE, about=HOSTILE, proves=HOSTILE), small_scene())
    return run_of(scenes, references, ["missing"])


@cache
def empty_run() -> Run:
    """No scene at all."""
    return run_of([], [Honest()])
