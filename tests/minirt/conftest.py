"""What several files of tests of the tracer are given."""

from __future__ import annotations

import pytest

from minirt.culling.rasteriser import Rasteriser
from minirt.vectors import Floats


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many rays each rasteriser that was made had."""
    rays: list[int] = []
    pairs = Rasteriser.pairs

    def counted(rasteriser: Rasteriser, t_max: Floats) -> object:
        rays.append(len(t_max))
        return pairs(rasteriser, t_max)

    monkeypatch.setattr(Rasteriser, "pairs", counted)
    return rays
