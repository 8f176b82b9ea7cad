"""The checks notice every mistake in the catalogue, where it is made, and no other."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from minirt.quantities import STAGES
from minirt.rules import SLIDES, Rules
from minirt.screen import VirtualScreen
from minirt.vectors import Floats
from reference.mutants import CATALOGUE, ORIGINAL, Mutant
from reference.mutants.floor import Floor, sensitivity_floor
from reference.mutants.matrix import Kill, kill_matrix, run_mutant
from reference.mutants.scenes import matrix_scenes

#: The least share of mutants that must be charged to the stage that they really break.
RIGHT_STAGE = 0.9
#: A scene of the matrix on which a mutant takes some hundredths of a second.
QUICK = 0


@pytest.fixture(scope="module")
def kills() -> dict[str, Kill]:
    return {row.mutant: row for row in kill_matrix()}


@pytest.fixture(scope="module")
def floor() -> Floor:
    return sensitivity_floor()


def test_the_catalogue_is_large_and_covers_every_rule() -> None:
    assert len(CATALOGUE) >= 40
    rules = Counter(mutant.rule for mutant in CATALOGUE.values())
    assert {f"S{k}": rules[f"S{k}"] >= 2 for k in range(1, 17)} == {
        f"S{k}": True for k in range(1, 17)
    }


@pytest.mark.parametrize("mutant", CATALOGUE.values(), ids=CATALOGUE)
def test_a_mutant_says_what_it_is_and_makes_one_mistake(mutant: Mutant) -> None:
    assert re.fullmatch(r"[a-z0-9]+([-.][a-z0-9]+)*", mutant.name)
    assert mutant.mistake.startswith(("with ", "without "))
    assert mutant.sentence.endswith(".")
    assert mutant.stage in STAGES
    changed_scene = mutant.scene is not ORIGINAL.scene
    assert bool(mutant.rules.changed()) + changed_scene + (mutant.change is not None) == 1


def test_every_mutant_is_killed(kills: dict[str, Kill]) -> None:
    wrong = [row for row in kills.values() if row.mutant != ORIGINAL.name]
    assert len(wrong) == len(CATALOGUE)
    assert [row.mutant for row in wrong if not row.killed] == []
    assert all(sum(row.charged.values()) for row in wrong)


def test_mutants_are_charged_to_the_stage_that_they_break(kills: dict[str, Kill]) -> None:
    wrong = [row for row in kills.values() if row.mutant != ORIGINAL.name]
    astray = {row.mutant: row.found for row in wrong if not row.right_stage}
    assert len(astray) <= (1 - RIGHT_STAGE) * len(wrong), astray


def test_the_lectures_own_rules_raise_no_alarm(kills: dict[str, Kill]) -> None:
    honest = kills[ORIGINAL.name]
    assert honest.scenes == len(matrix_scenes()) >= 10
    assert honest.failed == ()
    assert sum(honest.charged.values()) == 0


def test_a_mutant_that_makes_no_mistake_survives() -> None:
    def copied(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
        return SLIDES.pixel_center(screen, i, j)

    rules = SLIDES.replace(pixel_center=copied)
    planted = Mutant("planted", "S2", "with nothing", "It is right.", "ray", rules)
    row = run_mutant(planted)
    assert not row.killed
    assert row.found is None
    assert not row.right_stage


def test_a_mistake_that_is_declared_for_another_stage_shows() -> None:
    row = run_mutant(replace(CATALOGUE["rows-from-top"], stage="colour"))
    assert row.killed
    assert (row.found, row.right_stage) == ("ray", False)


@pytest.mark.parametrize("name", ["no-half-pixel", "last-row-dropped", "depth-in-float16"])
def test_some_pixels_are_traced_as_the_whole_picture(name: str) -> None:
    mutant, scene = CATALOGUE[name], matrix_scenes()[QUICK].scene
    whole = mutant.render(scene)
    pixels = np.array([0, 17, scene.screen.nx * scene.screen.ny - 1])
    some = mutant.trace(scene, pixels, ("object", "depth", "ray"))
    for quantity, values in some.items():
        expected = whole[quantity].reshape(-1, *whole[quantity].shape[2:])[pixels]
        np.testing.assert_array_equal(values.T, expected)


def test_the_quantities_can_be_chosen() -> None:
    frame = CATALOGUE["depth-given-as-distance"].render(
        matrix_scenes()[QUICK].scene, "hit,depth,ray"
    )
    assert set(frame) == {"hit", "depth", "ray"}


def test_the_sensitivity_floor(floor: Floor) -> None:
    """One pixel; and errors not far above float64's own rounding, 2⁻⁴⁴ of it being declared."""
    assert floor.pixels == 1
    values: list[float] = [floor.depth, floor.angle, floor.colour]
    assert all(2.0**-53 <= value <= 2.0**-40 for value in values)


def test_each_rule_that_can_be_replaced_is_replaced_by_some_mutant() -> None:
    changed = {name for mutant in CATALOGUE.values() for name in mutant.rules.changed()}
    assert changed == set(Rules.__dataclass_fields__)
