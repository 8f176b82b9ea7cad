"""The document `speed.json`: what `make bench` measured, on which machine, and when.

All seconds are medians of one process. A rate counts the rays that are sent, those of the pixels in
an image: what mirrors and shadows cost is part of a pixel.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib.resources import files
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from reports.results.json_model import Model, Natural

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
#: Ever more spheres; one mesh in ever more triangles; another mesh; rays without order; an image.
Kind = Literal["spheres", "triangles", "mesh", "incoherent", "image"]


class Case(Model):
    """One scene and what each tracer made of it."""

    name: str
    kind: Kind
    primitives: Natural
    rates: dict[str, Positive] = Field(
        description="rays a second by tracer, of an image its pixels; who cannot do it is not there"
    )


class Growth(Model):
    """minirt's own time, over one thing that grows."""

    over: str
    sizes: list[Natural]
    seconds: list[Positive]
    exponent: float = Field(description="k of seconds ∝ sizeᵏ, by least squares of the logarithms")


class Speed(Model):
    """What one run of make bench measured."""

    minirtSpeed: Literal[1] = Field(description="version of this format")  # noqa: N815
    started: str = Field(description="UTC, ISO 8601")
    commit: str | None
    cpu: str
    cores: Natural
    system: str
    versions: dict[str, str]
    tracers: list[str] = Field(description="in the order of a table's columns")
    cases: list[Case]
    growth: list[Growth]
    memory: Natural | None = Field(
        description="bytes that a process had at most which rendered the largest mesh"
    )


def fitted(over: str, sizes: Sequence[int], seconds: Sequence[float]) -> Growth:
    """How time grows over sizes, two at least.

    Examples
    --------
    >>> fitted("rays", [100, 10_000], [0.5, 5]).exponent
    0.5
    """
    slope = np.polyfit(np.log(sizes), np.log(seconds), 1)[0]
    return Growth(
        over=over, sizes=list(sizes), seconds=list(seconds), exponent=round(float(slope), 3)
    )


def measured() -> Speed:
    """What ships with this version."""
    return Speed.model_validate_json((files(__package__) / "speed.json").read_bytes())


def speed_json(speed: Speed) -> str:
    """The document of a run."""
    return json.dumps(speed.model_dump(mode="json"), indent=1, ensure_ascii=False) + "\n"


def speed_schema() -> dict[str, Any]:
    """The JSON Schema of the document."""
    return Speed.model_json_schema()
