"""Run mutants, each in a child process or on a cluster, and say which were killed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from minirt.errors import InputError, ReferenceError
from reference.jobs.cluster import Cluster
from reference.jobs.isolate import Progress, Workers
from reference.mutants import CATALOGUE, ORIGINAL
from reference.mutants.matrix import Kill, kill


@dataclass(frozen=True)
class MutationRun:
    """The rows of the kill matrix.

    Attributes
    ----------
    original : Kill
        The lecture's own rules, on which no check may fail.
    mutants : tuple of Kill
    crashed : mapping of str to str
        Why, by the name of a mutant that crashed on a cluster.
    """

    original: Kill
    mutants: tuple[Kill, ...]
    crashed: Mapping[str, str] = field(default_factory=dict)

    @property
    def killed(self) -> int:
        """Mutants that a check noticed."""
        return sum(row.killed for row in self.mutants)

    @property
    def right_stage(self) -> int:
        """Mutants whose first wrong pixels are charged to the stage that they really break."""
        return sum(row.right_stage for row in self.mutants)

    @property
    def survivors(self) -> tuple[str, ...]:
        """Names of the mutants that no check noticed."""
        return tuple(row.mutant for row in self.mutants if not row.killed)

    @property
    def false_alarms(self) -> int:
        """Scenes on which a check fails though nothing is wrong."""
        return len(self.original.failed)


def chosen_mutants(names: Sequence[str]) -> tuple[str, ...]:
    """The mutants of these names; all where none is given.

    Raises
    ------
    InputError
        An unknown name.
    """
    unknown = [name for name in names if name not in CATALOGUE]
    if unknown:
        raise InputError(
            "no such mutant",
            got=", ".join(unknown)[:200],
            expected="a name that minirt mutants prints",
        )
    return tuple(names or CATALOGUE)


def run_mutants(
    names: Sequence[str],
    jobs: int,
    cluster: Cluster | None = None,
    progress: Progress | None = None,
) -> MutationRun:
    """Run the lecture's own rules and these mutants through the checks.

    Parameters
    ----------
    names : sequence of str
    jobs : int
        Processes on this machine.
    cluster : Cluster, optional
        Whose workers do it in place of this machine.
    progress : callable, optional
        Called in this process when one more row is known.

    Raises
    ------
    ReferenceError
        The lecture's own rules crashed on the cluster.
    """
    every = (ORIGINAL.name, *names)
    if cluster is not None:
        return _run_on(cluster, every, progress)
    rows: list[Kill] = []
    with Workers(min(jobs, len(every))) as workers:
        for job in [workers.submit(None, kill, name) for name in every]:
            outcome = job.outcome()
            if outcome.state != "done":
                raise RuntimeError(f"a mutant could not be run: {outcome.reason}")
            rows.append(outcome.value)
            if progress is not None:
                progress(len(rows), len(every))
    return MutationRun(rows[0], tuple(rows[1:]))


def _run_on(cluster: Cluster, names: Sequence[str], progress: Progress | None) -> MutationRun:
    ended = {}
    for number, outcome in cluster.outcomes((kill, (name,)) for name in names):
        ended[names[number]] = outcome
        if progress is not None:
            progress(len(ended), len(names))
    rows = [ended[name].value for name in names if ended[name].state == "done"]
    crashed = {name: ended[name].reason for name in names if ended[name].state != "done"}
    if names[0] in crashed:
        raise ReferenceError("the lecture's own rules could not be run", got=crashed[names[0]])
    return MutationRun(rows[0], tuple(rows[1:]), crashed)
