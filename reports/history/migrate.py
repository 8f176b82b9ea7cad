"""Bring a database to the tables of this version, one process at a time."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from alembic.util import CommandError
from sqlalchemy import Connection, Engine, inspect, text

from minirt.errors import InputError
from reports.history.place import BEGIN, Place
from reports.history.tables import VERSION_TABLE

#: The advisory lock of PostgreSQL under which tables are changed: "minirt", as a number.
_LOCK = int.from_bytes(b"minirt", "big")


def bring_up_to_date(engine: Engine, place: Place, steps: Path | None = None) -> None:
    """Make or change the tables where they are not this version's.

    Parameters
    ----------
    engine, place
    steps : Path, optional
        The folder of the steps; the package's own without it.

    Raises
    ------
    InputError
        The tables are a newer version's, or the file is another program's database.
    """
    config = _config(steps)
    script = ScriptDirectory.from_config(config)
    with engine.connect() as connection:
        if _version(connection, script, place) == script.get_current_head():
            return
    with engine.connect().execution_options(**{BEGIN: "BEGIN EXCLUSIVE"}) as alone, alone.begin():
        if alone.dialect.name == "postgresql":
            alone.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": _LOCK})
        _version(alone, script, place)
        config.attributes["connection"] = alone
        command.upgrade(config, "head")


def _version(connection: Connection, script: ScriptDirectory, place: Place) -> str | None:
    """The version of the tables; None where there are none yet."""
    context = MigrationContext.configure(connection, opts={"version_table": VERSION_TABLE})
    found = context.get_current_revision()
    if found is None:
        others = inspect(connection).get_table_names() if place.file is not None else []
        if set(others) - {VERSION_TABLE}:
            raise InputError(
                "a database of another program", where=place.shown,
                got=f"the table {sorted(others)[0]!r}"[:200], expected="a history of minirt",
            )  # fmt: skip
        return None
    try:
        script.get_revision(found)
    except CommandError:
        raise InputError(
            "a history of a newer minirt", where=place.shown,
            got=f"version {found!r}"[:100], expected=f"at most {script.get_current_head()!r}",
        ) from None  # fmt: skip
    return found


def _config(steps: Path | None) -> Config:
    folder = steps or Path(str(resources.files("reports.history") / "migrations"))
    config = Config()
    config.set_main_option("script_location", str(folder).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    return config
