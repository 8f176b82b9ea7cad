"""Numbers and records of the JSON documents: strict, with a spelling for what JSON lacks."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from minirt.errors import InputError


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


Document = TypeVar("Document", bound=BaseModel)


def read_document(path: Path, model: type[Document], what: str, source: str) -> Document:
    """A JSON file as a record.

    Parameters
    ----------
    path : Path
    model : type
    what : str
        The document's name with its article, for messages: a baseline.
    source : str
        What writes such a file.

    Raises
    ------
    InputError
        It cannot be read, or is something else.
    """
    try:
        return model.model_validate_json(path.read_bytes())
    except OSError as error:
        got = error.strerror or str(error)
        raise InputError(f"{what} cannot be read", where=str(path), got=got) from None
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        where = f"{path}: {place}".rstrip(": ")
        raise InputError(f"not {what}: {first['msg']}", where=where, expected=source) from None
