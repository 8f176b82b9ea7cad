"""The fuzzing of a nightly run: rounds of random scenes until the budget is used up."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from reference.fuzz.campaign import (
    CAMPAIGN_FLOOR,
    Campaign,
    CampaignOptions,
    Failure,
    run_campaign,
)
from reference.fuzz.trial import TrialWorkers
from reports.fuzz.campaign import campaign_document
from reports.fuzz.case import write_case
from reports.nightly.nightly_run import NightlyRun, StepResult, write_json
from reports.nightly.options import NightlyOptions, Progress
from reports.results.words import count, one_line, share

#: Seconds of one round, and its largest number of scenes.
ROUND, MOST_SCENES = 60.0, 500
#: Failures after which the fuzzing ends: further ones mostly have the same cause.
MOST_FAILURES = 10
#: Seconds for a random scene and a reference.
TRIAL_TIMEOUT = 60.0


def fuzz_step(night: NightlyRun, options: NightlyOptions, progress: Progress) -> StepResult:
    """Fuzz until the budget is used up; an interrupted run continues after its last round."""
    folder = night.folder / "fuzz"
    folder.mkdir(exist_ok=True)
    rounds = _rounds(folder / "fuzz.json")
    local = nullcontext() if options.cluster else TrialWorkers(_pairs(options), TRIAL_TIMEOUT)
    with local as workers:
        while (left := options.budget - sum(r["seconds"] for r in rounds)) > 0:
            seed = (night.record.seed + len(rounds)) % 2**32
            found, cases = _round(seed, options, min(left, ROUND), workers, folder)
            told = {"certain": found.certain, "judged": found.judged}
            rounds.append(campaign_document(found, cases) | told)
            write_json(folder / "fuzz.json", {"rounds": rounds, **_total(rounds)})
            progress("fuzz", options.budget - max(left - found.seconds, 0.0), options.budget)
            if not found.scenes or sum(len(r["failures"]) for r in rounds) >= MOST_FAILURES:
                break
    total = _total(rounds)
    return StepResult(
        exit_status=total["exit_status"],
        sentence=_campaign_sentence(total),
        seconds=total["seconds"],
    )


def _round(
    seed: int, options: NightlyOptions, seconds: float, workers: TrialWorkers | None, folder: Path
) -> tuple[Campaign, list[Path]]:
    """One round, and the folders of its failures, relative to `folder`."""
    cases: list[Path] = []

    def keep(failure: Failure) -> None:
        cases.append(write_case(failure, folder).relative_to(folder))

    campaign = CampaignOptions(MOST_SCENES, seconds, _pairs(options), TRIAL_TIMEOUT)
    found = run_campaign(
        seed,
        options.references,
        campaign,
        workers=workers,
        cluster=options.cluster,
        on_failure=keep,
    )
    return found, cases


def _pairs(options: NightlyOptions) -> int:
    """Processes of each kind for one random scene."""
    return min(2, len(options.references))


def _rounds(path: Path) -> list[dict[str, Any]]:
    """The rounds that were finished before an interruption."""
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
