"""Find the mutant that agrees with a failing frame better than minirt does.

A seeded sample of wrong and of right pixels is examined. A pixel agrees with a mutant if every
quantity, up to the stage in question, equals the mutant's within the subject's own tolerance.
Stages are taken in causal order, and the diagnosis is about the first one of which a mutant
explains most wrong pixels. So the earlier one of two mistakes is named, and a stage that no mutant
explains (a missing border, say) does not hide the later ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from minirt.frame import Array
from minirt.quantities import QUANTITIES, STAGES
from minirt.scene import Facets, Scene
from minirt.trace import ASKED_OF_EVERY_PAIR
from minirt.vectors import Bools, Floats, Index
from reference.diagnose.symptoms import Symptom, float32_arithmetic, missing_or_self_hits
from reference.mutants import CATALOGUE, Mutant
from reference.verify.results import Evidence

#: Sizes of the samples for the final candidates and for the first selection; half of it is wrong.
SAMPLE, FIRST_SAMPLE = 3_000, 120
#: Candidates that are left after the first selection.
_FINALISTS = 5
#: The share of a stage's wrong pixels that a mutant must explain, and the share of the pixels right
#: up to that stage that it must leave right. The subject's real mistake explains nearly all of
#: them, except where another fault or noise has changed them too; half is the least that is useful.
EXPLAINED, KEPT = 0.5, 0.9
#: Fewest pixels that a mutant has to explain: one may agree by chance.
_FEWEST = 2
_SEED = 20_240_229
#: Largest number of surfaces of a scene on which a wrong rule that decides hits is a candidate:
#: every ray is tested against every surface then, which would take minutes.
_MOST_SURFACES = 100


@dataclass(frozen=True)
class Diagnosis:
    """A mutant that explains a failure.

    Attributes
    ----------
    name, rule, mistake : str
        The mutant's.
    stage : str
        The stage whose wrong pixels it explains.
    agrees : float
        Share of the judged pixels that agree with it, up to that stage; estimated.
    explains : float
        Share of the pixels wrong at that stage that it explains.
    """

    name: str
    rule: str
    mistake: str
    stage: str
    agrees: float
    explains: float

    @property
    def sentence(self) -> str:
        """As 'agrees with rule S2 without the half pixel at 99.9 % of pixels'."""
        share = f"{np.floor(self.agrees * 1000) / 10:.1f}"
        return f"agrees with rule {self.rule} {self.mistake} at {share} % of pixels"


@dataclass(frozen=True, eq=False)
class _Sample:
    """Some pixels of an image, and the number of pixels that each represents."""

    pixels: Index
    weight: Floats


def diagnose(evidence: Evidence, most: int = 3) -> tuple[Diagnosis | Symptom, ...]:
    """What explains a failure best: plain symptoms first, then mutants; empty if nothing fits.

    Parameters
    ----------
    evidence : Evidence
        Of one scene against one subject.
    most : int
        Largest number of explanations.

    Returns
    -------
    tuple of Diagnosis or Symptom
        Best first; empty if nothing is wrong, or if nothing known explains it.
    """
    if not (evidence.comparison.first_stage >= 0).any():
        return ()
    found: list[Diagnosis | Symptom] = list(missing_or_self_hits(evidence))
    found += _explaining(evidence, most)
    return tuple(found[:most] or float32_arithmetic(evidence))


def _explaining(evidence: Evidence, most: int) -> tuple[Diagnosis, ...]:
    """The mutants that explain the first stage that any of them explains."""
    first = evidence.comparison.first_stage
    first_sample = _sampled(first, FIRST_SAMPLE)
    candidates = [mutant for mutant in CATALOGUE.values() if _affordable(evidence.scene, mutant)]
    for stage in np.unique(first[first >= 0]):
        able = [mutant for mutant in candidates if STAGES.index(mutant.stage) <= stage]
        ranked = _ranked(evidence, able, int(stage), first_sample, 2 * EXPLAINED / 3)
        finalists = [mutant for mutant, _ in ranked[:_FINALISTS]]
        named = _ranked(
            evidence, finalists, int(stage), _sampled(first, SAMPLE), EXPLAINED,
            tuple(evidence.comparison.ratio),
        )  # fmt: skip
        if named:
            return tuple(diagnosis for _, diagnosis in named[:most])
    return ()


def _affordable(scene: Scene, mutant: Mutant) -> bool:
    """Whether a mutant's rays can be traced in the time that a diagnosis may take."""
    surfaces = sum(len(t.faces) if isinstance(t, Facets) else 1 for t in scene.objects)
    return surfaces <= _MOST_SURFACES or ASKED_OF_EVERY_PAIR.isdisjoint(mutant.rules.changed())


def _sampled(first: Array, size: int) -> _Sample:
    """Draw half of the sample from the right pixels, the rest evenly from each wrong stage."""
    random = np.random.default_rng(_SEED)
    flat = first.reshape(-1)
    stages = np.unique(flat[flat >= 0])
    quota = dict.fromkeys(stages, max(1, size // 2 // len(stages))) | {-1: size // 2}
    chosen, weight = [], []
    for stage, wanted in quota.items():
        there = np.flatnonzero(flat == stage)
        if len(there) > wanted:
            some = np.sort(random.choice(there, wanted, replace=False))
        else:
            some = there
        chosen.append(some)
        weight.append(np.full(len(some), len(there) / max(1, len(some))))
    return _Sample(np.concatenate(chosen), np.concatenate(weight))


def _ranked(
    evidence: Evidence, mutants: Iterable[Mutant], stage: int, sample: _Sample, least: float,
    every: tuple[str, ...] = (),
) -> list[tuple[Mutant, Diagnosis]]:  # fmt: skip
    """The mutants that explain at least a share of the stage's wrong pixels, best first.

    Among mutants that explain a stage equally, agreement in `every` quantity counts too.
    """
    found = []
    first = evidence.comparison.first_stage.reshape(-1)[sample.pixels]
    here, before = first == stage, (first < 0) | (first > stage)
    if not here.any():
        return []
    names = _judged(evidence, stage)
    for mutant in mutants:
        tile = mutant.trace(evidence.scene, sample.pixels, dict.fromkeys(("ray", *every, *names)))
        agrees = _agreement(evidence, tile, sample.pixels, names)
        explains = _share(agrees, sample.weight, here)
        kept = _share(agrees, sample.weight, before) if before.any() else 1.0
        enough = (agrees & here).sum() >= min(_FEWEST, here.sum())
        if explains >= least and kept >= KEPT and enough:
            agreeing, later = (
                float((sample.weight * which).sum() / sample.weight.sum())
                for which in (agrees, _agreement(evidence, tile, sample.pixels, every))
            )
            diagnosis = Diagnosis(
                mutant.name, mutant.rule, mutant.mistake, STAGES[stage], agreeing, explains
            )
            found.append((explains + kept + later, mutant, diagnosis))
    found.sort(key=lambda entry: entry[0], reverse=True)
    return [(mutant, diagnosis) for _, mutant, diagnosis in found]


def _judged(evidence: Evidence, stage: int) -> tuple[str, ...]:
    """The quantities that were compared, up to a stage."""
    return tuple(
        name for name in evidence.comparison.ratio if STAGES.index(QUANTITIES[name].stage) <= stage
    )


def _agreement(
    evidence: Evidence, tile: Mapping[str, Array], pixels: Index, names: tuple[str, ...]
) -> Bools:
    """Whether each pixel (n,) agrees with a mutant in every quantity that is judged there."""
    agrees = np.ones(len(pixels), dtype=np.bool_)
    for name in names:
        certain = evidence.stability.certain[name].reshape(-1)[pixels]
        agrees &= ~certain | _within(evidence, name, tile[name], pixels)
    return agrees


def _within(evidence: Evidence, name: str, mutant: Array, pixels: Index) -> Bools:
    """Whether a quantity equals a mutant's, within the subject's tolerance."""
    theirs = evidence.theirs[name].reshape(-1, QUANTITIES[name].components)[pixels].T
    mine = mutant.reshape(QUANTITIES[name].components, -1)
    same = ((theirs == mine) | (np.isnan(theirs) & np.isnan(mine))).all(axis=0)
    if QUANTITIES[name].discrete:
        return np.asarray(same)
    tolerance = evidence.stability.tolerance[name].reshape(-1)[pixels]
    with np.errstate(invalid="ignore", over="ignore"):
        error = np.sqrt(((theirs - mine) ** 2).sum(axis=0))
    return np.asarray(same | (error <= tolerance))


def _share(what: Bools, weight: Floats, among: Bools) -> float:
    return float((weight * (what & among)).sum() / (weight * among).sum())
