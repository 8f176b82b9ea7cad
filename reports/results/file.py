"""A `results.json`, read again: one that is whole, of this format, and agrees with itself."""

from __future__ import annotations

import json
from pathlib import Path

from pydantic import ValidationError

from minirt.errors import InputError
from reports.results.consistency import require_borne_out
from reports.results.record import ResultsModel
from reports.results.words import one_line


def read_results(path: Path) -> ResultsModel:
    """The results in a file, or in the `results.json` of a folder.

    Raises
    ------
    InputError
        They cannot be read, are no results document, or say of a check, a scene or the run what
        lies below does not bear out.
    """
    file = path / "results.json" if path.is_dir() else path
    try:
        model = ResultsModel.model_validate(json.loads(file.read_text(encoding="utf-8")))
        require_borne_out(model)
    except InputError as error:
        where = f"{file}, {error.where}"
        raise InputError(error.what, where=where, got=error.got, expected=error.expected) from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError("cannot be read", where=str(file), got=reason) from None
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        got = one_line(f"{place}: {first['msg']}" if place else first["msg"])
        raise InputError(
            "not the results of a run", where=str(file), got=got,
            expected="a results.json of minirt verify or gate",
        ) from None  # fmt: skip
    except (ValueError, RecursionError) as error:
        raise InputError("not JSON", where=str(file), got=one_line(str(error))) from None
    return model
