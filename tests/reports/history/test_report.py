"""`minirt report`: what changed from run to run, in the terminal, as JSON and as a page."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from reports.cli.main import run
from reports.history.difference import Difference, difference
from reports.history.entry import Entry
from reports.history.pages import compare_html
from reports.history.store import History
from reports.history.text import verdict_of
from reports.results.record import results_json
from reports.results.words import figure
from tests.helpers.fake_references import HOSTILE
from tests.helpers.history_runs import entry, with_cell
from tests.helpers.report_runs import good_run
from tests.reports.page.test_report import Page

Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def command(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> Command:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MINIRT_HISTORY", raising=False)

    def call(*arguments: str) -> tuple[int, str, str]:
        capsys.readouterr()
        status = run(arguments)
        out, err = capsys.readouterr()
        return status, out, err

    return call


@pytest.fixture
def kept(tmp_path: Path) -> str:
    """Three runs: good, failing in one cell, good with a larger error in it."""
    (tmp_path / "report").mkdir()
    with History(str(tmp_path / "report" / "history.sqlite")) as history:
        history.append(entry(1, commit="a" * 40))
        history.append(failing())
        history.append(with_cell(entry(3, commit="c" * 40), ratio=0.75, certain=1720))
    return "report/history.sqlite"


def failing(reason: str = "7 pixels wrong") -> Entry:
    return with_cell(
        entry(2, commit="b" * 40), state="failed", ratio=math.inf, wrong=7, reason=reason
    )


def renamed(run: Entry, name: str, **changes: Any) -> Entry:
    scene, *rest = run.scenes
    return replace(run, scenes=(replace(scene, name=name, **changes), *rest))


def kinds(found: Difference) -> list[str]:
    return [cell.kind for cell in found.cells]


def test_the_same_run_twice_differs_in_nothing() -> None:
    found = difference(entry(1), entry(2))
    assert (found.cells, found.origin, found.regressions) == ((), (), 0)
    assert found.same == sum(1 for _ in entry().cells()) == 40


@pytest.mark.parametrize(
    ("changes", "kind", "regression"),
    [
        ({"state": "failed", "ratio": math.inf, "wrong": 7}, "worse", True),
        ({"state": "crashed", "ratio": None}, "worse", True),
        ({"state": "not given", "ratio": None}, "worse", False),
        ({"ratio": 0.5}, "higher", False),
        ({"certain": 1700}, "changed", False),
    ],
)
def test_a_cell_that_changes_is_found_either_way(
    changes: dict[str, Any], kind: str, regression: bool
) -> None:
    there = difference(entry(1), with_cell(entry(2), **changes))
    assert (kinds(there), there.same) == ([kind], 39)
    assert there.cells[0].regression is regression
    assert there.cells[0].name[:2] == ("ball", "honest")
    back = difference(with_cell(entry(2), **changes), entry(1))
    assert kinds(back) == [{"worse": "better", "higher": "lower"}.get(kind, kind)]
    assert back.regressions == 0


@pytest.mark.parametrize("after", ["not given", "not supported", "missing"])
def test_a_failure_of_which_nobody_speaks_any_more_is_no_better(after: str) -> None:
    found = difference(failing(), with_cell(entry(2), state=after, ratio=None))
    assert (kinds(found), found.regressions) == (["changed"], 0)


def test_the_verdict_tells_what_is_lost() -> None:
    silent = difference(entry(1), with_cell(entry(2), state="not given", ratio=None))
    assert verdict_of(silent) == "No new failure, but 1 cell worse"
    fewer = difference(entry(1), replace(entry(2), scenes=entry(2).scenes[1:]))
    assert verdict_of(fewer) == "No new failure, but 20 cells gone"
    assert verdict_of(difference(entry(1), entry(2))) == "Nothing got worse"
    assert verdict_of(difference(entry(1), failing())) == "1 cell got worse"


def test_more_wrong_pixels_are_higher() -> None:
    found = difference(failing(), with_cell(failing(), wrong=8))
    assert kinds(found) == ["higher"]


def test_scenes_are_new_gone_renamed_and_altered() -> None:
    old, new = entry(1), entry(2)
    found = difference(old, renamed(new, "globe"))
    assert (found.renamed, found.new, found.gone) == ((("ball", "globe"),), (), ())
    assert found.cells == ()
    found = difference(old, renamed(new, "globe", sha256="0" * 64))
    assert (found.renamed, found.new, found.gone) == ((), ("globe",), ("ball",))
    assert found.counts["new"] == found.counts["gone"] == 20
    assert found.notable == ()  # the scenes are named instead
    found = difference(old, renamed(failing(), "globe", sha256="0" * 64))
    assert [(cell.name[0], cell.kind) for cell in found.notable] == [("globe", "new")]
    found = difference(old, renamed(new, "ball", sha256="0" * 64))
    assert found.altered == ("ball",)


def test_where_the_runs_came_from_is_set_side_by_side() -> None:
    found = difference(
        entry(1, commit="a" * 40, dirty=False, versions={"NumPy": "2.3"}),
        entry(2, commit="b" * 40, dirty=True, versions={"NumPy": "2.4", "Python": "3.13"}),
    )
    assert found.origin == (
        ("commit", "a" * 10, "b" * 10 + " with local changes"),
        ("NumPy", "2.3", "2.4"),
        ("Python", "–", "3.13"),
    )


def test_figures_speak_as_the_report_does() -> None:
    cell = entry().scenes[0].answers[0].checks[0]
    for changes, words in (
        ({}, "0×"),
        ({"quantity": "hit"}, "equal"),
        ({"compared": 0}, "none"),
        ({"state": "failed", "wrong": 7, "ratio": math.inf}, "7 px"),
        ({"state": "failed", "wrong": 7, "ratio": 14.0}, "7 px, 14×"),
        ({"state": "known", "wrong": 7, "ratio": 14.0}, "known: 7 px, 14×"),
        ({"state": "failed", "certain": 864}, "50.00 % certain"),
        ({"state": "failed", "pixels": 0}, "unusable"),
        ({"state": "timed out"}, "timed out"),
    ):
        changed: dict[str, Any] = dict(changes)
        assert figure(replace(cell, **changed)) == words


def test_compare_in_the_terminal(command: Command, kept: str) -> None:
    status, out, _ = command("report", "compare", "1", "2")
    assert status == 1
    name = entry().scenes[0].answers[0].checks[0].quantity
    line = f"▲ ball × honest × {name}: ✓ 0× (100 % certain) → ✗ 7 px (100 % certain)"
    assert f"{line}; 7 pixels wrong" in out
    assert "commit: aaaaaaaaaa" in out
    assert out.endswith("1 cell got worse: 1 worse; 39 cells the same\n")
    status, out, _ = command("report", "compare", "previous")  # with the latest
    assert status == 0
    assert out.endswith("Nothing got worse: 1 better; 39 cells the same\n")


def test_compare_takes_results_for_a_run(command: Command, kept: str, tmp_path: Path) -> None:
    (tmp_path / "old").mkdir()
    path = tmp_path / "old" / "results.json"
    path.write_text(results_json(good_run()), encoding="utf-8")
    assert command("report", "compare", "old", "1")[0] == 0
    assert command("report", "compare", "old/results.json", "2")[0] == 1
    status, out, err = command("report", "compare", "old", "old", "--history", "none.sqlite")
    assert (status, err) == (0, "")  # no history is asked
    assert "Nothing got worse: no cell changed; 40 cells the same" in out


def test_compare_as_json(command: Command, kept: str) -> None:
    status, out, _ = command("report", "compare", "1", "2", "--json")
    document = json.loads(out)
    assert (status, document["regressions"], document["same"]) == (1, 1, 39)
    (cell,) = document["cells"]
    assert (cell["kind"], cell["after"]["ratio"], cell["before"]["state"]) == (
        "worse", "inf", "passed",
    )  # fmt: skip


def test_compare_as_a_page(command: Command, kept: str, tmp_path: Path) -> None:
    status, _, err = command("report", "compare", "1", "2", "--html", "page.html")
    assert (status, err) == (1, "page: page.html\n")
    page = page_of((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert [e.text.strip() for e in page.all("h1")] == ["✗ 1 cell got worse"]
    (row,) = page.all("tr", "worse")
    assert "✓ 0× (100 % certain)✗ 7 px (100 % certain)7 pixels wrong" in row.text
    assert {e.text for e in page.all("td", "nowrap")} >= {"▲ worse"}


def page_of(text: str) -> Page:
    page = Page()
    page.feed(text)
    page.close()
    assert page.open == []
    return page


def test_a_page_shows_hostile_text_as_text() -> None:
    before = renamed(entry(1), HOSTILE)
    after = renamed(failing(HOSTILE), HOSTILE)
    text = compare_html(difference(before, after))
    page = page_of(text)
    assert page.all("img") == []
    assert page.all("script") == []
    assert "<img" not in text
    assert "http" not in text.replace("http-equiv", "")
    assert any("${7*7} {{7*7}}" in element.text for element in page.all("h2"))


def test_history_of_a_scene(command: Command, kept: str) -> None:
    with History(kept) as history:
        history.append(entry(9, judged="./tracer {scene} {out}"))
    status, out, _ = command("report", "history", "atlas:ball")
    assert status == 0
    lines = out.splitlines()
    assert lines[0].startswith("gate: ./tracer {scene} {out}: 1 run")
    assert lines[3] == "verify: honest: 3 runs  ▁█▃"
    assert [line.split()[0] for line in lines[5:8]] == ["1", "2", "3"]
    assert "bbbbbbbbbb  ✗ failed           ∞×  ▲ passed → failed" in lines[6]
    assert lines[7].rstrip().endswith("▼ failed → passed")
    status, out, _ = command("report", "history", "ball", "--most", "1")
    rows = [line.split()[0] for line in out.splitlines() if line.strip()[:1].isdigit()]
    assert rows == ["4", "3"]


def test_history_as_json(command: Command, kept: str) -> None:
    document = json.loads(command("report", "history", "ball", "--json")[1])
    (series,) = document["series"]
    assert [point["ratio"] for point in series["runs"]] == [0.0, "inf", 0.75]
    assert [(c["before"], c["after"]) for c in series["changes"]] == [(1, 2), (2, 3)]


def test_record_adds_a_run_once(command: Command, kept: str, tmp_path: Path) -> None:
    (tmp_path / "results.json").write_text(results_json(good_run()), encoding="utf-8")
    for _ in range(2):
        status, out, err = command("report", "record", "results.json", "--json")
        assert (status, json.loads(out)) == (0, {"run": 4, "history": kept})
        assert err == f"history: run 4 in {kept}\n"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["compare", "1", "7"], "no such run; got '7'; expected a number up to 3"),
        (["compare", "1", "nowhere/results.json"], "No such file"),
        (["compare", "1", "latest", "--history", "none.sqlite"], "no history here"),
        (["history", "bal"], "no run of this scene; got 'bal'; expected ball"),
        (["history", "ball", "--history", "postgresql://a:hush@127.0.0.1:1/x"], "refused"),
        (["record", "nowhere.json"], "No such file"),
        (["compare", "1", "2", "--html", "no/such/page.html"], "cannot be written"),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: list[str], said: str, command: Command, kept: str
) -> None:
    status, out, err = command("report", *arguments)
    assert (status, out) == (2, "")
    assert err.startswith("error: ")
    assert said in err
    assert len(err.splitlines()) == 1
    assert "hush" not in err


def test_a_misuse_names_the_command_s_own_help(command: Command) -> None:
    assert "'minirt report compare --help' shows how" in command("report", "compare")[2]
    assert "'minirt report --help' shows how" in command("report", "paint")[2]


def test_the_history_may_be_named_by_the_environment(
    command: Command, kept: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / kept).rename(tmp_path / "other.sqlite")
    monkeypatch.setenv("MINIRT_HISTORY", "other.sqlite")
    assert command("report", "history", "ball")[0] == 0
