"""Run a fuzzing campaign, and write each failure into a folder of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from minirt.errors import InputError
from reference import registry
from reference.fuzz.campaign import Campaign, CampaignOptions, Failure, run_campaign
from reference.jobs.cluster import Cluster
from reference.registry import choose_references
from reference.source import Reference
from reports.fuzz.case import sentence, write_case
from reports.gate.subject import Subject
from reports.results.words import one_line
from reports.run import made_folder


@dataclass(frozen=True)
class FuzzOptions:
    """What is judged on random scenes.

    Attributes
    ----------
    references : sequence of str
        Names of renderers; none: the usual ones, unless an implementation is judged.
    subject : Subject
    seed, scenes : int
        Scenes 0…scenes−1 of the seed.
    seconds : float
        After which no scene is begun.
    out : Path
        The folder for failures.
    """

    references: Sequence[str]
    subject: Subject
    seed: int
    scenes: int
    seconds: float
    out: Path


def run_fuzz(
    options: FuzzOptions,
    cluster: Cluster | None = None,
    progress: Callable[[int, int], None] | None = None,
    remark: Callable[[str], None] = lambda _: None,
) -> tuple[Campaign, list[Path]]:
    """Judge on random scenes; the campaign, and the folders of its failures.

    `remark` is called with a line for each failure as soon as it is written.

    Raises
    ------
    InputError
        A name that is none, frames in place of a program, or a folder that cannot be written.
    """
    judged, cases = _judged(options), list[Path]()
    folder = made_folder(options.out)

    def write(failure: Failure) -> None:
        case = write_case(failure, folder, options.subject)
        cases.append(case)
        remark(f"✗ {one_line(sentence(failure))}; see {case}")

    campaign = CampaignOptions(
        options.scenes, options.seconds, min(2, len(judged)), options.subject.process_timeout
    )
    found = run_campaign(
        options.seed, judged, campaign, cluster=cluster, progress=progress, on_failure=write
    )
    return found, cases


def _judged(options: FuzzOptions) -> tuple[Reference, ...]:
    """References by name, and another implementation."""
    subject = options.subject
    if subject.frames:
        raise InputError(
            "random scenes cannot have been rendered earlier",
            where="--frames", expected="--cmd or --python",
        )  # fmt: skip
    if not subject.named:
        return choose_references(options.references or registry.USUAL)
    return (*choose_references(options.references), subject.reference())
