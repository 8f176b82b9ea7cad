"""Add a run to its history: open it before the run, ask what it knows, append the run after."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from minirt.errors import InputError
from minirt.scene import Scene
from reference.jobs.cluster import Cluster
from reference.source import Reference
from reports.history import HISTORY_FILE
from reports.history.entry import entry_of, kept_name, series_of
from reports.history.previous import Point, PreviousRun
from reports.results.provenance import without_passwords
from reports.results.record import Run, results_document
from reports.results.words import one_line
from reports.run import Progress, RunOptions, made_folder, run_verify

if TYPE_CHECKING:
    from reports.history.store import History

#: Newest runs of a scene that the report of a run shows.
MOST_POINTS = 60


@dataclass(frozen=True)
class HistoryTarget:
    """The history that a run is added to.

    Attributes
    ----------
    name : str
        A file or the URL of a database; empty: a file beside the reports.
    wanted : bool
        False: the run is added to no history.
    """

    name: str = ""
    wanted: bool = True


@dataclass(frozen=True)
class RecordedRun:
    """A finished run, its exit status, and lines that say how the history took it."""

    run: Run
    exit_status: int
    remarks: list[str]


def recorded_run(
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    out: Path,
    options: RunOptions,
    history: HistoryTarget,
    progress: Progress | None = None,
    cluster: Cluster | None = None,
) -> RecordedRun:
    """Compare references on scenes beside what a history knows of them, and add the run to it.

    The history is opened before anything is rendered. The other parameters are those of
    `run_verify`.

    Raises
    ------
    InputError
        The history cannot be opened, or the folder cannot be written.
    """
    with opened_history(history, out) as kept:
        previous = previous_run_of(kept, scenes, references, options.judged)
        options = replace(options, previous=previous)
        run = run_verify(scenes, references, out, options, progress, cluster)
        status, remarks = record_run(run, kept)
    return RecordedRun(run, status, remarks)


@contextmanager
def opened_history(target: HistoryTarget, out: Path) -> Iterator[History | None]:
    """Open the history of a run before anything is rendered; None where none is wanted.

    `out` is the folder of the reports.

    Raises
    ------
    InputError
        It cannot be opened.
    """
    if not target.wanted:
        yield None
        return
    from reports.history.store import History  # SQLAlchemy: slow to import

    with History(target.name or str(made_folder(out) / HISTORY_FILE)) as history:
        yield history


def previous_run_of(
    history: History | None,
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    judged: str = "",
) -> PreviousRun | None:
    """What a history knows of a run's scenes; None without a history."""
    if history is None:
        return None
    wanted = [(scene.name, scene.sha256) for scene in scenes]
    names = [reference.name for reference in references]
    return previous_run(history, wanted, without_passwords(judged), names)


def previous_run(
    history: History, wanted: Sequence[tuple[str, str]], judged: str, references: Sequence[str]
) -> PreviousRun:
    """What is known of scenes before a run that is about to begin.

    Parameters
    ----------
    history : History
    wanted : sequence of (str, str)
        Name and SHA-256 of each scene of the run.
    judged, references
        As of the run: only runs of its series are compared with it.
    """
    series = series_of(judged, list(map(kept_name, references)))
    number = history.latest(series)
    if number is None:
        return PreviousRun(None, {}, {}, {})
    last = history.entry(number)
    names = {kept_name(name): name for name, _ in wanted}
    found = history.trends(names, series, MOST_POINTS)
    return PreviousRun(
        last=Point(number, last.started, last.commit, last.outcome, None),
        cells={
            (names.get(cell.scene, cell.scene), cell.reference, cell.check.quantity): cell.check
            for cell in last.cells()
        },
        scenes={names.get(scene.name, scene.name): scene.sha256 for scene in last.scenes},
        trends={names[name]: points[series] for name, points in found.items()},
    )


def record_run(run: Run, history: History | None) -> tuple[int, list[str]]:
    """Add a finished run to its history.

    Returns
    -------
    int
        The run's exit status; 3 in place of 0 where the history refused the run, whose reports
        are in its folder all the same.
    list of str
        Lines that tell the user what happened.
    """
    if history is None:
        return run.exit_status, []
    try:
        number = history.append(entry_of(results_document(run)))
    except InputError as error:
        path = run.folder / "results.json"
        return run.exit_status or 3, [
            f"history: {one_line(str(error), 1000)}",
            f"history: minirt report record {path} adds the run later",
        ]
    return run.exit_status, [f"history: run {number} in {history.shown}"]
