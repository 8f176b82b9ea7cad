from __future__ import annotations

import re
from dataclasses import replace

from reports.results.findings import findings_of
from reports.results.summary import MOST_ROWS, escaped, summary_markdown
from tests.helpers.fake_references import HOSTILE, CannotSay, Faulty, Partial, small_scene
from tests.helpers.report_runs import empty_run, good_run, run_of, troubled_run


def test_a_good_run_is_its_verdict_counts_and_a_line_for_each_scene() -> None:
    lines = summary_markdown(good_run()).splitlines()
    assert lines[0].startswith("# ✅ PASS: 2 scenes agree with honest")
    assert (
        "| failed | crashed | timed out | missing | known | passed | not supported | not given |"
        in lines
    )
    assert "| 0 | 0 | 0 | 0 | 0 | 40 | 0 | 0 |" in lines
    assert "## What fails" not in lines
    assert "| ball | ✓ 0×, 100 % certain |" in lines


def test_failing_cells_come_first_with_both_values() -> None:
    text = summary_markdown(troubled_run())
    assert text.startswith("# ❌ FAIL: 2 of 2 scenes")
    assert (
        text.index("## What fails") < text.index("## References without") < text.index("## Scenes")
    )
    assert re.search(r"\| ball \| one-pixel \| depth \| ✗ 1 px, .*× \| \(20, 31\): ours 4\.", text)
    assert "| aborting | ! crashed |" in text


def test_every_table_row_has_as_many_cells_as_its_header() -> None:
    rows = [line for line in summary_markdown(troubled_run()).splitlines() if line.startswith("|")]
    widths = [len(re.findall(r"(?<!\\)\|", row)) for row in rows]
    starts = [k for k, row in enumerate(rows) if re.fullmatch(r"\|[-:|]+", row)]
    assert len(starts) == 5
    for k, width in enumerate(widths):
        header = max(start - 1 for start in [*starts, 1] if start - 1 <= k)
        assert width == widths[header], rows[k]


def test_what_was_not_compared_is_listed_with_reasons_and_counts() -> None:
    text = summary_markdown(run_of([small_scene("a"), small_scene("b")], [Partial()]))
    assert "**Not checked:** ray, object, " in text.splitlines()[2]
    assert "| partial | color on 2 scenes | 2 | it is colour-blind |" in text
    assert "| partial | 17 quantities on 2 scenes | 34 | the frame does not hold it |" in text
    assert "## Not compared" not in summary_markdown(good_run())
    text = summary_markdown(run_of([small_scene("a"), small_scene("b")], [CannotSay()]))
    assert "- a, b: its pixels are round" in text


def test_hostile_text_stays_text() -> None:
    text = summary_markdown(troubled_run())
    assert "<img" not in text
    assert "&lt;img src=x" in text
    assert not set(text) & set("\x00\x1b")
    assert escaped(HOSTILE).count(r"\|") == 1
    assert escaped("a\nb <c> &amp; *d*") == r"a b &lt;c\> &amp;amp; \*d\*"


def test_long_lists_are_cut_and_say_so() -> None:
    run = run_of([small_scene(f"s{k}") for k in range(2)], [Faulty()])
    many = replace(run, findings=findings_of(run.results * 10))
    total = len(many.findings.failing)
    assert total > MOST_ROWS
    text = summary_markdown(many)
    assert f"… and {total - MOST_ROWS} more." in text
    assert text.count("| faulty |") == MOST_ROWS + 1


def test_no_scene_is_red() -> None:
    text = summary_markdown(empty_run())
    assert text.startswith("# ❌ FAIL: no scene was chosen, so nothing was compared")
    assert "## Scenes" not in text
