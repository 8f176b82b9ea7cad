"""What a reference renderer is: a name, how it errs, and the frame that it gives of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol, runtime_checkable

from minirt.errors import MinirtError
from minirt.frame import Frame
from minirt.scene import Scene


@dataclass(frozen=True)
class NormalOffset:
    """Secondary rays start off the surface, moved along the normal to the side to which they leave.

    The offset is ``factor · (1 + max|p'|) / scale`` scene units, p' = scale · (p − center) being
    the point in the renderer's own coordinates.
    """

    factor: float
    scale: float = 1.0
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class AlongRay:
    """Secondary rays start on the surface and ignore hits nearer than ``length`` scene units."""

    length: float


@dataclass(frozen=True)
class Declared:
    """How a renderer errs, from first principles; every tolerance is derived from it.

    Attributes
    ----------
    delta : float
        Bound, in scene units, on how far any point of a ray or of a surface that it computes
        lies from the exact one.
    vertex : float
        Bound, in scene units, on the error of a vertex or centre that is given to the renderer.
    angle : float
        Rounding of a unit vector, dimensionless.
    color : float
        Relative error of a colour channel; 0 for a renderer that gives no colour.
    start : NormalOffset or AlongRay or None
        How it starts secondary rays; None: as minirt does.
    derivation : str
        How delta and angle follow, for human readers.
    slope : float
        Growth of delta per distance from the observer, dimensionless: a renderer that rounds to
        parts of a pixel errs more at larger distances.
    grain : float
        Further relative error of a distance from the observer: the steps of a depth buffer.
    steps : tuple of (str, float)
        By quantity, the absolute error of the format of its answers, in the quantity's unit (of t:
        in scene units), Euclidean for vectors; 0 for a quantity that is not listed.
    watertight : bool
        Whether a ray through a shared edge always hits one of its two facets.
    near : float
        Distance from the observer, in scene units, below which it sees nothing.
    """

    delta: float
    vertex: float
    angle: float
    color: float
    start: NormalOffset | AlongRay | None
    derivation: str
    slope: float = 0.0
    grain: float = 0.0
    steps: tuple[tuple[str, float], ...] = ()
    watertight: bool = True
    near: float = 0.0


@dataclass(frozen=True)
class Rendering:
    """A reference's answer to one scene.

    Attributes
    ----------
    frame : Frame
        What it gives, in minirt's conventions (row 0 at the top, minirt's miss values).
    unsupported : dict of str to str
        Reason by quantity, for each quantity that it cannot give of this scene.
    program : str
        Name, version and variant of what really ran.
    """

    frame: Frame
    unsupported: Mapping[str, str] = field(default_factory=dict)
    program: str = ""


class Unsupported(Exception):
    """The renderer cannot represent this scene; the message says why."""


class NoAnswer(MinirtError):
    """There is no frame to compare; the message says why, and `state` how it ended."""

    state: Literal["failed", "crashed", "timed out"] = "failed"


class Crashed(NoAnswer):
    """The program that should have rendered the scene failed."""

    state = "crashed"
    exit_status = 3


class TimedOut(NoAnswer):
    """The program that should have rendered the scene took too long."""

    state = "timed out"
    exit_status = 3


@runtime_checkable
class Reproducible(Protocol):
    """A reference whose answer to a scene depends only on what it names here."""

    def ingredients(self) -> tuple[str | Path | None, ...]:
        """Names of distributions, and files, on which its answer depends, besides minirt's."""


class Reference(Protocol):
    """A renderer that minirt is compared with. Picklable; imports it only in `render`."""

    @property
    def name(self) -> str:
        """Its name, in reports and on the command line."""

    def missing(self) -> str | None:
        """Why it cannot run here, with the command that installs it; None if it can."""

    def declare(self, scene: Scene) -> Declared:
        """How it errs on this scene. Cheap: imports nothing."""

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Render the scene; runs in a child process, may write into the folder `scratch`.

        Raises
        ------
        Unsupported
        """
