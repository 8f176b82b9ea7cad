"""Where a history is stored: a SQLite file or any SQLAlchemy URL; and what goes wrong there.

No message shows a password, even where a driver's own does.
"""

from __future__ import annotations

import os
import re
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, NoSuchModuleError, SQLAlchemyError
from sqlalchemy.pool import NullPool

from minirt.errors import InputError
from reports.results.words import one_line

#: Seconds to wait for another writer, and for a server to answer.
LOCK_TIMEOUT, CONNECT_TIMEOUT = 60, 10
#: Drivers that minirt knows how to bring, by the name of the database.
_DRIVERS = {"postgresql": "postgresql+psycopg", "postgres": "postgresql+psycopg"}
#: The execution option that says how a SQLite transaction begins.
BEGIN = "minirt_begin"
_EXPECTED = "a file, or a URL as postgresql://user@host/database"


@dataclass(frozen=True)
class Place:
    """Where a history is stored.

    Attributes
    ----------
    url : URL
        For SQLAlchemy; it may hold a password.
    shown : str
        For people; it does not.
    file : Path or None
        Of a SQLite database.
    """

    url: URL
    shown: str
    file: Path | None


def place_of(target: str) -> Place:
    """The place that a file's name or a URL means.

    Raises
    ------
    InputError
        Not a URL, or a database in memory, which nobody would see again.
    """
    if "://" not in target:
        return _file(Path(target), target)
    try:
        url = make_url(target)
    except (ArgumentError, ValueError):
        scheme = re.match(r"[\w+]*", target)
        shown = f"{scheme[0] if scheme else ''}://…"
        raise InputError("not a URL of a database", where=shown, expected=_EXPECTED) from None
    if url.get_backend_name() == "sqlite":
        if not url.database or url.database.startswith((":memory:", "file:")):
            raise InputError(
                "not a file", where="sqlite://", got=url.database or "no name",
                expected="sqlite:///history.sqlite",
            )  # fmt: skip
        return _file(Path(url.database), url.database)
    url = url.set(drivername=_DRIVERS.get(url.drivername, url.drivername))
    if url.get_backend_name() == "postgresql":
        url = url.update_query_dict({"connect_timeout": str(CONNECT_TIMEOUT), **url.query})
    return Place(url, _shown(url), None)


def read_only(place: Place) -> Place | None:
    """The place as somebody opens it who may read a SQLite file and not write beside it; else None.

    SQLite keeps a file of its own beside one that is written ahead. Where there is none, and none
    can be made, nobody is writing.
    """
    if place.file is None or os.access(place.file.parent, os.W_OK):
        return None
    written = place.file.with_name(f"{place.file.name}-wal").exists()
    how = {"mode": "ro"} if written else {"immutable": "1"}
    database = place.file.absolute().as_uri().replace("file://", "file:", 1)
    url = URL.create("sqlite", database=database, query={**how, "uri": "true"})
    return replace(place, url=url)


def engine_of(place: Place) -> Engine:
    """An engine for a place, with its driver.

    Raises
    ------
    InputError
        There is no such database or driver.
    """
    try:
        engine = create_engine(place.url, poolclass=NullPool)
    except ModuleNotFoundError as error:
        raise InputError(
            "the database's driver is not installed", where=place.shown,
            got=f"no module {error.name}",
            expected="pip install 'minirt[postgresql]' for PostgreSQL",
        ) from None  # fmt: skip
    except (NoSuchModuleError, ArgumentError) as error:
        raise InputError(
            "no such kind of database", where=place.shown,
            got=driver_message(error, place), expected=_EXPECTED,
        ) from None  # fmt: skip
    if place.file is not None:
        event.listen(engine, "connect", _prepare)
        event.listen(engine, "begin", _begin)
    return engine


@contextmanager
def database_errors(place: Place, what: str, expected: str = "") -> Iterator[None]:
    """Turn every error of a database into one clear `InputError`."""
    try:
        yield
    except (SQLAlchemyError, sqlite3.Error, OverflowError) as error:
        got = driver_message(error, place)
        raise InputError(what, where=place.shown, got=got, expected=expected) from None


def driver_message(error: BaseException, place: Place) -> str:
    """A driver's message, on one line and without a secret."""
    orig = error.orig if isinstance(error, DBAPIError) and error.orig is not None else error
    text = str(orig)
    for secret in _secrets(place.url):
        text = text.replace(secret, "***")
    return one_line(text)


def _file(path: Path, name: str) -> Place:
    shown = repr(name)[:300] if "\0" in name or not name else str(path)
    if "\0" in name or not name or path.is_dir():
        got = "a folder" if name and path.is_dir() else "no name of a file"
        raise InputError("not a place for a history", where=shown, got=got, expected=_EXPECTED)
    return Place(URL.create("sqlite", database=str(path)), shown, path)


def _shown(url: URL) -> str:
    """A URL for people: neither the password nor the options, which may hold one."""
    bare = URL.create(
        url.drivername.partition("+")[0], url.username, None, url.host, url.port, url.database
    )
    return one_line(bare.render_as_string())


def _secrets(url: URL) -> list[str]:
    options = [
        v
        for values in url.query.values()
        for v in ([values] if isinstance(values, str) else values)
    ]
    secrets = [url.password or "", *options]
    return sorted(
        {s for s in map(str, secrets) if len(s) > 3 or s == url.password}, key=len, reverse=True
    )


def _prepare(connection: sqlite3.Connection, _: object) -> None:
    """Leave it to us when a transaction begins, and wait for other writers."""
    connection.isolation_level = None
    connection.execute(f"PRAGMA busy_timeout = {LOCK_TIMEOUT * 1000}")
    connection.execute("PRAGMA foreign_keys = ON")


def _begin(connection: Connection) -> None:
    connection.exec_driver_sql(connection.get_execution_options().get(BEGIN, "BEGIN"))
