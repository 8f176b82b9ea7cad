"""What a nightly run does, and what it leaves behind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from minirt.scene import Scene
from reference.jobs.cluster import Cluster
from reference.source import Reference
from reports.nightly.nightly_run import NightlySettings
from reports.results.provenance import provenance

#: Called with the name of a step, and how far it is: done and total.
Progress = Callable[[str, float, float], None]


@dataclass(frozen=True)
class NightlyOptions:
    """What a nightly run does.

    Attributes
    ----------
    scenes, references
        As for `run_verify`.
    required : tuple of str
        Names of references that must answer.
    budget : float
        Seconds of fuzzing.
    mutants : tuple of str
        Names; empty for all.
    jobs : int
        Processes of each kind.
    timeout : float
        Seconds for a reference and a scene of `scenes`.
    out : Path
        The folder of all nightly runs.
    history : str
        A file or the URL of a database; empty: a file in `out`.
    keep : int
        Nightly runs whose folders are kept.
    notify : tuple of str
        The words of a command that gets the summary; empty: none.
    cluster : Cluster or None
        Its workers do everything; None: this machine.
    """

    scenes: Sequence[Scene]
    references: Sequence[Reference]
    required: tuple[str, ...]
    budget: float
    mutants: tuple[str, ...]
    jobs: int
    timeout: float
    out: Path
    history: str = ""
    keep: int = 30
    notify: tuple[str, ...] = ()
    cluster: Cluster | None = None

    @property
    def settings(self) -> NightlySettings:
        """What an interrupted run must have in common with one that continues it."""
        return NightlySettings(
            commit=provenance().commit,
            scenes=[scene.sha256 for scene in self.scenes],
            references=[reference.name for reference in self.references],
            required=list(self.required),
            budget=self.budget,
            mutants=list(self.mutants),
        )
