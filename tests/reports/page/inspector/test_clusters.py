"""Wrong pixels that touch, the worst of them, and how errors are histogram."""

from __future__ import annotations

import numpy as np

from minirt.quantities import STAGES
from reports.page.colors import BOUNDS
from reports.page.inspector.clusters import MOST_LISTED, clusters_of, histogram, worst_pixels

SHADOW, T = STAGES.index("shadow"), STAGES.index("t")


def planted() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Five wrong shadow pixels that touch by a corner, one alone, and two wrong depths."""
    first = np.full((20, 30), -1, dtype=np.int8)
    first[2:4, 3:5] = first[4, 5] = first[15, 20] = SHADOW
    first[2, 5] = first[3, 5] = T
    shadow = np.where(first == SHADOW, np.inf, 0.0)
    depth = np.where(first == T, 1.5, 0.5)
    depth[3, 5] = 7.0
    depth[10, 10] = np.nan
    return first, {"depth": depth, "shadow": shadow}


def test_clusters_touch_by_side_or_corner_and_share_their_stage() -> None:
    depth, large, alone = clusters_of(*planted())
    assert [(c.stage, c.size) for c in (depth, large, alone)] == [
        ("t", 2), ("shadow", 5), ("shadow", 1),
    ]  # fmt: skip
    assert (depth.column, depth.row) == (5, 3)
    assert (large.left, large.top, large.right, large.bottom) == (3, 2, 5, 4)
    assert (large.column, large.row) == (4, 3)
    assert (alone.column, alone.row) == (20, 15)


def test_nothing_wrong_is_no_cluster() -> None:
    first = np.full((4, 4), -1, dtype=np.int8)
    assert clusters_of(first, {"hit": np.zeros((4, 4))}) == ()
    assert worst_pixels(first, {"hit": np.zeros((4, 4))}) == ()


def test_worst_pixels_come_by_stage_then_by_ratio() -> None:
    found = worst_pixels(*planted())
    assert len(found) == 8
    assert [(p.column, p.row, p.quantity, p.ratio) for p in found[:2]] == [
        (5, 3, "depth", 7.0), (5, 2, "depth", 1.5),
    ]  # fmt: skip
    assert {p.stage for p in found[2:]} == {"shadow"}


def test_no_more_than_the_worst_are_listed() -> None:
    first = np.zeros((10, 10), dtype=np.int8)
    ratio = np.arange(100.0).reshape(10, 10) + 2
    found = worst_pixels(first, {"ray": ratio})
    assert len(found) == MOST_LISTED
    assert (found[0].column, found[0].row, found[0].ratio) == (9, 9, 101.0)


def test_the_spread_counts_every_pixel_once_and_knows_the_largest_error() -> None:
    ratio = np.array([[0.0, 0.1, 1.0, 1.1, np.inf, np.nan, np.nan]])
    error = np.array([[0.0, 1e-9, 1e-8, 1.1e-8, np.inf, 5.0, 7.0]])
    found = histogram(ratio, error)
    assert sum(found.counts) == 7
    assert found.counts[-1] == 2
    assert found.differences[-1] == 7.0
    one = BOUNDS.index(1.0)
    for band, count, difference in (
        (0, 1, 0.0), (1, 1, 1e-9), (2, 0, None), (one, 1, 1e-8), (one + 1, 1, 1.1e-8),
        (len(BOUNDS), 1, np.inf),
    ):  # fmt: skip
        assert (found.counts[band], found.differences[band]) == (count, difference)
