"""The steps of a nightly run: each writes its result into the folder, and is not repeated."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from minirt.errors import MinirtError
from reference.mutants.run import chosen_mutants, run_mutants
from reference.verify.options import Options
from reports.history.difference import difference
from reports.history.entry import Entry, read_entry
from reports.history.pages import compare_html
from reports.history.recording import previous_run_of
from reports.history.store import History
from reports.history.text import verdict_of
from reports.nightly.fuzz_step import fuzz_step
from reports.nightly.nightly_run import NightlyRun, StepResult, write, write_json
from reports.nightly.options import NightlyOptions, Progress
from reports.results.mutants import (
    mutants_document,
    mutants_sentence,
    mutants_status,
    read_kill_matrix,
)
from reports.results.words import one_line
from reports.run import REPORTS, RunOptions, run_verify


def verify_step(
    night: NightlyRun, options: NightlyOptions, history: History, progress: Progress
) -> StepResult:
    """Compare minirt with its references, and write the reports, with the mutants in them."""
    kills = night.folder / "mutants.json"
    if not all((night.folder / name).exists() for name in REPORTS):
        run_options = RunOptions(
            Options(timeout=options.timeout, jobs=options.jobs),
            options.required,
            previous=previous_run_of(history, options.scenes, options.references),
            mutants=read_kill_matrix(kills) if kills.exists() else None,
        )
        run_verify(
            options.scenes,
            options.references,
            night.folder,
            run_options,
            partial(progress, "verify"),
            options.cluster,
        )
    run = read_entry(night.folder)
    return StepResult(exit_status=run.exit_status, sentence=run.sentence, seconds=run.seconds)


def history_step(night: NightlyRun, history: History) -> StepResult:
    """Add the run to the history, and compare it with the one before."""
    start = time.perf_counter()
    run = read_entry(night.folder)
    number = history.append(run)
    night.save(run=number)
    before = previous_run(history, run, number)
    words = f"run {number}, the first of its series"
    if before is not None:
        found = difference(before, history.entry(number))
        write(night.folder / "compare.html", compare_html(found))
        words = f"run {number}, after run {before.number}: {verdict_of(found)}"
    return StepResult(exit_status=0, sentence=words, seconds=time.perf_counter() - start)


def previous_run(history: History, run: Entry, number: int) -> Entry | None:
    """The run before a run of its series."""
    found = history.latest(run.series, before=number)
    return None if found is None else history.entry(found)


def mutants_step(night: NightlyRun, options: NightlyOptions, progress: Progress) -> StepResult:
    """Run the mutants: whether the checks notice wrong versions of the rules."""
    from reference.mutants.floor import sensitivity_floor

    start = time.perf_counter()
    names = chosen_mutants(options.mutants)
    found = run_mutants(names, options.jobs, options.cluster, partial(progress, "mutants"))
    write_json(night.folder / "mutants.json", mutants_document(found, sensitivity_floor()))
    return StepResult(
        exit_status=mutants_status(found),
        sentence=mutants_sentence(found),
        seconds=time.perf_counter() - start,
    )


def run_steps(
    night: NightlyRun, options: NightlyOptions, history: History, progress: Progress
) -> None:
    """Run every step that is not done yet; one that fails with an error does not stop the others.

    The history step always runs: it adds no run twice, and the history may be another one than
    before an interruption.
    """
    steps: dict[str, Callable[[], StepResult]] = {
        "mutants": lambda: mutants_step(night, options, progress),
        "verify": lambda: verify_step(night, options, history, progress),
        "history": lambda: history_step(night, history),
        "fuzz": lambda: fuzz_step(night, options, progress),
    }
    for name, step in steps.items():
        if name == "history" or name not in night.record.steps:
            start = time.perf_counter()
            try:
                result = step()
            except Exception as error:
                result = _failed_step(error, time.perf_counter() - start)
            night.finish_step(name, result)


def _failed_step(error: Exception, seconds: float) -> StepResult:
    kind = (
        "" if isinstance(error, MinirtError) else f"a mistake in minirt: {type(error).__name__}: "
    )
    return StepResult(exit_status=3, sentence=one_line(f"{kind}{error}", 1000), seconds=seconds)
