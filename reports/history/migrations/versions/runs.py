"""Runs, their scenes, what each reference answered, and every cell."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make the tables of version 0.1.0."""
    op.create_table(
        "minirt_runs",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("digest", sa.String(64), nullable=False, unique=True),
        sa.Column("series", sa.Text, nullable=False),
        sa.Column("judged", sa.Text, nullable=False),
        sa.Column("references", sa.JSON, nullable=False),
        sa.Column("started", sa.String(40), nullable=False),
        sa.Column("outcome", sa.String(20), nullable=False),
        sa.Column("exit_status", sa.Integer, nullable=False),
        sa.Column("sentence", sa.Text, nullable=False),
        sa.Column("commit", sa.String(64)),
        sa.Column("dirty", sa.Boolean),
        sa.Column("system", sa.Text, nullable=False),
        sa.Column("cpu", sa.Text, nullable=False),
        sa.Column("cores", sa.Integer, nullable=False),
        sa.Column("versions", sa.JSON, nullable=False),
        sa.Column("programs", sa.JSON, nullable=False),
        sa.Column("command", sa.Text, nullable=False),
        sa.Column("seconds", sa.Double, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "minirt_scenes",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column(
            "run_id", sa.Integer, sa.ForeignKey("minirt_runs.id", ondelete="CASCADE"),
            nullable=False, index=True,
        ),
        sa.Column("name", sa.String(255), nullable=False, index=True),
        sa.Column("sha256", sa.String(64), nullable=False),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("first_wrong_stage", sa.String(20), nullable=False),
        sa.Column("ratio", sa.Double),
        sa.Column("seconds", sa.Double, nullable=False),
        sa.Column("peak_memory", sa.BigInteger, nullable=False),
        sa.Column("nx", sa.Integer, nullable=False),
        sa.Column("ny", sa.Integer, nullable=False),
    )  # fmt: skip
    op.create_table(
        "minirt_answers",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column(
            "scene_id", sa.Integer, sa.ForeignKey("minirt_scenes.id", ondelete="CASCADE"),
            nullable=False, index=True,
        ),
        sa.Column("reference", sa.String(255), nullable=False),
        sa.Column("program", sa.Text, nullable=False),
        sa.Column("seconds", sa.Double, nullable=False),
    )  # fmt: skip
    op.create_table(
        "minirt_cells",
        sa.Column(
            "answer_id", sa.Integer, sa.ForeignKey("minirt_answers.id", ondelete="CASCADE"),
            primary_key=True,
        ),
        sa.Column("quantity", sa.String(40), primary_key=True),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("ratio", sa.Double),
        sa.Column("pixels", sa.Integer, nullable=False),
        sa.Column("certain", sa.Integer, nullable=False),
        sa.Column("compared", sa.Integer, nullable=False),
        sa.Column("wrong", sa.Integer, nullable=False),
        sa.Column("first_wrong", sa.Integer, nullable=False),
        sa.Column("reason", sa.Text, nullable=False),
        sqlite_with_rowid=False,
    )  # fmt: skip
