"""Have the frames of a pack confirmed by references and by exact arithmetic."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from minirt.errors import ReferenceError
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference import registry
from reference.registry import choose_references
from reference.source import Reference
from reference.verify.options import Options
from reference.verify.results import SceneResult
from reference.verify.run import verify
from reports.results.cells import scene_state
from reports.results.findings import findings_of
from reports.results.verdict import decide


@dataclass(frozen=True)
class PackOptions:
    """Who confirms the frames of a pack.

    Attributes
    ----------
    references : sequence of Reference
        Who is asked to confirm; exact arithmetic is always asked.
    required : collection of str
        Names of references without whose answer there is no pack.
    jobs : int
        Child processes.
    """

    references: Sequence[Reference] = ()
    required: Collection[str] = ()
    jobs: int = 2

    @classmethod
    def of(cls, references: Sequence[str], required: Sequence[str], jobs: int) -> PackOptions:
        """Options by name; the required references are asked, too.

        Parameters
        ----------
        references : sequence of str
            Names; none: the usual ones; only `none`: no reference.
        required : sequence of str
        jobs : int

        Raises
        ------
        InputError
            An unknown name.
        """
        must = tuple(each.name for each in choose_references(required))
        chosen = [] if list(references) == ["none"] else references or registry.USUAL
        return cls(choose_references([*chosen, *must]), must, jobs)


@dataclass(frozen=True)
class Confirmed:
    """Who confirms the frames of scenes.

    Attributes
    ----------
    by : dict of str to dict of str to list of str
        By scene and quantity: who confirms it.
    programs : dict of str to str
        What really ran, by reference.
    """

    by: dict[str, dict[str, list[str]]]
    programs: dict[str, str]


def confirm(
    scenes: Sequence[Scene],
    options: PackOptions,
    progress: Callable[[int], None],
) -> Confirmed:
    """Compare scenes with references and with exact arithmetic.

    Raises
    ------
    ReferenceError
        Anything contradicts a frame, or a required reference did not answer.
    """
    references, required = options.references, options.required
    results = []
    for result in verify(scenes, references, Options(jobs=options.jobs)):
        results.append(result)
        progress(len(results))
    names = [reference.name for reference in references]
    verdict = decide(findings_of(results, names), names, required)
    refused = [r.scene.name for r in results if scene_state(r) == "failed" or r.judgement is None]
    if refused or any(name in trouble for trouble in verdict.troubles for name in required):
        raise ReferenceError(
            "not confirmed, so nothing was packed", where=", ".join(refused)[:200],
            got=verdict.sentence,
        )  # fmt: skip
    programs = {
        answer.reference: answer.program
        for result in results
        for answer in result.references
        if answer.declared is not None
    }
    return Confirmed({result.scene.name: _confirmed_by(result) for result in results}, programs)


def _confirmed_by(result: SceneResult) -> dict[str, list[str]]:
    by: dict[str, list[str]] = {name: [] for name in QUANTITIES}
    for answer in result.references:
        for check in answer.checks:
            if check.state == "passed":
                by[check.quantity].append(answer.reference)
    for count in result.judgement.counts if result.judgement else ():
        if count.decided and count.agreed == count.decided:
            by[count.quantity].append("judge")
    return by
