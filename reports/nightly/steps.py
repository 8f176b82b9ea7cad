"""The steps of a night. Each leaves its result in the night's folder, and is not repeated."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from minirt.errors import MinirtError
from minirt.scene import Scene
from reference.fuzz.campaign import CAMPAIGN_FLOOR, Campaign, CampaignOptions, Failure, run_campaign
from reference.fuzz.trial import TrialWorkers
from reference.jobs.cluster import Cluster
from reference.mutants.run import chosen_mutants, run_mutants
from reference.source import Reference
from reference.verify.options import Options
from reports.fuzz.campaign import campaign_document
from reports.fuzz.case import write_case
from reports.history.difference import difference
from reports.history.entry import Entry, read_entry
from reports.history.pages import compare_html
from reports.history.recording import previous_run_of
from reports.history.store import History
from reports.history.text import verdict_of
from reports.nightly.night import Night, StepModel, write
from reports.results.mutants import (
    mutants_document,
    mutants_sentence,
    mutants_status,
    read_kill_matrix,
)
from reports.results.words import count, one_line, share
from reports.run import REPORTS, RunOptions, run_verify

#: Seconds of fuzzing after which what was found is noted, and scenes of one seed.
ROUND, MOST_SCENES = 60.0, 500
#: Failures after which a night's fuzzing ends: the next ones mostly have the same cause.
MOST_FAILURES = 10
#: Seconds for a random scene and a reference.
PATIENCE = 60.0

#: Called with the name of a step, and how far it is: done and total.
Progress = Callable[[str, float, float], None]


@dataclass(frozen=True)
class Job:
    """What a night does.

    Attributes
    ----------
    scenes, references
        As for `run_verify`.
    required : tuple of str
    budget : float
        Seconds of fuzzing.
    mutants : tuple of str
        Names; empty for all.
    jobs : int
        Processes of each kind.
    timeout : float
        Seconds for a reference and a scene of `scenes`.
    cluster : Cluster or None
        Whose workers do it all; None: this machine.
    """

    scenes: Sequence[Scene]
    references: Sequence[Reference]
    required: tuple[str, ...]
    budget: float
    mutants: tuple[str, ...]
    jobs: int
    timeout: float
    cluster: Cluster | None = None


def verify_step(night: Night, job: Job, history: History, tell: Progress) -> StepModel:
    """Compare minirt with its references; the reports, which show the mutants too."""
    kills = night.folder / "mutants.json"
    if not all((night.folder / name).exists() for name in REPORTS):
        options = RunOptions(
            Options(timeout=job.timeout, jobs=job.jobs),
            job.required,
            previous=previous_run_of(history, job.scenes, job.references),
            mutants=read_kill_matrix(kills) if kills.exists() else None,
        )
        run_verify(
            job.scenes, job.references, night.folder, options, partial(tell, "verify"), job.cluster
        )
    run = read_entry(night.folder)
    return StepModel(exit_status=run.exit_status, sentence=run.sentence, seconds=run.seconds)


def history_step(night: Night, history: History) -> StepModel:
    """Add the night's run to the history, and set it beside the one before."""
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
    return StepModel(exit_status=0, sentence=words, seconds=time.perf_counter() - start)


def previous_run(history: History, run: Entry, number: int) -> Entry | None:
    """The run before a run of its series."""
    found = history.latest(run.series, before=number)
    return None if found is None else history.entry(found)


def fuzz_step(night: Night, job: Job, tell: Progress) -> StepModel:
    """Random scenes until the budget is used up; a night that was killed goes on where it was."""
    folder = night.folder / "fuzz"
    folder.mkdir(exist_ok=True)
    rounds = _rounds(folder / "fuzz.json")
    with nullcontext() if job.cluster else TrialWorkers(_pairs(job), PATIENCE) as workers:
        while (left := job.budget - sum(r["seconds"] for r in rounds)) > 0:
            seed = (night.note.seed + len(rounds)) % 2**32
            found, cases = _campaign(seed, job, min(left, ROUND), workers, folder)
            told = {"certain": found.certain, "judged": found.judged}
            rounds.append(campaign_document(found, cases) | told)
            write(folder / "fuzz.json", _json({"rounds": rounds, **_total(rounds)}))
            tell("fuzz", job.budget - max(left - found.seconds, 0.0), job.budget)
            if not found.scenes or sum(len(r["failures"]) for r in rounds) >= MOST_FAILURES:
                break
    total = _total(rounds)
    return StepModel(
        exit_status=total["exit_status"],
        sentence=_campaign_sentence(total),
        seconds=total["seconds"],
    )


def mutants_step(night: Night, job: Job, tell: Progress) -> StepModel:
    """Whether the checks would notice."""
    from reference.mutants.floor import sensitivity_floor

    start = time.perf_counter()
    names = chosen_mutants(job.mutants)
    found = run_mutants(names, job.jobs, job.cluster, partial(tell, "mutants"))
    write(night.folder / "mutants.json", _json(mutants_document(found, sensitivity_floor())))
    return StepModel(
        exit_status=mutants_status(found),
        sentence=mutants_sentence(found),
        seconds=time.perf_counter() - start,
    )


def take(night: Night, job: Job, history: History, tell: Progress) -> None:
    """Do every step that is not done yet. One that breaks down costs itself and no other.

    The history is asked each time: it adds no run twice, and may be another than before a kill.
    """
    steps: dict[str, Callable[[], StepModel]] = {
        "mutants": lambda: mutants_step(night, job, tell),
        "verify": lambda: verify_step(night, job, history, tell),
        "history": lambda: history_step(night, history),
        "fuzz": lambda: fuzz_step(night, job, tell),
    }
    for name, step in steps.items():
        if name == "history" or name not in night.note.steps:
            start = time.perf_counter()
            try:
                result = step()
            except Exception as error:
                result = _broken(error, time.perf_counter() - start)
            night.done(name, result)


def _broken(error: Exception, seconds: float) -> StepModel:
    kind = (
        "" if isinstance(error, MinirtError) else f"a mistake in minirt: {type(error).__name__}: "
    )
    return StepModel(exit_status=3, sentence=one_line(f"{kind}{error}", 1000), seconds=seconds)


def _campaign(
    seed: int, job: Job, seconds: float, workers: TrialWorkers | None, folder: Path
) -> tuple[Campaign, list[Path]]:
    """One round, and the folders of its failures, relative to the night's `fuzz`."""
    cases: list[Path] = []

    def keep(failure: Failure) -> None:
        cases.append(write_case(failure, folder).relative_to(folder))

    options = CampaignOptions(MOST_SCENES, seconds, _pairs(job), PATIENCE)
    found = run_campaign(
        seed, job.references, options, workers=workers, cluster=job.cluster, on_failure=keep
    )
    return found, cases


def _pairs(job: Job) -> int:
    """Processes of each kind for one random scene."""
    return min(2, len(job.references))


def _rounds(path: Path) -> list[dict[str, Any]]:
    """The rounds that were finished before a kill."""
    if not path.exists():
        return []
    found: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["rounds"]
    return found


def _total(rounds: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """All rounds as one campaign; the same exit status as that of `minirt fuzz`."""
    total: dict[str, Any] = {
        name: sum(each[name] for each in rounds)
        for name in ("scenes", "compared", "unsupported", "certain", "judged", "seconds")
    }
    total["failures"] = [failure for each in rounds for failure in each["failures"]]
    total["missing"] = {n: why for each in rounds for n, why in each["missing"].items()}
    total["unjudged"] = [why for each in rounds for why in each["unjudged"]]
    total["vague"] = total["certain"] < CAMPAIGN_FLOOR * total["judged"]
    incomplete = total["missing"] or total["unjudged"] or not total["compared"]
    failed = total["failures"] or total["vague"]
    total["exit_status"] = 1 if failed else 3 if incomplete else 0
    return total


def _campaign_sentence(total: dict[str, Any]) -> str:
    text = (
        f"{count(total['scenes'], 'random scene')}, {count(total['compared'], 'comparison')}, "
        f"{count(len(total['failures']), 'failure')}; "
        f"{share(total['certain'], total['judged'])} of the pixels certain"
    )
    text += f", expected {CAMPAIGN_FLOOR:.0%}" if total["vague"] else ""
    for name, why in total["missing"].items():
        text += f"; {name} is missing: {one_line(why, 160)}"
    first = [f["folder"] for f in total["failures"]][:1]
    return text + (f"; see fuzz/{first[0]}" if first else "")


def _json(document: Any) -> str:
    return json.dumps(document, indent=1, allow_nan=False) + "\n"
