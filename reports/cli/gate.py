"""`minirt gate`: somebody else's implementation, judged on many scenes."""

from __future__ import annotations

import shlex
from datetime import date, timedelta
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.cli.options import (
    CORES,
    HistoryOption,
    JobsOption,
    Json,
    MutantsOption,
    NoCacheOption,
    NoHistoryOption,
    ScenesArgument,
)
from reports.cli.subject_options import takes_subject
from reports.gate.subject import Subject
from reports.terminal.console import print_json, progress, stderr_console, stdout_console

if TYPE_CHECKING:
    from reports.results.baseline import Baseline
    from reports.results.record import Run

#: Days for which a new entry of a baseline excuses a failure.
_DAYS = 90


class Language(StrEnum):
    """In which language a starter kit begins a tracer."""

    cpp = "cpp"
    javascript = "javascript"
    python = "python"


@takes_subject
def gate(
    scenes: ScenesArgument = None,
    *,
    subject: Subject,
    quantities: Annotated[
        str, typer.Option(metavar="NAMES", help="Which to judge, separated by commas; all.")
    ] = "",
    require: Annotated[
        str, typer.Option(metavar="NAMES", help="Quantities that must be given.")
    ] = "",
    baseline: Annotated[
        Path | None,
        typer.Option(metavar="FILE", show_default=False, help="Failures that are known."),
    ] = None,
    update: Annotated[
        bool, typer.Option("--update-baseline", help="Record every failure of this run as known.")
    ] = False,
    reason: Annotated[str, typer.Option(help="Why new entries of the baseline fail.")] = "",
    until: Annotated[
        str,
        typer.Option(metavar="YYYY-MM-DD", help="Until when they are excused; 90 days from now."),
    ] = "",
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where the reports go.")
    ] = Path("report"),
    jobs: JobsOption = CORES,
    mutants: MutantsOption = None,
    no_cache: NoCacheOption = False,
    init: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", show_default=False,
            help="Judge nothing: write a starter kit, with the protocol, three scenes and a stub.",
        ),
    ] = None,
    language: Annotated[
        Language, typer.Option(help="Of the starter kit's stub.")
    ] = Language.python,
    history: HistoryOption = "",
    no_history: NoHistoryOption = False,
    json: Json = False,
) -> None:  # fmt: skip
    """Judge another implementation, pixel by pixel.

    It is given scenes, never minirt's frames. Every quantity that it gives is compared where the
    exact answer is stable under the error that it declares; there not one pixel may be wrong.
    """
    from minirt.render import chosen_quantities
    from reference.diagnose.by_mutant import diagnose
    from reference.verify.options import Callbacks, Options
    from reports.history.recording import opened_history, previous_run_of, record_run
    from reports.inputs import cache_unless, chosen_scenes, scene_names
    from reports.results.mutants import read_kill_matrix
    from reports.results.record import results_document
    from reports.run import RunOptions, run_verify
    from reports.terminal.results import print_run

    if init is not None:
        _init(init, language, json)
        return
    judged, last = subject.reference(), _until(until)
    chosen = chosen_quantities(quantities or None)
    required = _required(require, chosen)
    loaded = chosen_scenes(scenes)
    for scene in loaded:
        judged.declare(scene)  # refused before anything is rendered
    known = _baseline(baseline, update)
    kills = None if mutants is None else read_kill_matrix(mutants)
    name = subject.cmd or subject.python or str(subject.frames)
    with opened_history(history, not no_history, out) as kept:
        previous = previous_run_of(kept, loaded, [judged], name)
        with progress("gate") as tell:
            comparison = Options(
                chosen, required, subject.process_timeout, jobs, cache_unless(no_cache),
                Callbacks(diagnose=diagnose),
            )  # fmt: skip
            options = RunOptions(comparison, [judged.name], known, name, previous, kills)
            run = run_verify(loaded, [judged], out, options, tell)
        status, lines = record_run(run, kept)
    for line in lines:
        stderr_console().print(line, soft_wrap=True)
    print_run(run, stderr_console() if json else stdout_console())
    _look_closer(
        run, dict(zip((scene.name for scene in loaded), scene_names(scenes), strict=True)), subject
    )
    if json:
        print_json(results_document(run))
    if update and baseline is not None and known is not None:
        from reports.results.baseline import write_baseline
        from reports.results.words import count

        why = reason or "recorded when the gate was set up"
        number = write_baseline(baseline, run.results, known, why, last)
        told = f"{baseline}: {count(number, 'failure')} recorded; a run with --baseline passes now"
        stderr_console().print(told, soft_wrap=True)
        raise typer.Exit(0)
    raise typer.Exit(status)


def _look_closer(run: Run, named: dict[str, str], subject: Subject) -> None:
    """The command that shows the first wrong pixel; from standard input no scene comes twice."""
    for cell in run.findings.failing:
        check = cell.check
        if check.worst is not None and check.wrong and named[cell.scene] != "-":
            words = [named[cell.scene], "--pixel", check.worst.column, check.worst.row]
            command = shlex.join(["minirt", "explain", *map(str, words), *subject.arguments()])
            stderr_console().print(f"look closer: {command}", soft_wrap=True)
            return


def _init(folder: Path, language: Language, json: bool) -> None:
    from reports.gate.starter_kit import write_kit

    files = [str(path) for path in write_kit(folder, language.value)]
    if json:
        print_json({"folder": str(folder), "files": files})
    stderr_console().print(f"{folder}: {len(files)} files. Begin with README.md.", soft_wrap=True)


def _required(require: str, chosen: tuple[str, ...]) -> tuple[str, ...]:
    """Quantities that must be given: each must be judged, too."""
    from minirt.errors import InputError
    from minirt.render import chosen_quantities

    required = chosen_quantities(require) if require else ()
    unjudged = [name for name in required if name not in chosen]
    if unjudged:
        raise InputError(
            "required, but not judged", where="--require", got=", ".join(unjudged),
            expected="only what --quantities names, or no --quantities",
        )  # fmt: skip
    return required


def _baseline(path: Path | None, update: bool) -> Baseline | None:
    from minirt.errors import InputError
    from reports.results.baseline import Baseline, read_baseline

    today = date.today()
    if path is None:
        if update:
            raise InputError("no baseline to update", expected="--baseline FILE")
        return None
    if update and not path.exists():
        return Baseline((), today)
    return read_baseline(path, today)


def _until(text: str) -> date:
    from minirt.errors import InputError

    if not text:
        return date.today() + timedelta(days=_DAYS)
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise InputError(
            "not a date", where="--until", got=repr(text)[:80], expected="as 2027-01-31"
        ) from None
