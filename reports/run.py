"""One run of `minirt verify`: render, compare, decide, and leave every report behind."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryFile

from converters.atomic import atomic_file
from minirt.errors import InputError
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.cache import Cache
from reference.jobs.cluster import Cluster
from reference.source import Reference
from reference.verify import TIMEOUT, Diagnose, SceneResult, verify
from reports.history.before import Before
from reports.page.portrait import portrayed
from reports.page.report import report_html
from reports.results.baseline import Baseline
from reports.results.digest import agreement_of, digest_of
from reports.results.junit import junit_xml
from reports.results.kills import KillMatrix
from reports.results.provenance import provenance, without_passwords
from reports.results.record import Run, results_json
from reports.results.summary import summary_markdown
from reports.results.verdict import decide

#: Called with a result and the number of scenes when one more scene is done.
Progress = Callable[[SceneResult, int], None]

#: The files that a run leaves in its folder, and what makes each.
REPORTS: dict[str, Callable[[Run], str]] = {
    "results.json": results_json,
    "junit.xml": junit_xml,
    "summary.md": summary_markdown,
    "report.html": report_html,
}


def run_verify(
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    out_dir: str | Path,
    jobs: int = 2,
    required: Collection[str] = (),
    progress: Progress | None = None,
    *,
    timeout: float = TIMEOUT,
    quantities: Iterable[str] = tuple(QUANTITIES),
    given: Collection[str] = (),
    cache: Cache | None = None,
    baseline: Baseline | None = None,
    diagnose: Diagnose | None = None,
    judged: str = "",
    before: Before | None = None,
    mutants: KillMatrix | None = None,
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
    jobs : int
        Processes of each kind, at least 1.
    required : collection of str
        Names of references without whose answer the run is incomplete.
    progress : callable, optional
        Called in this process for each scene with the number of all scenes: in order, or from a
        cluster as they are done.
    timeout : float
        Seconds that a reference may take for one scene.
    quantities : iterable of str
        What to compare.
    given : collection of str
        Quantities that every reference must give.
    cache : Cache, optional
        Where frames and their stability are kept from run to run.
    baseline : Baseline, optional
        Failures that are known, and excused for a time.
    diagnose : callable, optional
        Names what explains a failure.
    judged : str
        The implementation that is judged, as it was named; empty for minirt itself.
    before : Before, optional
        What a history knows of the scenes.
    mutants : KillMatrix, optional
        To be shown in the reports.
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
    results = []
    for result in verify(
        scenes, references, jobs, digest_of, timeout, quantities, agreement_of, given, cache,
        diagnose, portrayed, cluster,
    ):  # fmt: skip
        results.append(result)
        if progress is not None:
            progress(result, len(scenes))
    if cluster is not None:
        results.sort(key=lambda result: scenes.index(result.scene))
    names = [reference.name for reference in references]
    remarks = _kept(results)
    if baseline is not None:
        results, said = baseline.applied(results)
        remarks += [f"Baseline: {remark}" for remark in said]
    run = Run(
        results=tuple(results),
        references=tuple(names),
        required=tuple(sorted(required)),
        verdict=decide(results, names, required),
        provenance=origin,
        seconds=time.perf_counter() - start,
        folder=folder,
        remarks=tuple(remarks),
        judged=without_passwords(judged),
        before=before,
        mutants=mutants,
    )
    write_reports(run)
    return run


def _kept(results: Sequence[SceneResult]) -> list[str]:
    """What was not rendered anew."""
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

    All are made before the first is written, so that a folder hardly ever holds those of two runs.
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
