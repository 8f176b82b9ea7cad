"""Start or continue a nightly run, and finish it: pages, old folders, notification."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime

from reports.history import HISTORY_FILE
from reports.history.store import History
from reports.nightly.landing import night_markdown, sentence, write_landing
from reports.nightly.nightly_run import (
    NightlyRun,
    exclusive,
    remove_old,
    started_or_resumed,
    write,
)
from reports.nightly.options import NightlyOptions
from reports.results.words import one_line
from reports.run import made_folder

#: Seconds that the command of --notify may take.
NOTIFY_TIMEOUT = 120.0


@contextmanager
def nightly_run(options: NightlyOptions) -> Iterator[tuple[NightlyRun, History]]:
    """The run to work on, new or continued, and the history; both are held until the block ends."""
    out = made_folder(options.out)
    with (
        History(options.history or str(out / HISTORY_FILE)) as history,
        started_or_resumed(out, options.settings) as night,
    ):
        yield night, history


def finish(night: NightlyRun, options: NightlyOptions, history: History) -> tuple[int, list[str]]:
    """Write the pages, remove old runs, and run the command of --notify.

    Returns
    -------
    int
        The exit status; 3 in place of 0 where the notification failed.
    list of str
        Lines that tell the user what happened.
    """
    out, keep = options.out, options.keep
    summary = night_markdown(night, history)
    write(night.folder / "night.md", summary)
    night.save(finished=datetime.now(UTC).isoformat(timespec="seconds"))
    with exclusive(out):
        removed = remove_old(out, keep, night)
        write_landing(out, history)
    lines = [f"night {name}: removed, {keep} are kept" for name in removed]
    status = night.record.exit_status
    error = _notify(options.notify, summary, night, status) if options.notify else ""
    if error:
        lines.append(f"notify: {one_line(options.notify[0])}: {one_line(error)}")
        status = status or 3
    return status, lines


def run_lines(night: NightlyRun, options: NightlyOptions) -> Iterator[str]:
    """A finished run for people: its steps, the page, the verdict."""
    for name, step in night.record.steps.items():
        sign = {0: "✓", 3: "!"}.get(step.exit_status, "✗")
        yield f"{sign} {name}: {one_line(step.sentence, 1000)}"
    yield f"page: {(options.out / 'index.html').resolve()}"
    yield one_line(sentence(night), 1000)


def _notify(command: Sequence[str], summary: str, night: NightlyRun, status: int) -> str:
    """Hand the summary to a command; what went wrong, or empty."""
    told = {"MINIRT_EXIT_STATUS": str(status), "MINIRT_NIGHT": str(night.folder.resolve())}
    try:
        done = subprocess.run(
            command, input=summary, text=True, encoding="utf-8", timeout=NOTIFY_TIMEOUT,
            env={**os.environ, **told}, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            errors="backslashreplace",
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired, ValueError) as error:
        return getattr(error, "strerror", None) or f"no end within {NOTIFY_TIMEOUT:g} s"
    if done.returncode == 0:
        return ""
    return f"exit status {done.returncode}: {done.stderr.strip()[-300:]}"
