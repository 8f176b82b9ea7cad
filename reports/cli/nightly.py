"""`minirt nightly`: all that a night should try, and a page of how it went from night to night."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.cli.options import (
    CORES,
    ClusterOption,
    HistoryOption,
    JobsOption,
    Json,
    RequireOption,
    ScenesArgument,
)
from reports.history import HISTORY_FILE
from reports.inputs import names_in
from reports.terminal.console import print_json, progress, stderr_console, stdout_console

if TYPE_CHECKING:
    from reports.history.store import History
    from reports.nightly.night import Night, SettingsModel
    from reports.nightly.steps import Job

#: Seconds that the command of --notify may take.
_NOTIFYING = 120
_UNITS = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0}


def nightly(
    scenes: ScenesArgument = None,
    reference: Annotated[
        str, typer.Option(metavar="NAMES", help="Renderers to compare with, as for verify.")
    ] = "",
    require: RequireOption = "",
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where all nights go.")
    ] = Path("nights"),
    budget: Annotated[
        str, typer.Option(metavar="TIME", help="For random scenes, with a new seed: 90s, 20m, 2h.")
    ] = "20m",
    mutants: Annotated[
        str, typer.Option(metavar="NAMES", help="Mutants to run, separated by commas; all.")
    ] = "",
    keep: Annotated[int, typer.Option(min=1, metavar="N", help="Nights whose folders stay.")] = 30,
    notify: Annotated[
        str,
        typer.Option(
            metavar="'CMD'",
            help="A command that gets the summary on its standard input; MINIRT_EXIT_STATUS and "
            "MINIRT_NIGHT, the night's folder, are in its environment.",
        ),
    ] = "",
    jobs: JobsOption = CORES,
    timeout: Annotated[
        int, typer.Option(min=1, metavar="SECONDS", help="For a reference and a scene.")
    ] = 300,
    history: HistoryOption = "",
    cluster: ClusterOption = None,
    json: Json = False,
) -> None:
    """Verify, fuzz with a new seed, run the mutants; keep the history and a landing page.

    Each night has a folder, DIR/index.html shows them all. A night that was killed goes on with
    what is missing when the same command runs again within a day.
    """
    from reference.mutants.run import chosen_mutants
    from reports.history.store import History as Store
    from reports.inputs import chosen_scenes, cluster_at, references_of
    from reports.nightly.night import begun
    from reports.nightly.steps import Job, take
    from reports.run import made_folder

    seconds, command = _seconds(budget), _words(notify)
    chosen, required = references_of(names_in(reference), names_in(require))
    named = names_in(mutants)
    chosen_mutants(named)
    loaded = chosen_scenes(scenes)
    job = Job(loaded, chosen, required, seconds, tuple(named), jobs, timeout)
    target = history or str(made_folder(out) / HISTORY_FILE)
    with (
        cluster_at(cluster) as workers,
        Store(target) as kept,
        begun(made_folder(out), _settings(job)) as night,
    ):
        stderr_console().print(f"night: {night.folder}", soft_wrap=True)
        with progress("nightly") as tell:
            sent = replace(job, cluster=workers)
            take(night, sent, kept, lambda _, done, total: tell(int(done), int(total)))
        status = _finish(night, out, kept, keep, command)
        if json:
            print_json(
                {
                    **night.note.model_dump(mode="json"),
                    "folder": str(night.folder),
                    "exit_status": status,
                }
            )
        else:
            _print(night, out)
    raise typer.Exit(status)


def _settings(job: Job) -> SettingsModel:
    from reports.nightly.night import SettingsModel
    from reports.results.provenance import provenance

    return SettingsModel(
        commit=provenance().commit,
        scenes=[scene.sha256 for scene in job.scenes],
        references=[reference.name for reference in job.references],
        required=list(job.required),
        budget=job.budget,
        mutants=list(job.mutants),
    )


def _finish(night: Night, out: Path, history: History, keep: int, command: list[str]) -> int:
    """Leave the pages, remove old nights, tell whoever wants to know; the exit status."""
    from reports.nightly.landing import night_markdown, write_landing
    from reports.nightly.night import alone, remove_old, write

    summary = night_markdown(night, history)
    write(night.folder / "night.md", summary)
    night.save(finished=datetime.now(UTC).isoformat(timespec="seconds"))
    with alone(out):
        for name in remove_old(out, keep, night):
            stderr_console().print(f"night {name}: removed, {keep} are kept", soft_wrap=True)
        write_landing(out, history)
    status = night.note.exit_status
    if command and not _notified(command, summary, night, status):
        return status or 3
    return status


def _notified(command: list[str], summary: str, night: Night, status: int) -> bool:
    """Hand the summary to a command; whether that ended well."""
    import subprocess

    told = {"MINIRT_EXIT_STATUS": str(status), "MINIRT_NIGHT": str(night.folder.resolve())}
    try:
        done = subprocess.run(
            command, input=summary, text=True, encoding="utf-8", timeout=_NOTIFYING,
            env={**os.environ, **told}, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            errors="backslashreplace",
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired, ValueError) as error:
        reason = getattr(error, "strerror", None) or f"no end within {_NOTIFYING} s"
    else:
        if done.returncode == 0:
            return True
        reason = f"exit status {done.returncode}: {done.stderr.strip()[-300:]}"
    from reports.results.words import one_line

    stderr_console().print(f"notify: {one_line(command[0])}: {one_line(reason)}", soft_wrap=True)
    return False


def _print(night: Night, out: Path) -> None:
    from reports.nightly.landing import sentence
    from reports.results.words import one_line

    console = stdout_console()
    for name, step in night.note.steps.items():
        sign = {0: "✓", 3: "!"}.get(step.exit_status, "✗")
        console.print(f"{sign} {name}: {one_line(step.sentence, 1000)}", soft_wrap=True)
    console.print(f"page: {(out / 'index.html').resolve()}", soft_wrap=True)
    console.print(one_line(sentence(night), 1000), soft_wrap=True)


def _seconds(text: str) -> float:
    """A time such as 90s, 20m, 2h, or a number of seconds."""
    from minirt.errors import InputError

    found = re.fullmatch(r"(\d{1,6}(?:\.\d+)?)([smh]?)", text.strip())
    seconds = float(found[1]) * _UNITS[found[2]] if found else 0.0
    if seconds < 1:
        raise InputError(
            "not a time", where="--budget", got=repr(text)[:80],
            expected="at least a second, as 90s, 20m or 2h",
        )  # fmt: skip
    return seconds


def _words(command: str) -> list[str]:
    """The words of a command, as a shell would split it; no shell runs it."""
    import shlex

    from minirt.errors import InputError

    try:
        return shlex.split(command)
    except ValueError as error:
        raise InputError(
            "not a command", where="--notify", got=repr(command)[:80], expected=str(error)
        ) from None
