"""What a person sees in the terminal: the table, what fails, the report's path, the verdict."""

from __future__ import annotations

from collections.abc import Iterable

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from reference.verify.results import SceneResult
from reports.results.cells import Cell
from reports.results.coverage import gap_in_words
from reports.results.findings import AnswerFindings, SceneFindings, Unanswered, answer_in_words
from reports.results.record import Run
from reports.results.words import (
    ICONS,
    figure,
    icon,
    is_consequence,
    judgement_in_words,
    one_line,
    plain,
    share,
    worst_in_words,
)

#: Failing cells that are listed one by one; the report has them all.
MOST_LINES = 40
#: Reasons for what was not compared that are listed.
MOST_GAPS = 12

_STYLES = {
    "passed": "blue", "failed": "bold dark_orange", "crashed": "bold magenta",
    "timed out": "bold magenta", "missing": "bold magenta", "known": "dark_orange",
    "not supported": "dim",
    "not given": "dim",
}  # fmt: skip


def print_run(run: Run, console: Console) -> None:
    """The table of scenes, a line for each failing cell, the report's path and the verdict."""
    findings = run.findings
    if findings.scenes:
        console.print(_table(run))
    groups = _grouped(findings.failing)
    for group in groups[:MOST_LINES]:
        _print_line(console, _failure(group))
    if len(groups) > MOST_LINES:
        _print_line(console, Text(f"  … and {len(groups) - MOST_LINES} more in the report", "dim"))
    for each in findings.diagnoses[:MOST_LINES]:
        _print_line(console, Text(f"→ {one_line(each.scene)} × {each.reference}: {each.words}"))
    for result in findings.contradicted:
        _contradiction(console, result)
    for unanswered in findings.unanswered:
        _unanswered(console, unanswered)
    for gap in findings.gaps[:MOST_GAPS]:
        _print_line(console, Text(f"– {gap.reference}: {gap_in_words(gap)}: {gap.reason}", "dim"))
    for line in findings.not_compared:
        _print_line(console, Text(f"Not compared: {line}"))
    _print_line(console, Text.assemble("report: ", str((run.folder / "report.html").resolve())))
    for remark in run.remarks:
        _print_line(console, Text(one_line(remark)))
    if findings.not_checked:
        _print_line(console, Text(f"Not checked: {findings.not_checked}"))
    style = "bold blue" if run.exit_status == 0 else "bold dark_orange"
    sign = ICONS["passed"] if run.exit_status == 0 else ICONS["failed"]
    _print_line(console, Text(f"{sign} {one_line(run.verdict.sentence, 1000)}", style))


def _print_line(console: Console, text: Text) -> None:
    console.print(text, soft_wrap=True)


def _table(run: Run) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("scene", overflow="fold")
    for name in run.references:
        table.add_column(Text(one_line(name)), overflow="fold")
    table.add_column("least certain", justify="right")
    for scene in run.findings.scenes:
        cells = [_answer(answer) for answer in scene.answers]
        label = Text(one_line(scene.result.scene.name, 60))
        table.add_row(label, *cells, _certain(scene))
    return table


def _answer(found: AnswerFindings) -> Text:
    words = answer_in_words(found).split(",")[0]  # the share of certain pixels has its column
    return Text(f"{ICONS[found.state]} {words}", _STYLES[found.state])


def _certain(scene: SceneFindings) -> Text:
    """The least share of certain pixels over all that was compared."""
    least = scene.least_certain
    return Text("–" if least is None else share(least.certain, least.pixels), "dim")


def _grouped(cells: Iterable[Cell]) -> list[list[Cell]]:
    """Failing cells; those of one scene and reference that fail for one reason are together."""
    groups: dict[tuple[str, ...], list[Cell]] = {}
    for cell in cells:
        alone = cell.check.quantity if cell.check.wrong else ""
        key = (cell.scene, cell.reference, cell.check.reason, alone)
        groups.setdefault(key, []).append(cell)
    return list(groups.values())


def _failure(cells: list[Cell]) -> Text:
    """A failing cell, or several alike: where, how much, the worst pixel with both values."""
    first = cells[0]
    check = first.check
    style = "dark_orange" if is_consequence(check) else _STYLES["failed"]
    names = check.quantity if len(cells) == 1 else f"{len(cells)} quantities"
    place = f"{one_line(first.scene)} × {first.reference} × {names}"
    detail = f"{figure(check)}; worst {worst_in_words(check)}" if check.wrong else check.reason
    return Text.assemble((f"{icon(check)} {place}: ", style), detail)


def _contradiction(console: Console, result: SceneResult) -> None:
    """A scene on which exact arithmetic has another answer than minirt."""
    if result.judgement is not None:
        place = f"{ICONS['failed']} {one_line(result.scene.name)} × exact arithmetic: "
        words = judgement_in_words(result.judgement)
        _print_line(console, Text.assemble((place, _STYLES["failed"]), words))


def _unanswered(console: Console, group: Unanswered) -> None:
    """A reference that gave no answer: why, on which scenes, and its last lines of output."""
    names = ", ".join(one_line(name, 60) for name in group.scenes[:3])
    more = f" and {len(group.scenes) - 3} more" if len(group.scenes) > 3 else ""
    head = f"{ICONS[group.state]} {group.reference}: {group.state}"
    _print_line(console, Text.assemble((head, _STYLES[group.state]), f" on {names}{more}"))
    _print_line(console, Text(f"    {one_line(group.reason)}"))
    for line in [each for each in plain(group.output).splitlines() if each.strip()][-3:]:
        _print_line(console, Text(f"    │ {one_line(line)}", "dim"))
