"""One run of `minirt verify`: render, compare, decide, and leave every report behind."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryFile

from converters.atomic import atomic_file
from minirt.errors import InputError
from minirt.scene import Scene
from reference.jobs.cluster import Cluster
from reference.source import Reference
from reference.verify.options import DEFAULTS, Options
from reference.verify.results import SceneResult
from reference.verify.run import verify
from reports.history.previous import PreviousRun
from reports.page.inspector.details import details_of
from reports.page.report import report_html
from reports.page.thumbnails import agreement_thumbnail, frame_thumbnail
from reports.results.baseline import Baseline
from reports.results.findings import findings_of
from reports.results.junit import junit_xml
from reports.results.mutants import KillMatrix
from reports.results.provenance import provenance, without_passwords
from reports.results.record import Run, results_json
from reports.results.summary import summary_markdown
from reports.results.verdict import decide

#: Called with the number of scenes that are done, and of all.
Progress = Callable[[int, int], None]

#: The files that a run leaves in its folder, and what makes each.
REPORTS: dict[str, Callable[[Run], str]] = {
    "results.json": results_json,
    "junit.xml": junit_xml,
    "summary.md": summary_markdown,
    "report.html": report_html,
}


@dataclass(frozen=True)
class RunOptions:
    """How scenes are compared, and what else its reports take in.

    Attributes
    ----------
    comparison : Options
        The run itself sets the callbacks for what its reports show.
    required : collection of str
        Names of references without whose answer the run is incomplete.
    baseline : Baseline or None
        Failures that are known, and excused for a time.
    judged : str
        The implementation that is judged, as it was named; empty for minirt itself.
    previous : PreviousRun or None
        What a history knows of the scenes.
    mutants : KillMatrix or None
        To be shown in the reports.
    """

    comparison: Options = DEFAULTS
    required: Collection[str] = ()
    baseline: Baseline | None = None
    judged: str = ""
    previous: PreviousRun | None = None
    mutants: KillMatrix | None = None


def run_verify(
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    out_dir: str | Path,
    options: RunOptions = RunOptions(),
    progress: Progress | None = None,
    cluster: Cluster | None = None,
) -> Run:
    """Compare minirt with references on scenes, and write the reports into a folder.

    Parameters
    ----------
    scenes : sequence of Scene
        None at all makes a run that failed, not one that passed.
    references : sequence of Reference
    out_dir : path
        Made where it is not there; other files in it stay.
    options : RunOptions
    progress : callable, optional
        Called in this process when one more scene is done.
    cluster : Cluster, optional
        Whose workers do the scenes in place of this machine.

    Returns
    -------
    Run
        With the verdict and the exit status.

    Raises
    ------
    InputError
        The folder cannot be written; nothing was rendered then.
    """
    folder = made_folder(Path(out_dir))
    start, origin = time.perf_counter(), provenance()
    results = _compared(scenes, references, options.comparison, progress, cluster)
    names = [reference.name for reference in references]
    remarks = _frames_of_earlier_runs(results)
    if options.baseline is not None:
        results, of_entries = options.baseline.applied(results)
        remarks += [f"Baseline: {remark}" for remark in of_entries]
    findings = findings_of(results, names)
    run = Run(
        findings=findings,
        references=tuple(names),
        required=tuple(sorted(options.required)),
        verdict=decide(findings, names, options.required),
        provenance=origin,
        seconds=time.perf_counter() - start,
        folder=folder,
        remarks=tuple(remarks),
        judged=without_passwords(options.judged),
        previous=options.previous,
        mutants=options.mutants,
    )
    write_reports(run)
    return run


def _compared(
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    comparison: Options,
    progress: Progress | None,
    cluster: Cluster | None,
) -> list[SceneResult]:
    """Every scene's result in the order of the scenes, with what the page shows of it."""
    callbacks = replace(
        comparison.callbacks,
        details=details_of,
        draw=agreement_thumbnail,
        thumbnail=frame_thumbnail,
    )
    results: list[SceneResult] = []
    for result in verify(scenes, references, replace(comparison, callbacks=callbacks), cluster):
        results.append(result)
        if progress is not None:
            progress(len(results), len(scenes))
    return results if cluster is None else sorted(results, key=lambda r: scenes.index(r.scene))


def _frames_of_earlier_runs(results: Sequence[SceneResult]) -> list[str]:
    """How many frames of references were not rendered again."""
    answers = [answer for result in results for answer in result.references]
    kept = sum(answer.kept for answer in answers)
    if not kept:
        return []
    return [
        f"{kept} of {len(answers)} frames of references are those of an earlier run, of the same "
        "scene, program and versions: --no-cache renders them again"
    ]


def write_reports(run: Run) -> None:
    """Write every report of a run into its folder, each whole or not at all.

    All are made before the first is written, so that a folder hardly ever holds those of two
    runs.
    """
    made = {name: make(run) for name, make in REPORTS.items()}
    for name, text in made.items():
        with atomic_file(run.folder / name) as path:
            path.write_text(text, encoding="utf-8", newline="\n")


def made_folder(folder: Path) -> Path:
    """A folder that can be written to, made where it is not there.

    Raises
    ------
    InputError
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            return folder
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            "the reports cannot be written", where=repr(str(folder))[:300], got=reason
        ) from None
