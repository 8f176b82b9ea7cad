"""`summary.md`: the verdict as Markdown, for the summary of a CI step."""

from __future__ import annotations

import re

from reports.results.coverage import gap_in_words
from reports.results.findings import AnswerFindings, answer_in_words
from reports.results.record import Run
from reports.results.words import (
    ICONS,
    count,
    figure,
    icon,
    is_consequence,
    judgement_in_words,
    one_line,
    worst_in_words,
)

#: Rows of failing checks that a summary lists; the report has them all.
MOST_ROWS = 50
#: Scenes that it names of those on which a reference gave no answer for the same reason.
MOST_NAMES = 8

_SPECIAL = re.compile(r"([\\`*_\[\]#|~<>&$@])")


def escaped(text: str) -> str:
    """Text on one line that Markdown shows as it is, without markup."""
    return _SPECIAL.sub(r"\\\1", one_line(text)).replace("\\<", "&lt;").replace("\\&", "&amp;")


def summary_markdown(run: Run) -> str:
    """The summary of a run: verdict, counts, what fails first, then a line for each scene."""
    lines = [f"# {_sign(run)} {escaped(run.verdict.sentence)}", ""]
    left = run.findings.not_checked
    lines += [f"**Not checked:** {escaped(left)}.", ""] if left else []
    lines += [f"- {escaped(remark)}" for remark in run.remarks]
    lines += [""] if run.remarks else []
    lines += _counts(run)
    lines += _failing(run)
    lines += _contradictions(run)
    lines += _unanswered(run)
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
    found = run.findings.checks
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
    cells = run.findings.failing
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
        f"- {escaped(f'{each.scene}: {each.reference} {each.words}')}"
        for each in run.findings.diagnoses[:MOST_ROWS]
    ]
    if any(is_consequence(cell.check) for cell in cells):
        lines += ["", "↳ every wrong pixel was wrong at an earlier stage already."]
    return [*lines, ""]


def _contradictions(run: Run) -> list[str]:
    lines = [
        _row(result.scene.name, judgement_in_words(result.judgement))
        for result in run.findings.contradicted
        if result.judgement is not None
    ]
    head = ["## Against exact arithmetic", "", "| scene | result |", "|---|---|"]
    return [*head, *lines, ""] if lines else []


def _unanswered(run: Run) -> list[str]:
    groups = run.findings.unanswered
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
    for scene in run.findings.scenes:
        lines.append(_row(scene.result.scene.name, *map(_answer, scene.answers)))
    return [*lines, ""]


def _answer(found: AnswerFindings) -> str:
    return f"{ICONS[found.state]} {answer_in_words(found)}"


def _gaps(run: Run) -> list[str]:
    """Scenes that no reference compared, what each reference does not give, and why."""
    scenes, found = run.findings.not_compared, run.findings.gaps
    lines = ["## Not compared", ""] if scenes or found else []
    lines += [f"- {escaped(line)}" for line in scenes] + ([""] if scenes else [])
    if found:
        lines += ["| reference | what | checks | reason |", "|---|---|---:|---|"]
        lines += [_row(g.reference, gap_in_words(g), str(g.checks), g.reason) for g in found]
        lines.append("")
    return lines


def _row(*cells: str) -> str:
    return "| " + " | ".join(map(escaped, cells)) + " |"
