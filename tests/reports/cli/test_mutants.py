"""`minirt mutants` prints the kill matrix, the floor, and ends as it should."""

from __future__ import annotations

import json

import pytest

from reference.mutants import CATALOGUE, ORIGINAL
from reference.mutants.matrix import Kill
from reference.mutants.run import MutationRun
from reports.cli.main import run

NAMES = "no-half-pixel,epsilon-tenfold"


def row(name: str, failed: tuple[str, ...], **charged: int) -> Kill:
    from minirt.quantities import STAGES

    return Kill(name, "S2", "with x", "ray", 2, failed, dict.fromkeys(STAGES, 0) | charged)


def test_the_matrix_of_two_mutants(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["mutants", "--only", NAMES, "--jobs", "1"]) == 0
    out = capsys.readouterr().out
    assert "2 of 2 mutants killed, 2 by the stage that they really break" in out
    assert "false alarms on the lecture's own rules: 0 of" in out
    assert "Smallest errors caught: 1 pixel of a mask" in out
    assert all(name in out for name in NAMES.split(","))


@pytest.mark.parametrize(
    ("rows", "status"),
    [
        ([row(ORIGINAL.name, ()), row("a", ("s",), ray=3)], 0),
        ([row(ORIGINAL.name, ()), row("a", ())], 1),
        ([row(ORIGINAL.name, ("s",), hit=1), row("a", ("s",), ray=3)], 1),
    ],
)
def test_a_survivor_or_a_false_alarm_is_a_failure(
    rows: list[Kill],
    status: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    made = MutationRun(rows[0], tuple(rows[1:]))
    monkeypatch.setattr("reference.mutants.run.run_mutants", lambda *_: made)
    assert run(["mutants"]) == status
    assert ("Not noticed: a" in capsys.readouterr().out) == (not rows[1].killed)
    assert run(["mutants", "--json"]) == status
    document = json.loads(capsys.readouterr().out)
    assert document["killed"] == sum(each.killed for each in rows[1:])
    assert document["false_alarms"] == len(rows[0].failed)
    assert document["mutants"][0]["charged"]["ray"] == rows[1].charged["ray"]


def test_an_unknown_mutant_is_a_misuse(capsys: pytest.CaptureFixture[str]) -> None:
    assert "no-such" not in CATALOGUE
    assert run(["mutants", "--only", "no-such"]) == 2
    assert "no such mutant" in capsys.readouterr().err
