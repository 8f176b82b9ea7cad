"""Wrong versions of the lecture's rules, each a mistake that people really make.

They show that the checks would notice it, and they name what a failing renderer probably does.
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

#: The lecture's own rules, without a mistake: no check may fail on them.
ORIGINAL = Mutant("none", "S4", "to the letter", "The lecture's rules as they are.", "hit", SLIDES)
