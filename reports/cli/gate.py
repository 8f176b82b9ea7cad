"""`minirt gate`: somebody else's implementation, judged on many scenes."""

from __future__ import annotations

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
from reports.terminal.console import (
    print_json,
    print_lines,
    progress,
    stderr_console,
    stdout_console,
)

if TYPE_CHECKING:
    from reports.gate.run import GateOptions


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
    from reports.gate.run import BaselineOptions, GateOptions
    from reports.history.recording import HistoryTarget

    if init is not None:
        _init(init, language, json)
        return
    known = BaselineOptions(baseline, update, reason, until)
    target = HistoryTarget(history, not no_history)
    options = GateOptions(scenes, quantities, require, out, jobs, mutants, no_cache, known, target)
    raise typer.Exit(_judge(subject, options, json))


def _judge(subject: Subject, options: GateOptions, json: bool) -> int:
    """Run the gate, and print what was found; the exit status."""
    from reports.gate.run import run_gate, update_baseline
    from reports.results.record import results_document
    from reports.terminal.results import print_run

    with progress("gate") as tell:
        found = run_gate(subject, options, tell)
    run, console = found.recorded.run, stderr_console()
    print_lines(found.recorded.remarks, console)
    print_run(run, console if json else stdout_console())
    if found.hint:
        print_lines([f"look closer: {found.hint}"], console)
    if json:
        print_json(results_document(run))
    if updated := update_baseline(found, options.baseline):
        print_lines([updated], console)
        return 0
    return found.recorded.exit_status


def _init(folder: Path, language: Language, json: bool) -> None:
    from reports.gate.starter_kit import write_kit

    files = [str(path) for path in write_kit(folder, language.value)]
    if json:
        print_json({"folder": str(folder), "files": files})
    print_lines([f"{folder}: {len(files)} files. Begin with README.md."], stderr_console())
