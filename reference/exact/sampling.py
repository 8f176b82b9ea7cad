"""Choose the pixels of a scene that the judge examines."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from minirt.scene import Scene
from reference.compare.comparison import Comparison

#: Pixels of the seeded sample, and the largest number that are added because references dissent.
SAMPLE, MOST_DISSENTING = 500, 500


def pixels_to_judge(
    scene: Scene, comparisons: Mapping[str, Comparison], seed: int = 0
) -> list[tuple[int, int]]:
    """Pixels (row from the TOP, column), in the order of the image, each once.

    Certain pixels at which a reference dissents; the worst pixel of each quantity and reference;
    and a random sample of `SAMPLE` pixels, or all if there are fewer.

    Parameters
    ----------
    scene : Scene
    comparisons : dict of str to Comparison
        By reference.
    seed : int
        Of the sample. Each scene draws its own.
    """
    rng = np.random.default_rng([seed, int(scene.sha256[:8], 16)])
    total = scene.screen.nx * scene.screen.ny
    chosen = set(rng.choice(total, min(SAMPLE, total), replace=False).tolist())
    ratios = [ratio.reshape(-1) for c in comparisons.values() for ratio in c.ratio.values()]
    dissent = np.zeros(total, dtype=np.bool_)
    for ratio in ratios:
        dissent |= ratio > 1
        judged = np.where(np.isnan(ratio), -1.0, ratio)
        chosen.add(int(judged.argmax()))
    dissenting = rng.permutation(np.flatnonzero(dissent))[:MOST_DISSENTING]
    chosen.update(dissenting.tolist())
    return [divmod(index, scene.screen.nx) for index in sorted(chosen)]
