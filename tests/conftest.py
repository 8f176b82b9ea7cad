"""What several files of tests are given."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.helpers.postgres_server import Server, running


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    """A PostgreSQL of the tests' own: each that wants a database asks it for a fresh one."""
    with running() as found:
        yield found


@pytest.fixture(params=["sqlite", "postgresql"])
def target(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """An empty place for a history, of each kind."""
    if request.param == "sqlite":
        return str(tmp_path / "history.sqlite")
    found: Server = request.getfixturevalue("server")
    return found.fresh()
