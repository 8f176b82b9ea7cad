"""The two tiers of the tests, and what several files of tests are given.

**Fast** is every test without a mark: ``make test`` runs it, with the linters beside it, in under
four minutes on two cores. It has the whole power: it kills every mutant of the catalogue, and holds
every reference on small images of the whole atlas and on a few scenes at full size.

**Full** is what bears ``@pytest.mark.full``: the same at full size, with more seeds, more kills,
more commands through real programs. ``make test-rest`` runs it, ``make test-all`` both.

A test bears the mark if it takes long and the fast tier holds the same claim on a smaller case.
``tests/house/test_tiers.py`` proves that each test is in exactly one tier. In neither is a test
skipped in silence: what is missing makes a test fail, or is a reason that the test checks.
"""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest

from tests.helpers.postgres_server import Server, running
from tests.helpers.tiers import COLLECTED


def pytest_itemcollected(item: pytest.Item) -> None:
    """Let ``-k`` find a test by the names that its mark ``also_named`` gives it."""
    for mark in item.iter_markers("also_named"):
        item.extra_keyword_matches.update(mark.args)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep all that was collected, before ``-m`` and ``-k`` choose."""
    config.stash[COLLECTED] = tuple(items)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Where ``MINIRT_REQUIRE`` names what must be here, as in CI, a test that skips has failed."""
    report = yield
    if report.skipped and os.environ.get("MINIRT_REQUIRE"):
        report.outcome = "failed"
    return report


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
