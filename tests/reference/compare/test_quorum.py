"""Who agrees with whom, counted by hand on six pixels."""

from __future__ import annotations

from typing import Any

import numpy as np

from reference.compare.comparison import Comparison
from reference.compare.quorum import quorum_of

NAN, INF = np.nan, np.inf


def comparison(*ratio: float) -> Comparison:
    return Comparison((), {"hit": np.array([ratio])})


def test_agreement_and_dissent_are_counted_pixel_by_pixel() -> None:
    comparisons = {
        "a": comparison(0.0, 0.5, 1.0, INF, NAN, INF),
        "b": comparison(0.2, INF, NAN, INF, NAN, NAN),
        "c": comparison(0.0, 0.0, 0.0, 2.0, NAN, 0.3),
    }
    (quorum,) = quorum_of(comparisons, ["hit"])
    assert quorum.sources == ("a", "b", "c")
    # Agreeing: 3, 2 (a, c), 2 (a, c), 0, 0, 1 (c).
    assert quorum.confirmed == (2, 1, 2, 1)
    assert quorum.dissent == {"a": 2, "b": 2, "c": 1}
    # b alone at the second pixel; a alone at the last; at the fourth nobody agrees.
    assert quorum.alone == {"a": 1, "b": 1}


def test_a_quantity_that_nobody_gives_has_no_source() -> None:
    (quorum,) = quorum_of({"a": comparison(0.0)}, ["depth"])
    assert quorum.sources == ()
    assert quorum.confirmed == ()
    assert not quorum.dissent


def test_maps_say_who_agrees_at_each_pixel() -> None:
    maps: list[Any] = []
    comparisons = {"a": comparison(0.0, 1.0, INF, NAN), "b": comparison(0.2, NAN, 0.0, NAN)}

    def draw(*found: Any) -> str:
        maps.append(found)
        return "drawn"

    (quorum,) = quorum_of(comparisons, ["hit"], draw)
    assert quorum.drawn == "drawn"
    ((agree, differ),) = maps
    assert agree.tolist() == [[2, 1, 1, 0]]
    assert differ.tolist() == [[False, False, True, False]]
