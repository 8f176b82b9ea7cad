"""`summary.md`: the verdict as Markdown, for the summary of a CI step."""

from __future__ import annotations

import re

from reference.verify.results import ReferenceResult
from reports.results.coverage import gap_in_words, gaps, not_checked, not_compared
from reports.results.findings import (
    answer_in_words,
    answer_state,
    counts,
    diagnosed,
    failing,
    silent,
)
from reports.results.judgement import convicted, judgement_in_words
from reports.results.record import Run
from reports.results.words import (
    ICONS,
    count,
    figure,
    icon,
    is_consequence,
    one_line,
    worst_in_words,
)

#: Rows of failing checks that a summary lists; the report has them all.
MOST_ROWS = 50
#: Scenes that it names of those on which a reference gave no answer for the same reason.
MOST_NAMES = 8

_SPECIAL = re.compile(r"([\\`*_\[\]#|~<>&$@])")


def escaped(text: str) -> str:
    """Text on one line that Markdown shows as it is, whatever it holds."""
    return _SPECIAL.sub(r"\\\1", one_line(text)).replace("\\<", "&lt;").replace("\\&", "&amp;")


def summary_markdown(run: Run) -> str:
    """The summary of a run: verdict, counts, what fails first, then a line for each scene."""
    lines = [f"# {_sign(run)} {escaped(run.verdict.sentence)}", ""]
    left = not_checked(run.results)
    lines += [f"**Not checked:** {escaped(left)}.", ""] if left else []
    lines += [f"- {escaped(remark)}" for remark in run.remarks]
    lines += [""] if run.remarks else []
    lines += _counts(run)
    lines += _failing(run)
    lines += _convictions(run)
    lines += _silent(run)
    lines += _scenes(run)
    lines += _gaps(run)
    lines.append(
        "The pictures, every tolerance with its derivation, and the provenance are in "
        "`report.html` beside this file; the numbers are in `results.json`."
    )
    return "\n".join(lines) + "\n"


def _sign(run: Run) -> str:
    return "✅" if run.exit_status == 0 else "❌"


def _counts(run: Run) -> list[str]:
    found = counts(run.results)
    return [
        f"{count(len(run.results), 'scene')} × {count(len(run.references), 'reference')}, "
        f"{count(sum(found.values()), 'check')} in {run.seconds:.0f} s.",
        "",
        "| " + " | ".join(found) + " |",
        "|" + "---:|" * len(found),
        "| " + " | ".join(str(n) for n in found.values()) + " |",
        "",
    ]


def _failing(run: Run) -> list[str]:
    cells = list(failing(run.results))
    if not cells:
        return []
    lines = ["## What fails", ""]
    lines += ["| scene | reference | quantity | | worst pixel |", "|---|---|---|---|---|"]
    for cell in cells[:MOST_ROWS]:
        check = cell.check
        what = f"{icon(check)} {figure(check)}"
        detail = worst_in_words(check) if check.wrong else check.reason
        lines.append(_row(*cell.name, what, detail))
    if len(cells) > MOST_ROWS:
        lines += ["", f"… and {len(cells) - MOST_ROWS} more."]
    lines.append("")
    lines += [
        f"- {escaped(f'{result.scene.name}: {answer.reference} {words}')}"
        for result, answer, words in diagnosed(run.results)
    ][:MOST_ROWS]
    if any(is_consequence(cell.check) for cell in cells):
        lines += ["", "↳ every wrong pixel was wrong at an earlier stage already."]
    return [*lines, ""]


def _convictions(run: Run) -> list[str]:
    lines = [
        _row(result.scene.name, judgement_in_words(result.judgement))
        for result in convicted(run.results)
        if result.judgement is not None
    ]
    head = ["## Against exact arithmetic", "", "| scene | the judge |", "|---|---|"]
    return [*head, *lines, ""] if lines else []


def _silent(run: Run) -> list[str]:
    groups = silent(run.results)
    if not groups:
        return []
    lines = ["## References without an answer", ""]
    lines += ["| reference | | scenes | reason |", "|---|---|---|---|"]
    for group in groups:
        what = f"{ICONS[group.state]} {group.state}"
        names = ", ".join(group.scenes[:MOST_NAMES])
        if len(group.scenes) > MOST_NAMES:
            names += f" and {len(group.scenes) - MOST_NAMES} more"
        lines.append(_row(group.reference, what, names, group.reason))
    return [*lines, ""]


def _scenes(run: Run) -> list[str]:
    if not run.results:
        return []
    lines = ["## Scenes", "", "| scene | " + " | ".join(map(escaped, run.references)) + " |"]
    lines.append("|---|" + "---|" * len(run.references))
    for result in run.results:
        lines.append(_row(result.scene.name, *(_answer(a) for a in result.references)))
    return [*lines, ""]


def _answer(answer: ReferenceResult) -> str:
    return f"{ICONS[answer_state(answer)]} {answer_in_words(answer)}"


def _gaps(run: Run) -> list[str]:
    """Scenes that nobody compared, and what each reference does not give, with the reasons."""
    scenes, found = not_compared(run.results), gaps(run.results)
    lines = ["## Not compared", ""] if scenes or found else []
    lines += [f"- {escaped(line)}" for line in scenes] + ([""] if scenes else [])
    if found:
        lines += ["| reference | what | checks | reason |", "|---|---|---:|---|"]
        lines += [_row(g.reference, gap_in_words(g), str(g.checks), g.reason) for g in found]
        lines.append("")
    return lines


def _row(*cells: str) -> str:
    return "| " + " | ".join(map(escaped, cells)) + " |"
