"""The options of every command that writes a history, and what it says of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.terminal.console import stderr_console

if TYPE_CHECKING:
    from minirt.scene import Scene
    from reference.source import Reference
    from reports.history.before import Before
    from reports.history.store import History
    from reports.results.record import Run

#: The name of a history's file in the folder of the reports.
FILE = "history.sqlite"

HistoryOption = Annotated[
    str,
    typer.Option(
        "--history", metavar="FILE|URL", envvar="MINIRT_HISTORY", show_default=False,
        help="The history that the run is added to: a SQLite file, or the URL of a database; "
        f"without it {FILE} beside the reports.",
    ),
]  # fmt: skip
NoHistoryOption = Annotated[bool, typer.Option("--no-history", help="Add the run to no history.")]


@contextmanager
def opened(target: str, none: bool, out: Path) -> Iterator[History | None]:
    """The history that the options name, opened before anything is rendered; None: none wanted.

    Raises
    ------
    InputError
        It cannot be opened.
    """
    if none:
        yield None
        return
    from reports.history.store import History
    from reports.run import made_folder

    with History(target or str(made_folder(out) / FILE)) as history:
        yield history


def known_before(
    history: History | None,
    scenes: Sequence[Scene],
    references: Sequence[Reference],
    judged: str = "",
) -> Before | None:
    """What a history knows of a run's scenes."""
    if history is None:
        return None
    from reports.results.provenance import without_passwords

    wanted = [(scene.name, scene.sha256) for scene in scenes]
    names = [reference.name for reference in references]
    return history.before(wanted, without_passwords(judged), names)


def recorded(run: Run, history: History | None) -> int:
    """Add a finished run to its history, and say so.

    Returns
    -------
    int
        The run's exit status; 3 in place of 0 where the history refused the run, whose reports
        are in its folder all the same.
    """
    if history is None:
        return run.exit_status
    from minirt.errors import InputError
    from reports.history.entry import entry_of
    from reports.results.record import results_document
    from reports.results.words import one_line

    try:
        number = history.append(entry_of(results_document(run)))
    except InputError as error:
        console = stderr_console()
        console.print(f"history: {one_line(str(error), 1000)}", soft_wrap=True)
        path = run.folder / "results.json"
        console.print(f"history: minirt report record {path} adds the run later", soft_wrap=True)
        return run.exit_status or 3
    stderr_console().print(f"history: run {number} in {history.shown}", soft_wrap=True)
    return run.exit_status
