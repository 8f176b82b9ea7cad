"""The renderers that minirt can be compared with, by name."""

from __future__ import annotations

from collections.abc import Iterable

from minirt.errors import InputError
from reference.renderers.embree.source import EmbreeReference
from reference.renderers.mitsuba.cli import MitsubaCommand
from reference.renderers.mitsuba.llvm import find_llvm
from reference.renderers.mitsuba.source import MitsubaReference
from reference.renderers.povray.source import PovrayReference
from reference.renderers.pyrender.source import PyrenderReference
from reference.source import Reference

#: Every reference, by its name. A renderer is imported only when it renders.
REFERENCES: dict[str, Reference] = {
    reference.name: reference
    for reference in (
        MitsubaReference("mitsuba-llvm"),
        MitsubaReference("mitsuba-scalar"),
        MitsubaCommand(),
        PyrenderReference(),
        EmbreeReference(),
        PovrayReference(),
    )
}

#: The name for the Mitsuba variant that suits this machine.
MITSUBA = "mitsuba"
#: The references by default: all of them, and Mitsuba both in Python and by its command.
USUAL = (MITSUBA, "mitsuba-cli", "pyrender", "embree", "povray")


def choose_references(names: Iterable[str]) -> tuple[Reference, ...]:
    """References by their names, each once, in the given order.

    ``mitsuba`` is ``mitsuba-llvm`` where a libLLVM that works is found, otherwise
    ``mitsuba-scalar``.

    Raises
    ------
    InputError
        An unknown name.

    Examples
    --------
    >>> [reference.name for reference in choose_references(["mitsuba-cli", "mitsuba-cli"])]
    ['mitsuba-cli']
    """
    chosen = {}
    for name in names:
        known = mitsuba_here() if name == MITSUBA else name
        if known not in REFERENCES:
            raise InputError(
                "unknown reference",
                got=repr(name)[:80],
                expected=", ".join((*REFERENCES, f"or {MITSUBA}")),
            )
        chosen[known] = REFERENCES[known]
    return tuple(chosen.values())


def mitsuba_here() -> str:
    """The Mitsuba variant that suits this machine: the fast one needs a libLLVM."""
    return "mitsuba-scalar" if find_llvm() is None else "mitsuba-llvm"
