"""The tables of a history: what the steps make, a step more, and two that start at once."""

from __future__ import annotations

import shutil
import sqlite3
import subprocess
import sys
from importlib import resources
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import inspect

from minirt.errors import InputError
from reports.history.migrate import bring_up_to_date
from reports.history.place import engine_of, place_of
from reports.history.store import History
from reports.history.tables import VERSION, VERSION_TABLE, metadata
from tests.helpers.history_runs import entry, whole
from tests.helpers.history_writers import READY, append_many

#: A step that a later version might take: a column with what earlier rows have in it.
NEXT = """
import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    op.add_column("minirt_runs", sa.Column("place", sa.Text, server_default="here"))
    {more}
"""


@pytest.fixture
def steps(tmp_path: Path) -> Path:
    """A copy of the steps, to which one can be added."""
    folder = tmp_path / "steps"
    shutil.copytree(Path(str(resources.files("reports.history") / "migrations")), folder)
    return folder


def columns(target: str) -> set[str]:
    engine = engine_of(place_of(target))
    return {column["name"] for column in inspect(engine).get_columns("minirt_runs")}


def test_the_steps_make_the_tables_that_are_declared(target: str) -> None:
    History(target).close()
    with engine_of(place_of(target)).connect() as connection:
        assert MigrationContext.configure(
            connection, opts={"version_table": VERSION_TABLE}
        ).get_current_heads() == (VERSION,)
        context = MigrationContext.configure(
            connection, opts={"version_table": VERSION_TABLE, "compare_type": True}
        )
        assert compare_metadata(context, metadata) == []
        metadata.tables["minirt_runs"].columns["seconds"].name = "second"
        try:
            assert compare_metadata(context, metadata) != []
        finally:
            metadata.tables["minirt_runs"].columns["seconds"].name = "seconds"


def test_an_older_history_is_changed_and_keeps_its_runs(target: str, steps: Path) -> None:
    with History(target) as history:
        first = history.append(entry(1))
    (steps / "versions" / "place.py").write_text(NEXT.format(more=""), encoding="utf-8")
    place = place_of(target)
    assert "place" not in columns(target)
    for _ in range(2):
        bring_up_to_date(engine_of(place), place, steps)
    assert "place" in columns(target)
    with pytest.raises(InputError, match="a history of a newer minirt; got version '0002'"):
        History(target)
    engine = engine_of(place)
    with engine.connect() as connection:
        row = connection.exec_driver_sql("SELECT id, digest, place FROM minirt_runs").one()
    assert tuple(row) == (first, entry(1).digest, "here")


def test_a_step_that_fails_leaves_everything_as_it_was(target: str, steps: Path) -> None:
    with History(target) as history:
        first = history.append(entry(1))
    text = NEXT.format(more='op.drop_table("minirt_cells"); op.drop_table("nowhere")')
    (steps / "versions" / "place.py").write_text(text, encoding="utf-8")
    place = place_of(target)
    with pytest.raises(Exception, match="nowhere"):
        bring_up_to_date(engine_of(place), place, steps)
    assert "place" not in columns(target)
    with History(target) as history:
        whole(history, first, sum(1 for _ in entry().cells()))


def test_tables_of_this_version_need_no_alembic(tmp_path: Path) -> None:
    path = str(tmp_path / "history.sqlite")
    History(path).close()
    code = (
        "import sys; from reports.history.store import History\n"
        "History(sys.argv[1]).close(); print('alembic' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code, path], capture_output=True, text=True)
    assert done.stdout == "False\n", done.stderr


def test_three_that_start_at_once_make_the_tables_once(target: str) -> None:
    gate = READY.Barrier(3)
    starters = [
        READY.Process(target=append_many, args=(target, entry(), [str(k)], gate)) for k in range(3)
    ]
    for starter in starters:
        starter.start()
    for starter in starters:
        starter.join(60)
    assert [starter.exitcode for starter in starters] == [0] * 3
    with History(target, create=False) as history:
        assert history.number("latest") == 3


def test_a_file_that_only_has_begun_is_a_history_yet(tmp_path: Path) -> None:
    path = tmp_path / "history.sqlite"
    sqlite3.connect(path).close()
    path.touch()
    with History(str(path)) as history:
        assert history.append(entry(1)) == 1
