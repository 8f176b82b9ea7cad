"""Numbers and records of the JSON documents: strict, with a spelling for what JSON lacks."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field


def spelled(value: object) -> object:
    """A float that JSON does not have, as a string."""
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
    return value


Number = Annotated[float | Literal["inf", "-inf", "nan"], BeforeValidator(spelled)]
Natural = Annotated[int, Field(ge=0)]


class Model(BaseModel):
    """A record of a document: what is not in it is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True)
