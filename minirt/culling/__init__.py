"""Culling: which pairs of a ray and a primitive are worth testing; it never changes an answer.

This module is the door: the rest of the product imports from here alone. All that stands behind it
may be left out: `every_pair` gives the same answers as `culled_pairs`, only later.
"""

from minirt.culling.candidates import Batch, Candidates, culled_pairs, every_pair
from minirt.culling.image_cells import squares, visible_pixels
from minirt.culling.index import SceneIndex

__all__ = [
    "Batch",
    "Candidates",
    "SceneIndex",
    "culled_pairs",
    "every_pair",
    "squares",
    "visible_pixels",
]
