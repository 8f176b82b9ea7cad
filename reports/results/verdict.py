"""What a run's results amount to: a verdict in one sentence, counts, and the exit status."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from reference.compare.check import COMPARED, UNANSWERED
from reference.verify.results import ReferenceResult, SceneResult
from reports.results.cells import worst_check
from reports.results.coverage import why_not
from reports.results.findings import Findings
from reports.results.words import all_in_words, count, listed, one_line, share, times

Outcome = Literal["passed", "failed", "incomplete", "empty"]


@dataclass(frozen=True)
class Verdict:
    """How a run ended.

    Attributes
    ----------
    outcome : str
        passed; failed (a check failed); incomplete (a reference that should have answered did
        not, or nothing was compared); empty (no scene).
    exit_status : int
        0 passed, 1 failed, 2 empty, 3 incomplete. A failed check outweighs a missing answer.
    sentence : str
        For people; begins with PASS, FAIL or INCOMPLETE.
    troubles : tuple of str
        Each thing that keeps the run from being complete, in a sentence.
    """

    outcome: Outcome
    exit_status: int
    sentence: str
    troubles: tuple[str, ...]


def decide(findings: Findings, references: Sequence[str], required: Iterable[str]) -> Verdict:
    """The verdict on a run.

    Parameters
    ----------
    findings : Findings
        Of the run.
    references : sequence of str
        Names of those that were chosen.
    required : iterable of str
        Names of those without whose answer the run is incomplete.
    """
    results = findings.results
    if not results:
        sentence = "FAIL: no scene was chosen, so nothing was compared"
        return Verdict("empty", 2, sentence, ("no scene was chosen",))
    troubles = tuple(_troubles(results, references, set(required)))
    also = "".join(f"; {trouble}" for trouble in troubles)
    if findings.scene_states["failed"]:
        return Verdict("failed", 1, _failure(findings) + also, troubles)
    if troubles:
        return Verdict("incomplete", 3, "INCOMPLETE: " + "; ".join(troubles), troubles)
    return Verdict("passed", 0, _success(findings), ())


def _troubles(
    results: Sequence[SceneResult], references: Sequence[str], required: set[str]
) -> Iterator[str]:
    for name in sorted(required - set(references)):
        yield f"{name} is required and was not chosen"
    answered, without_answer = False, []
    for name in references:
        answers = [a for result in results for a in result.references if a.reference == name]
        compared = any(check.state in COMPARED for a in answers for check in a.checks)
        answered |= compared
        troubled = {
            state: [a for a in answers if any(c.state == state for c in a.checks)]
            for state in UNANSWERED
        }
        for state in ("crashed", "timed out"):
            if troubled[state]:
                yield f"{name} {state} on {_of(len(troubled[state]), len(results))}"
        if name in required and troubled["missing"]:
            yield f"{name} is missing ({one_line(troubled['missing'][0].checks[0].reason, 160)})"
        elif name in required and not compared and not any(troubled.values()):
            without_answer.append(name)
        elif name in required and (number := sum(map(_gave_nothing, answers))):
            yield f"{name} gave nothing on {_of(number, len(results))}"
    if not answered:
        yield "nothing was compared: " + _reasons(results)
    else:
        yield from (f"{name} compared nothing" for name in without_answer)


def _gave_nothing(answer: ReferenceResult) -> bool:
    """Whether it could have answered and did not; not where it cannot represent the scene."""
    states = {check.state for check in answer.checks}
    return "not given" in states and states <= {"not given", "not supported"}


def _reasons(results: Sequence[SceneResult]) -> str:
    """Why no reference compared anything on any scene."""
    reasons = list(dict.fromkeys(why_not(result) for result in results))
    more = f"; and {len(reasons) - 1} more" if len(reasons) > 1 else ""
    return reasons[0] + more


def _of(some: int, all_: int) -> str:
    return f"{some} of {count(all_, 'scene')}"


def _failure(findings: Findings) -> str:
    scenes, stage = len(findings.scenes), findings.first_wrong_stage
    whys = [f"first wrong stage: {stage}"] if stage else []
    if findings.contradicted:
        where = _of(len(findings.contradicted), scenes)
        whys.append(f"exact arithmetic contradicts minirt on {where}")
    whys += [findings.likeliest] if findings.likeliest else []
    why = "; ".join(whys) or _reason(findings)
    return f"FAIL: {_of(findings.scene_states['failed'], scenes)}; {why}"


def _reason(findings: Findings) -> str:
    """Why checks failed in which no pixel is wrong: the first reason, and how many others."""
    failed = [check for check in findings.every_check if check.state == "failed"]
    first, *others = dict.fromkeys(one_line(check.reason, 200) for check in failed)
    head = "no pixel is wrong, but " if any(check.pixels for check in failed) else ""
    return head + first + (f"; and {len(others)} more" if others else "")


def _success(findings: Findings) -> str:
    scenes, known = findings.scene_states, findings.checks["known"]
    answers = [answer for scene in findings.scenes for answer in scene.answers]
    names = [a.answer.reference for a in answers if a.count("passed") or a.count("known")]
    head = f"PASS, with {count(known, 'known failure')}" if known else "PASS"
    agree = "agrees" if scenes["passed"] == 1 else "agree"
    with_whom = listed([*dict.fromkeys(names)])
    text = f"{head}: {count(scenes['passed'], 'scene')} {agree} with {with_whom}"
    checks = [check for check in findings.every_check if check.state == "passed"]
    certain = share(sum(c.certain for c in checks), sum(c.pixels for c in checks))
    text += f"; no {'other ' if known else ''}wrong pixel among the {certain} that are certain"
    worst = worst_check(checks)
    if worst is not None and worst.ratio:
        text += f", largest error {times(worst.ratio or 0.0)} its tolerance ({worst.quantity})"
    exact = all_in_words([r.judgement for r in findings.results if r.judgement is not None])
    text += f"; {exact}" if exact else ""
    if scenes["not compared"]:
        text += f"; {count(scenes['not compared'], 'scene')} not compared"
    return text
