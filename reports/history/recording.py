"""Add a run to its history: open it before the run, ask what it knows, append the run after."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from minirt.errors import InputError
from minirt.scene import Scene
from reference.source import Reference
from reports.history import HISTORY_FILE
from reports.history.entry import entry_of
from reports.history.previous import PreviousRun
from reports.results.provenance import without_passwords
from reports.results.record import Run, results_document
from reports.results.words import one_line
from reports.run import made_folder

if TYPE_CHECKING:
    from reports.history.store import History


@contextmanager
def opened_history(target: str, wanted: bool, out: Path) -> Iterator[History | None]:
    """Open the history of a run before anything is rendered; None where none is wanted.

    Parameters
    ----------
    target : str
        A file or the URL of a database; empty: a file beside the reports.
    wanted : bool
    out : Path
        The folder of the reports.

    Raises
    ------
    InputError
        It cannot be opened.
    """
    if not wanted:
        yield None
        return
    from reports.history.store import History  # SQLAlchemy: slow to import

    with History(target or str(made_folder(out) / HISTORY_FILE)) as history:
        yield history


def previous_run_of(
    history: History | None,
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    judged: str = "",
) -> PreviousRun | None:
    """What a history knows of a run's scenes."""
    if history is None:
        return None
    wanted = [(scene.name, scene.sha256) for scene in scenes]
    names = [reference.name for reference in references]
    return history.previous_run(wanted, without_passwords(judged), names)


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
