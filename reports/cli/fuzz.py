"""`minirt fuzz`: random scenes against references; what fails is shrunk and written down."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.cli.options import ClusterOption, Json
from reports.cli.subject_options import takes_subject
from reports.gate.subject import Subject
from reports.inputs import names_in
from reports.terminal.console import print_json, progress, stderr_console, stdout_console

if TYPE_CHECKING:
    from reference.fuzz.campaign import Campaign, Failure
    from reference.source import Reference


@takes_subject
def fuzz(
    reference: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help="Renderers to judge, separated by commas, as for verify; all are required. Those "
            "that verify uses, unless an implementation is named.",
        ),
    ] = "",
    *,
    subject: Subject,
    seed: Annotated[
        int, typer.Option(min=0, max=2**32 - 1, help="Scene k of a seed is always the same.")
    ] = 0,
    scenes: Annotated[int, typer.Option(min=1, help="At most so many scenes.")] = 100,
    time: Annotated[
        float, typer.Option(min=1, metavar="SECONDS", help="After which no scene is begun.")
    ] = 600,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where failures are written.")
    ] = Path("fuzz"),
    cluster: ClusterOption = None,
    json: Json = False,
) -> None:
    """Judge renderers, or another implementation, on random scenes.

    A failure is shrunk to the smallest scene that fails in the same first stage, and written as a
    scene file, an explanation of its pixel, and a test in Python and in C++.
    """
    from reference.fuzz.campaign import CampaignOptions, run_campaign
    from reports.inputs import cluster_at
    from reports.run import made_folder

    judged = _judged(names_in(reference), subject)
    folder, cases = made_folder(out), list[Path]()
    options = CampaignOptions(scenes, time, min(2, len(judged)), subject.process_timeout)
    with cluster_at(cluster) as workers, progress("fuzz") as tell:
        found = run_campaign(
            seed, judged, options, cluster=workers, progress=tell,
            on_failure=lambda failure: cases.append(_written(failure, folder, subject)),
        )  # fmt: skip
    _tell(found)
    if json:
        print_json(campaign_document(found, cases))
    else:
        stdout_console().print(_summary(found), soft_wrap=True)
    raise typer.Exit(exit_status(found))


def exit_status(found: Campaign) -> int:
    """0 nothing found; 1 a failure, or too vague; 3 somebody is missing or nothing was compared."""
    if found.failures or found.vague:
        return 1
    return 3 if found.missing or found.unjudged or not found.compared else 0


def campaign_document(found: Campaign, cases: list[Path]) -> dict[str, Any]:
    """A campaign as JSON data."""
    return {
        "seed": found.seed,
        "scenes": found.scenes,
        "compared": found.compared,
        "unsupported": found.unsupported,
        "certain_share": found.certain_share,
        "certain_floor": _floor(),
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


def _judged(names: list[str], subject: Subject) -> tuple[Reference, ...]:
    """Whom to judge: references by name, and somebody else's implementation."""
    from minirt.errors import InputError
    from reference.registry import USUAL, choose_references

    if subject.frames:
        raise InputError(
            "random scenes cannot have been rendered earlier",
            where="--frames", expected="--cmd or --python",
        )  # fmt: skip
    if not subject.named:
        return choose_references(names or USUAL)
    return (*choose_references(names), subject.reference())


def _written(failure: Failure, folder: Path, subject: Subject) -> Path:
    """Write a failure into its folder, and say so in a line."""
    from reports.fuzz.case import sentence, write_case
    from reports.results.words import one_line

    case = write_case(failure, folder, subject)
    stderr_console().print(f"✗ {one_line(sentence(failure))}; see {case}", soft_wrap=True)
    return case


def _tell(found: Campaign) -> None:
    """What kept scenes from being compared."""
    from reports.results.words import one_line

    console = stderr_console()
    for name, reason in found.missing:
        console.print(f"! {name} is missing: {one_line(reason)}", soft_wrap=True)
    for reason in found.unjudged:
        console.print(f"! {one_line(reason)}", soft_wrap=True)


def _summary(found: Campaign) -> str:
    from reports.results.words import count, share

    text = (
        f"Seed {found.seed}: {count(found.scenes, 'scene')}, "
        f"{count(found.compared, 'comparison')}, {count(len(found.failures), 'failure')}, "
        f"{found.unsupported} not supported; "
        f"{share(found.certain, found.judged)} of the pixels certain"
    )
    if found.vague:
        text += f", expected {_floor():.0%}: the declared errors are too large to judge by"
    return f"{text}; {found.seconds:.1f} s"


def _floor() -> float:
    from reference.fuzz.campaign import CAMPAIGN_FLOOR

    return CAMPAIGN_FLOOR
