"""One value of a Hypothesis strategy for one seed, the same in every process."""

from __future__ import annotations

from typing import Any, TypeVar

import hypothesis
from hypothesis import HealthCheck, Phase
from hypothesis.internal.conjecture.providers import AVAILABLE_PROVIDERS, HypothesisProvider
from hypothesis.strategies import SearchStrategy

T = TypeVar("T")


class SeedOnly(HypothesisProvider):
    """Draws that depend on the seed alone.

    Hypothesis' own provider mixes in constants that it finds in the modules that happen to be
    loaded, so that a seed means another scene in another process.
    """

    def _maybe_draw_constant(self, *_: Any, **__: Any) -> None:
        return None


AVAILABLE_PROVIDERS["minirt-seed-only"] = SeedOnly


def draw_one(strategy: SearchStrategy[T], seed: int) -> T:
    """What a strategy draws with a seed. Hypothesis draws its simplest value first: not that one.

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
