"""`rubric.toml`: what earns points in an assignment, and under which limits it is run."""

from __future__ import annotations

import hashlib
import tomllib
from pathlib import Path
from typing import Annotated, Any

from pydantic import AwareDatetime, Field, ValidationError, model_validator

from minirt.errors import InputError
from minirt.quantities import QUANTITIES, Stage
from reference.compare.precision import Precision
from reports.results.json_model import Model

#: Bytes beyond which a file is no rubric.
_LONGEST = 2**20

Share = Annotated[float, Field(ge=0, le=1)]


class LatePolicy(Model):
    """What lateness costs; when something was handed in is said beside the rubric."""

    deadline: AwareDatetime = Field(description="with its offset from UTC")
    per_day: Share = Field(description="share of the marks that each begun day costs")
    most_days: int = Field(default=365, ge=0, description="after more days it earns nothing")


class HiddenScenes(Model):
    """Variants of the public scenes that nobody has seen; only programs can render them."""

    seed: int = Field(description="kept secret: it makes the variants")
    variants: int = Field(default=1, ge=1, le=10, description="of each public scene")
    share: Share = Field(default=0.5, description="of each part's points that they decide")


class ProgramLimits(Model):
    """What a program may use."""

    seconds: float = Field(default=20.0, gt=0, le=3600, description="for each scene")
    build_seconds: float = Field(default=120.0, gt=0, le=3600)
    memory_mb: int = Field(default=2048, ge=64, le=2**20)


class Part(Model):
    """One row of the marks: a rule or several, a stage or several, or all of some scenes."""

    name: str = Field(min_length=1, max_length=80)
    points: float = Field(gt=0, le=10_000)
    rules: tuple[str, ...] = Field(default=(), description="S1 to S16, E1, E2")
    stages: tuple[Stage, ...] = ()
    scenes: tuple[str, ...] = Field(
        default=(), description="of the rubric's; without any those that list the rules, or all"
    )
    full: Share | None = Field(default=None, description="in place of the rubric's")
    zero: Share | None = Field(default=None, description="in place of the rubric's")

    @model_validator(mode="after")
    def _one_kind(self) -> Part:
        if self.rules and self.stages:
            raise ValueError("a part has rules or stages, not both")
        if round(self.points, 2) != self.points:
            raise ValueError(f"marks are in hundredths of a point, and {self.points:g} is not")
        return self


class Rubric(Model):
    """What earns points in an assignment."""

    title: str = Field(default="", max_length=200)
    scenes: tuple[str, ...] = Field(
        min_length=1, description="public ones: JSON files beside the rubric, or atlas:NAME"
    )
    quantities: tuple[str, ...] = Field(
        default=tuple(QUANTITIES), min_length=1, description="what is asked for"
    )
    full: Share = Field(default=1.0, description="share of right pixels that earns all points")
    zero: Share = Field(default=0.9, description="share of right pixels that earns none")
    precision: Precision = Field(default="float64", description="claimed unless a submission says")
    may_claim: tuple[Precision, ...] = Field(default=(), description="what else it may say")
    late: LatePolicy | None = None
    hidden: HiddenScenes | None = None
    limits: ProgramLimits = ProgramLimits()
    part: tuple[Part, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _consistent(self) -> Rubric:
        unknown = [name for name in self.quantities if name not in QUANTITIES]
        if unknown:
            raise ValueError(f"there is no quantity {unknown[0]!r}: {', '.join(QUANTITIES)}")
        names = [part.name for part in self.part]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise ValueError(f"two parts are called {twice!r}")
        for part in self.part:
            full, zero = self.ends(part)
            if zero >= full:
                raise ValueError(
                    f"part {part.name!r} earns nothing at {zero:g} and all at {full:g}: "
                    "zero must be below full"
                )
        return self

    def ends(self, part: Part) -> tuple[float, float]:
        """The shares of right pixels at which a part earns all and at which it earns nothing."""
        full = self.full if part.full is None else part.full
        return full, self.zero if part.zero is None else part.zero

    @property
    def points(self) -> float:
        """Of all parts together."""
        return sum(part.points for part in self.part)


def read_rubric(path: Path) -> tuple[Rubric, str]:
    """A rubric and the SHA-256 of its file.

    Raises
    ------
    InputError
        One error that names the file, the key, what is there and what should be.
    """
    text = _text(path)
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also of numbers and brackets without end
        raise InputError("not TOML", where=str(path), got=str(error)[:200]) from None
    try:
        rubric = Rubric.model_validate(document)
    except ValidationError as error:
        raise validation_error(error, str(path)) from None
    return rubric, hashlib.sha256(text.encode()).hexdigest()


def validation_error(error: ValidationError, where: str) -> InputError:
    """The first fault that a model found, as one sentence."""
    first = error.errors()[0]
    place = "".join(f"[{k}]" if isinstance(k, int) else f".{k}" for k in first["loc"])
    message = first["msg"].removeprefix("Value error, ")
    found: Any = first["input"]
    if first["type"] == "value_error":
        return InputError(message, where=f"{where}: {place[1:]}" if place else where)
    if first["type"] == "missing":
        return InputError("a key is missing", where=f"{where}: {place[1:]}")
    if first["type"] == "extra_forbidden":
        return InputError("there is no such key", where=f"{where}: {place[1:]}")
    plainly = {"too_short": "at least one", "timezone_aware": "an offset from UTC after the time"}
    return InputError(
        "not what the key takes", where=f"{where}: {place[1:]}", got=repr(found)[:80],
        expected=plainly.get(first["type"]) or message.removeprefix("Input should be "),
    )  # fmt: skip


def _text(path: Path) -> str:
    try:
        if path.is_file() and path.stat().st_size > _LONGEST:
            raise InputError("too long for a rubric", where=str(path), expected="at most 1 MiB")
        return path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError("cannot be read", where=str(path), got=reason) from None
