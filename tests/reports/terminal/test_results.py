from __future__ import annotations

import io

from rich.console import Console

from reports.results.record import Run
from reports.terminal.results import print_run
from tests.helpers.fake_references import HOSTILE, CannotSay, Partial, small_scene
from tests.helpers.report_runs import empty_run, good_run, run_of, troubled_run


def printed(run: Run, terminal: bool = False) -> str:
    stream = io.StringIO()
    console = Console(
        file=stream, width=100, force_terminal=terminal, highlight=False, markup=False, emoji=False
    )
    print_run(run, console)
    return stream.getvalue()


def test_a_good_run_is_a_line_for_each_scene_and_the_verdict_last() -> None:
    lines = [line.strip() for line in printed(good_run()).splitlines() if line.strip()]
    assert lines[0].split() == ["scene", "honest", "least", "certain"]
    assert lines[2].split() == ["ball", "✓", "0×", "100", "%"]
    assert lines[-2].endswith("report.html")
    assert lines[-1].startswith("✓ PASS: 2 scenes agree with honest")
    assert len(lines) == 6


def test_every_failing_cell_has_a_line_with_both_values() -> None:
    lines = printed(troubled_run()).splitlines()
    depth = [line for line in lines if line.startswith("✗ ball × one-pixel × depth: 1 px, ")]
    assert len(depth) == 1
    assert "worst (20, 31): ours 4.31" in depth[0]
    assert lines[-1].startswith("✗ FAIL: 2 of 2 scenes; first wrong stage: t")


def test_who_gave_no_answer_is_named_with_reason_and_last_output() -> None:
    text = printed(troubled_run())
    assert "! aborting: crashed on <img" in text
    assert "    the process was ended by SIGABRT\n" in text
    assert "    │ LLVM ERROR: <img" in text
    assert "! hanging: timed out on <img" in text
    assert "    │ loading the kernel\n" in text


def test_what_was_not_compared_is_named_with_the_reason_before_the_verdict() -> None:
    lines = printed(run_of([small_scene()], [Partial()])).splitlines()
    assert "– partial: 17 quantities on 1 scene: the frame does not hold it" in lines
    assert "– partial: color on 1 scene: it is colour-blind" in lines
    assert lines[-2].startswith("Not checked: ray, object, ")
    assert lines[-2].endswith("color, alpha on the scene")
    lines = printed(run_of([small_scene()], [CannotSay()])).splitlines()
    assert lines[-3].startswith("Not compared: ball: its pixels are round <img")
    assert lines[-1].startswith("✗ INCOMPLETE: nothing was compared: its pixels are round")


def test_hostile_names_give_the_terminal_no_orders() -> None:
    for terminal in (False, True):
        text = printed(troubled_run(), terminal)
        assert "\x00" not in text
        assert "\x1b[31m \x00" not in text
        assert "[red]r[/red] �[31m �" in text
    assert "\x1b" not in printed(troubled_run())
    assert "\x1b" in HOSTILE


def test_colours_on_a_terminal_only() -> None:
    assert "\x1b[" in printed(good_run(), terminal=True)
    assert "\x1b" not in printed(good_run())


def test_no_scene_is_said_and_no_table_is_shown() -> None:
    lines = printed(empty_run()).splitlines()
    assert len(lines) == 2
    assert lines[-1] == "✗ FAIL: no scene was chosen, so nothing was compared"
