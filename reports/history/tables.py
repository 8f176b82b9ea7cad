"""The tables of a history. `migrations/` is what makes and changes them in a database."""

from __future__ import annotations

from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    Column,
    Double,
    ForeignKey,
    Integer,
    MetaData,
    String,
    Table,
    Text,
)

from reports.history.entry import LONGEST_NAME

#: Where alembic notes the version of the tables.
VERSION_TABLE = "minirt_version"
#: The version that these are: the last of the steps in `migrations/`.
VERSION = "0001"

metadata = MetaData()

runs = Table(
    "minirt_runs",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("digest", String(64), nullable=False, unique=True),
    Column("series", Text, nullable=False),
    Column("judged", Text, nullable=False),
    Column("references", JSON, nullable=False),
    Column("started", String(40), nullable=False),
    Column("outcome", String(20), nullable=False),
    Column("exit_status", Integer, nullable=False),
    Column("sentence", Text, nullable=False),
    Column("commit", String(64)),
    Column("dirty", Boolean),
    Column("system", Text, nullable=False),
    Column("cpu", Text, nullable=False),
    Column("cores", Integer, nullable=False),
    Column("versions", JSON, nullable=False),
    Column("programs", JSON, nullable=False),
    Column("command", Text, nullable=False),
    Column("seconds", Double, nullable=False),
    sqlite_autoincrement=True,
)

scenes = Table(
    "minirt_scenes",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("run_id", ForeignKey("minirt_runs.id", ondelete="CASCADE"), nullable=False, index=True),
    Column("name", String(LONGEST_NAME), nullable=False, index=True),
    Column("sha256", String(64), nullable=False),
    Column("state", String(20), nullable=False),
    Column("first_wrong_stage", String(20), nullable=False),
    Column("ratio", Double),
    Column("seconds", Double, nullable=False),
    Column("peak_memory", BigInteger, nullable=False),
    Column("nx", Integer, nullable=False),
    Column("ny", Integer, nullable=False),
)

answers = Table(
    "minirt_answers",
    metadata,
    Column("id", Integer, primary_key=True),
    Column(
        "scene_id", ForeignKey("minirt_scenes.id", ondelete="CASCADE"), nullable=False, index=True
    ),
    Column("reference", String(LONGEST_NAME), nullable=False),
    Column("program", Text, nullable=False),
    Column("seconds", Double, nullable=False),
)

cells = Table(
    "minirt_cells",
    metadata,
    Column("answer_id", ForeignKey("minirt_answers.id", ondelete="CASCADE"), primary_key=True),
    Column("quantity", String(40), primary_key=True),
    Column("state", String(20), nullable=False),
    Column("ratio", Double),
    Column("pixels", Integer, nullable=False),
    Column("certain", Integer, nullable=False),
    Column("compared", Integer, nullable=False),
    Column("wrong", Integer, nullable=False),
    Column("first_wrong", Integer, nullable=False),
    Column("reason", Text, nullable=False),
    sqlite_with_rowid=False,
)
