"""Wrong versions of the lecture's rules, each a mistake that people make.

They show that the harness would notice, and they name what a failing renderer probably does.
"""

from __future__ import annotations

from minirt.rules import SLIDES
from reference.mutants import facets, hits, light, optics, output, screen
from reference.mutants.mutant import Mutant as Mutant

#: Every mutant by its name.
CATALOGUE: dict[str, Mutant] = {
    mutant.name: mutant
    for module in (screen, hits, facets, light, optics, output)
    for mutant in module.MUTANTS
}

#: No mistake at all: what must raise no alarm.
ORIGINAL = Mutant("none", "S4", "to the letter", "The lecture's rules as they are.", "hit", SLIDES)
