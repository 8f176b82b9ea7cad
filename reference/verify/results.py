"""The records of a comparison: of one reference while the arrays are at hand, and of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from minirt.frame import Frame
from minirt.scene import Scene
from reference.compare.check import Check
from reference.compare.comparison import Comparison
from reference.compare.quorum import Quorum
from reference.compare.stability import Stability
from reference.exact import Judgement
from reference.source import Declared


@dataclass(frozen=True, eq=False)
class Evidence:
    """All that is known about one scene against one reference, while the arrays are at hand.

    Attributes
    ----------
    scene : Scene
    reference : str
    ours, theirs : Frame
    stability : Stability
        Of `ours`, under the error that the reference declares.
    comparison : Comparison
    companions : mapping of str to Comparison
        The comparisons of all references on the scene, by name, this one included.
    """

    scene: Scene
    reference: str
    ours: Frame
    theirs: Frame
    stability: Stability
    comparison: Comparison
    companions: Mapping[str, Comparison] = field(default_factory=dict)


@dataclass(frozen=True)
class ReferenceResult:
    """One scene against one reference.

    Attributes
    ----------
    reference, program : str
        Its name, and what really ran.
    checks : tuple of Check
        One for each quantity.
    declared : Declared or None
        How it errs on this scene; None where it did not run.
    seconds : float
        Of its own rendering.
    output : str
        Its last output, where it crashed, timed out or failed.
    details : object
        What the caller's `MakeDetails` made of the evidence; None where there is none.
    diagnosis : tuple or None
        What the caller's `Diagnose` found in a failure, best first; None where nothing failed.
    kept : bool
        Whether its frame was kept from an earlier run.
    """

    reference: str
    program: str
    checks: tuple[Check, ...]
    declared: Declared | None = None
    seconds: float = 0.0
    output: str = ""
    details: Any = None
    diagnosis: tuple[Any, ...] | None = None
    kept: bool = False


@dataclass(frozen=True)
class SceneResult:
    """One scene against every reference.

    Attributes
    ----------
    scene : Scene
    references : tuple of ReferenceResult
    seconds : float
    peak_memory : int
        In bytes; both are minirt's own.
    quorum : tuple of Quorum
        Who confirms what, one for each quantity; empty where minirt itself failed.
    judgement : Judgement or None
        minirt against exact arithmetic; None where minirt itself failed.
    thumbnail : object
        What the caller's `MakeThumbnail` made of minirt's frame; None where there is none.
    """

    scene: Scene
    references: tuple[ReferenceResult, ...]
    seconds: float = 0.0
    peak_memory: int = 0
    quorum: tuple[Quorum, ...] = ()
    judgement: Judgement | None = None
    thumbnail: Any = None
