"""Name the mistake that explains a failure: which mutant agrees with it better than minirt does.

Only some of the pixels are looked at: a seeded sample of those that are wrong and of those that
are right. A pixel agrees with a mutant where every quantity, up to the stage in question, equals
the mutant's within the subject's own tolerance. Stages are taken in causal order: the first one
of whose wrong pixels some mutant explains most is what the diagnosis is about, so that of two
mistakes the earlier one is named, and what nobody explains (a border that is missing) hides
nothing that comes after it.
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
from reference.diagnose.symptoms import Symptom, float32_arithmetic, missing_or_at_once
from reference.mutants import CATALOGUE, Mutant
from reference.verify.results import Evidence

#: Pixels that the final candidates are judged by, and that all candidates are: half of them wrong.
SAMPLE, GLANCE = 3_000, 120
#: Candidates that a glance leaves.
_FINALISTS = 5
#: The share of a stage's wrong pixels that a mutant must explain, and the share of those that are
#: right up to that stage that it must leave right: a mistake that is really the subject's explains
#: nearly all of them, but for those that another fault or noise has changed as well. One that
#: explains less than half leaves more open than it answers.
EXPLAINED, KEPT = 0.5, 0.9
#: Fewest pixels a mutant has to explain, so that no name rests on one of them by chance.
_FEWEST = 2
_SEED = 20_240_229
#: Surfaces of a scene beyond which a wrong rule that decides what rays meet is no suspect: every
#: ray would be tried on every surface, for minutes.
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
    """Some pixels of an image, and how many of the image each stands for."""

    pixels: Index
    weight: Floats


def diagnose(evidence: Evidence, most: int = 3) -> tuple[Diagnosis | Symptom, ...]:
    """What explains a failure best: plain symptoms, then mutants; none where none fits.

    Parameters
    ----------
    evidence : Evidence
        Of one scene against one subject.
    most : int
        How many to name.

    Returns
    -------
    tuple of Diagnosis or Symptom
        Best first; empty where nothing is wrong, or nothing known explains it.
    """
    if not (evidence.comparison.first_stage >= 0).any():
        return ()
    found: list[Diagnosis | Symptom] = list(missing_or_at_once(evidence))
    found += _explaining(evidence, most)
    return tuple(found[:most] or float32_arithmetic(evidence))


def _explaining(evidence: Evidence, most: int) -> tuple[Diagnosis, ...]:
    """The mutants that explain the first stage that any of them explains."""
    first = evidence.comparison.first_stage
    glance = _sampled(first, GLANCE)
    suspects = [mutant for mutant in CATALOGUE.values() if _affordable(evidence.scene, mutant)]
    for stage in np.unique(first[first >= 0]):
        able = [mutant for mutant in suspects if STAGES.index(mutant.stage) <= stage]
        ranked = _ranked(evidence, able, int(stage), glance, 2 * EXPLAINED / 3)
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
    """Half of the sample from the pixels that are right, the rest evenly from each wrong stage."""
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
    """Those that explain at least a share of the stage's wrong pixels, best first.

    Among mutants that explain a stage alike, agreement in `every` other quantity decides too.
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
    """Whether a quantity is a mutant's, within the subject's tolerance."""
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
