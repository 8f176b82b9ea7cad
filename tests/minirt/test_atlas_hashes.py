"""Not one bit of any answer changes unless it is meant to."""

from __future__ import annotations

import pytest

import minirt
from minirt.scene_file.atlas import atlas_names
from tests.helpers.atlas_hashes import hashes_of, kept_hashes

KEPT = kept_hashes()


def test_the_kept_hashes_are_those_of_the_atlas() -> None:
    assert set(KEPT) == set(atlas_names())
    assert all(set(hashes) == set(minirt.QUANTITIES) for hashes in KEPT.values())


@pytest.mark.parametrize("name", KEPT)
def test_every_quantity_of_a_scene_has_its_bits(name: str) -> None:
    scene = minirt.load_scene(f"atlas:{name}")
    assert hashes_of(scene) == KEPT[name]
    for some in ("t", "hit,depth,color"):
        kept = {quantity: KEPT[name][quantity] for quantity in some.split(",")}
        assert hashes_of(scene, some) == kept, some
