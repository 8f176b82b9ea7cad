"""Draw one value of a Hypothesis strategy from a seed, the same in every process."""

from __future__ import annotations

from typing import Any, TypeVar

import hypothesis
from hypothesis import HealthCheck, Phase
from hypothesis.internal.conjecture.providers import AVAILABLE_PROVIDERS, HypothesisProvider
from hypothesis.strategies import SearchStrategy

T = TypeVar("T")


class SeedOnly(HypothesisProvider):
    """Draw from the seed alone.

    Hypothesis' own provider also uses constants from the modules that happen to be loaded, so
    that a seed would mean different scenes in different processes.
    """

    def _maybe_draw_constant(self, *_: Any, **__: Any) -> None:
        return None


AVAILABLE_PROVIDERS["minirt-seed-only"] = SeedOnly


def draw_one(strategy: SearchStrategy[T], seed: int) -> T:
    """Draw a value with a seed: not the first one, which is always the simplest.

    Parameters
    ----------
    strategy : SearchStrategy
    seed : int
        At least 0.
    """
    drawn: list[T] = []

    @hypothesis.seed(seed)
    @hypothesis.settings(
        max_examples=2,
        phases=[Phase.generate],
        database=None,
        deadline=None,
        backend="minirt-seed-only",
        suppress_health_check=list(HealthCheck),
    )
    @hypothesis.given(strategy)
    def collect(value: T) -> None:
        drawn.append(value)

    collect()
    return drawn[-1]
