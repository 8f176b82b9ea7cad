"""A fuzzing campaign as an exit status, as a document and in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from reference.fuzz.campaign import CAMPAIGN_FLOOR, Campaign
from reports.results.words import count, one_line, share


def exit_status(found: Campaign) -> int:
    """The exit status of a campaign.

    0 nothing found; 1 a failure, or too few certain pixels; 3 a reference is missing, minirt
    itself did not answer, or nothing was compared.
    """
    if found.failures or found.vague:
        return 1
    return 3 if found.missing or found.unjudged or not found.compared else 0


def campaign_document(found: Campaign, cases: Sequence[Path]) -> dict[str, Any]:
    """A campaign as JSON data; `cases` are the folders of its failures."""
    return {
        "seed": found.seed,
        "scenes": found.scenes,
        "compared": found.compared,
        "unsupported": found.unsupported,
        "certain_share": found.certain_share,
        "certain_floor": CAMPAIGN_FLOOR,
        "missing": dict(found.missing),
        "unjudged": list(found.unjudged),
        "seconds": found.seconds,
        "failures": [
            {
                "scene": failure.number,
                "reference": failure.reference,
                "stage": failure.shrunk.trial.stage,
                "quantity": failure.shrunk.trial.quantity,
                "pixel": [failure.shrunk.trial.column, failure.shrunk.trial.row],
                "reason": failure.shrunk.trial.reason,
                "objects": len(failure.shrunk.scene.objects),
                "folder": str(case),
            }
            for failure, case in zip(found.failures, cases, strict=True)
        ],
        "exit_status": exit_status(found),
    }


def campaign_remarks(found: Campaign) -> Iterator[str]:
    """What kept scenes from being compared, a line each."""
    for name, reason in found.missing:
        yield f"! {name} is missing: {one_line(reason)}"
    for reason in found.unjudged:
        yield f"! {one_line(reason)}"


def campaign_summary(found: Campaign) -> str:
    """A campaign in one line."""
    text = (
        f"Seed {found.seed}: {count(found.scenes, 'scene')}, "
        f"{count(found.compared, 'comparison')}, {count(len(found.failures), 'failure')}, "
        f"{found.unsupported} not supported; "
        f"{share(found.certain, found.judged)} of the pixels certain"
    )
    if found.vague:
        text += f", expected {CAMPAIGN_FLOOR:.0%}: the declared errors are too large to judge by"
    return f"{text}; {found.seconds:.1f} s"
