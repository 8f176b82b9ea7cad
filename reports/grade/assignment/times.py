"""When submissions were handed in: a table beside the rubric, never a file's own date.

Dates of files change with every copy, and students can set them.
"""

from __future__ import annotations

import csv
from datetime import datetime
from pathlib import Path

from minirt.errors import InputError

#: The columns of the table; others are left alone.
_COLUMNS = ("student", "submitted")


def read_times(path: Path) -> dict[str, datetime]:
    """When each student handed in, from a CSV with the columns `student` and `submitted`.

    Raises
    ------
    InputError
        One error that names the line.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            reader = csv.DictReader(stream)
            lacking = [c for c in _COLUMNS if c not in (reader.fieldnames or ())]
            if lacking:
                raise InputError(
                    "a column is missing", where=str(path), got=", ".join(reader.fieldnames or ()),
                    expected=" and ".join(_COLUMNS),
                )  # fmt: skip
            return _times(reader, path)
    except (OSError, ValueError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError("cannot be read", where=str(path), got=reason) from None


def _times(reader: csv.DictReader[str], path: Path) -> dict[str, datetime]:
    found: dict[str, datetime] = {}
    for row in reader:
        where = f"{path}: line {reader.line_num}"
        name, text = row["student"], row["submitted"] or ""
        try:
            time = datetime.fromisoformat(text)
        except ValueError:
            time = None
        if time is None or time.utcoffset() is None:
            raise InputError(
                "not a time with its offset from UTC", where=where, got=repr(text)[:80],
                expected="as 2027-01-31T23:59:00+02:00",
            )  # fmt: skip
        if name in found:
            raise InputError("a student stands twice", where=where, got=name[:80])
        found[name] = time
    return found
