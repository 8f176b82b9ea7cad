"""The history itself: append a run, give back runs, and say what came before one.

A run is one transaction. A process that is killed loses the run that it was writing and no other;
of two that write at once, one waits for the other.
"""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any

from sqlalchemy import (
    Connection,
    Engine,
    Row,
    Select,
    Table,
    column,
    func,
    insert,
    inspect,
    select,
    table,
)
from sqlalchemy.exc import IntegrityError

from minirt.errors import InputError
from reports.history.entry import Entry, kept_name
from reports.history.place import (
    BEGIN,
    LOCK_TIMEOUT,
    Place,
    database_errors,
    engine_of,
    place_of,
    read_only,
)
from reports.history.previous import Point
from reports.history.rows import answer_row, cell_row, entry_from, run_row, scene_row
from reports.history.tables import VERSION, VERSION_TABLE, answers, cells, runs, scenes


class History:
    """A database of runs. Use as a context manager, or call `close`.

    Parameters
    ----------
    target : str
        A SQLite file or any SQLAlchemy URL.
    create : bool
        Begin a history where there is none; if not, one that may only be read suffices.

    Raises
    ------
    InputError
        It cannot be opened: not a database, a newer minirt's, no server, no driver, no history.
    """

    def __init__(self, target: str, *, create: bool = True) -> None:
        self._place: Place = place_of(target)
        self._engine: Engine = _opened(self._place, create)

    def __enter__(self) -> History:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the database."""
        self._engine.dispose()

    @property
    def shown(self) -> str:
        """Where it lies, for people; never with a password."""
        return self._place.shown

    def append(self, entry: Entry) -> int:
        """Add a run unless it is there already; give its number.

        Raises
        ------
        InputError
            The database refuses; nothing was added.
        """
        with database_errors(self._place, "the run cannot be recorded"):
            try:
                with self._writing() as connection:
                    return _same_run(connection, entry) or _insert(connection, entry)
            except IntegrityError:  # another process has just added the very same run
                with self._engine.connect() as connection:
                    number = _same_run(connection, entry)
                if number is None:
                    raise
                return number

    def number(self, word: str) -> int:
        """The number of a run: as a number, `latest`, or `previous`, the one before of its series.

        Raises
        ------
        InputError
            There is no such run.
        """
        with self._reading() as connection:
            return _run_number(connection, word, self.shown)

    def entry(self, number: int) -> Entry:
        """A run with every cell."""
        with self._reading() as connection:
            return entry_from(connection, number)

    def scenes_of(self, number: int) -> list[str]:
        """The names of a run's scenes, in their order."""
        with self._reading() as connection:
            found = select(scenes.c.name).where(scenes.c.run_id == number).order_by(scenes.c.id)
            return list(connection.execute(found).scalars())

    def latest(self, series: str | None = None, before: int | None = None) -> int | None:
        """The number of the newest run; of a series and before a run, where these are given."""
        with self._reading() as connection:
            asked = select(func.max(runs.c.id))
            asked = asked if series is None else asked.where(runs.c.series == series)
            asked = asked if before is None else asked.where(runs.c.id < before)
            found = connection.execute(asked).scalar()
            return None if found is None else int(found)

    def trends(
        self, names: Iterable[str], series: str | None = None, most: int | None = None
    ) -> dict[str, dict[str, tuple[Point, ...]]]:
        """Points of scenes, oldest first, by scene and by series.

        Parameters
        ----------
        names : iterable of str
            Of scenes; one without a run is left out.
        series : str, optional
            Only this one.
        most : int, optional
            The newest points of each scene, at most so many.
        """
        with self._reading() as connection:
            return {
                name: points
                for name in dict.fromkeys(map(kept_name, names))
                if (points := _points_by_series(connection, name, series, most))
            }

    @contextmanager
    def _writing(self) -> Iterator[Connection]:
        options = {BEGIN: "BEGIN IMMEDIATE"}
        connecting = self._engine.connect().execution_options(**options)
        with connecting as connection, connection.begin():
            yield connection

    @contextmanager
    def _reading(self) -> Iterator[Connection]:
        what = "the history cannot be read"
        with database_errors(self._place, what), self._engine.connect() as connection:
            yield connection


def _opened(place: Place, create: bool) -> Engine:
    """An engine for a history whose tables are this version's."""
    file = place.file
    if file is not None and not create and not file.exists():
        raise _no_history(place)
    if file is not None and not file.parent.is_dir():
        raise InputError(
            "not a place for a history", where=place.shown, got="no such folder",
            expected="a file in a folder that exists",
        )  # fmt: skip
    reading = None if create else read_only(place)
    engine = engine_of(reading or place)
    with database_errors(place, "the history cannot be opened", "a history of minirt"):
        found = _tables_version(engine)
        if not create and found is None:
            raise _no_history(place)
        if file is not None and reading is None:
            _write_ahead(engine)
        if found != VERSION:
            from reports.history.migrate import bring_up_to_date  # alembic: slow to import

            bring_up_to_date(engine, place)
    return engine


def _no_history(place: Place) -> InputError:
    return InputError(
        "no history here", where=place.shown,
        expected="--history with the file or URL that verify, gate or nightly wrote to",
    )  # fmt: skip


def _same_run(connection: Connection, entry: Entry) -> int | None:
    """The number of the very same run, where it is there already."""
    found = connection.execute(select(runs.c.id).where(runs.c.digest == entry.digest)).scalar()
    return None if found is None else int(found)


def _run_number(connection: Connection, word: str, shown: str) -> int:
    newest = connection.execute(select(func.max(runs.c.id))).scalar()
    if newest is None:
        raise InputError("holds no run yet", where=shown)
    if word in ("latest", str(newest)):
        return int(newest)
    if word == "previous":
        return _run_before(connection, int(newest), shown)
    known = select(runs.c.id).where(runs.c.id == int(word)) if _is_number(word) else None
    if known is not None and connection.execute(known).scalar() is not None:
        return int(word)
    raise InputError(
        "no such run", where=shown, got=repr(word)[:80],
        expected=f"a number up to {newest}, latest, previous, or a results.json",
    )  # fmt: skip


def _run_before(connection: Connection, newest: int, shown: str) -> int:
    series = select(runs.c.series).where(runs.c.id == newest).scalar_subquery()
    asked = select(func.max(runs.c.id)).where(runs.c.series == series, runs.c.id < newest)
    found = connection.execute(asked).scalar()
    if found is None:
        raise InputError(
            "no run before the latest compares the same", where=shown,
            expected="a number, or a results.json",
        )  # fmt: skip
    return int(found)


def _points_by_series(
    connection: Connection, name: str, series: str | None, most: int | None
) -> dict[str, tuple[Point, ...]]:
    """The points of one scene, oldest first."""
    found: dict[str, list[Point]] = {}
    for row in connection.execute(_points(name, series, most)):
        found.setdefault(row.series, []).append(_point(row))
    return {name: tuple(reversed(points)) for name, points in found.items()}


def _insert(connection: Connection, entry: Entry) -> int:
    number = _added(connection, runs, run_row(entry))
    for scene in entry.scenes:
        place = _added(connection, scenes, scene_row(scene, number))
        for answer in scene.answers:
            below = _added(connection, answers, answer_row(answer, place))
            if answer.checks:
                rows = [cell_row(check, below) for check in answer.checks]
                connection.execute(insert(cells), rows)
    return number


def _added(connection: Connection, table: Table, row: dict[str, Any]) -> int:
    key = connection.execute(insert(table), row).inserted_primary_key
    return int(key[0]) if key else 0


def _points(name: str, series: str | None, most: int | None) -> Select[Any]:
    """The newest points of a scene first."""
    asked = (
        select(
            runs.c.id, runs.c.series, runs.c.started, runs.c.commit, runs.c.dirty,
            scenes.c.state, scenes.c.ratio, scenes.c.sha256,
        )
        .join(runs, runs.c.id == scenes.c.run_id)
        .where(scenes.c.name == name)
        .order_by(scenes.c.id.desc())
    )  # fmt: skip
    asked = asked if series is None else asked.where(runs.c.series == series)
    return asked if most is None else asked.limit(most)


def _point(row: Row[Any]) -> Point:
    return Point(row.id, row.started, row.commit, row.state, row.ratio, row.sha256, row.dirty)


def _is_number(word: str) -> bool:
    return word.isascii() and word.isdigit() and len(word) < 10


def _tables_version(engine: Engine) -> str | None:
    """The version of a database's tables, empty while they are made; None where there are none."""
    with engine.connect() as connection:
        if not inspect(connection).has_table(VERSION_TABLE):
            return None
        found = connection.scalar(select(column("version_num")).select_from(table(VERSION_TABLE)))
    return str(found or "")


def _write_ahead(engine: Engine) -> None:
    """Let readers of a SQLite file read while somebody writes; the file remembers it."""
    end = time.monotonic() + LOCK_TIMEOUT
    connection = engine.raw_connection()
    try:
        while True:
            try:
                connection.cursor().execute("PRAGMA journal_mode = WAL")
                return
            except sqlite3.OperationalError as error:  # it does not wait by itself for this one
                if "locked" not in str(error) or time.monotonic() > end:
                    raise
                time.sleep(0.02)
    finally:
        connection.close()
