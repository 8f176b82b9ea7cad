"""A student's results in sentences, the same for the page, for Markdown and for Gradescope."""

from __future__ import annotations

from minirt.quantities import QUANTITIES
from reports.grade.judging.explained import FailureExplanation
from reports.grade.judging.judge import MarkSheet
from reports.grade.judging.score import PartMarks
from reports.grade.record import Student
from reports.results.words import RULE_NAMES, count, one_line, plain, share


def points(value: float) -> str:
    """Points without zeros that say nothing: 7.5, 10."""
    return f"{value:.2f}".rstrip("0").rstrip(".")


def headline(student: Student) -> str:
    """What a student earns, and the first thing to look at."""
    marks = student.marks
    text = f"{points(marks.points)} of {points(marks.of)} points"
    if student.message:
        return f"{text}: nothing could be graded"
    if student.mistake:
        return f"{text}; it {student.mistake}"
    if student.stage:
        return f"{text}; the first wrong stage is {student.stage}"
    missing = sum(result.state != "judged" for result in student.public)
    return f"{text}; no frame of {count(missing, 'scene')}" if missing else text


def missing_in_words(student: Student) -> list[str]:
    """Of each public scene without a frame why, and a program's last words."""
    missing = [result for result in student.public if result.state != "judged"]
    return [
        "\n".join(filter(None, [f"{r.scene}: {scene_in_words(r)}", plain(r.output).strip()]))
        for r in missing
    ]


def no_frames(student: Student) -> str:
    """How many scenes, hidden ones too, have no frame, and why the first has none; else empty."""
    missing = [result for result in student.results if result.state != "judged"]
    if not missing:
        return ""
    return f"no frame of {count(len(missing), 'scene')}: {one_line(missing[0].reason)}"


def about(student: Student) -> str:
    """What staff may talk about with a student, in a clause or two; empty where nothing is."""
    if student.message:
        return one_line(student.message)
    told = [student.stage, f"it {student.mistake}" if student.mistake else "", no_frames(student)]
    return "; ".join(filter(None, told))


def lateness(student: Student) -> str:
    """What lateness costs; empty where it costs nothing."""
    marks = student.marks
    if not marks.late_days:
        return ""
    return (
        f"{count(marks.late_days, 'begun day')} late: {points(marks.penalty)} of "
        f"{points(marks.earned)} points"
    )


def part_in_words(part: PartMarks) -> str:
    """How a part came to its points."""
    text = f"full marks on {part.full} of {count(part.scenes, 'scene')}"
    if part.weakest:
        text += f", least on {part.weakest}"
    if part.hidden_earned is not None:
        text += (
            f"; {points(part.hidden_earned)} of {points(part.hidden_of)} points come from hidden "
        )
        text += "scenes, which only programs render"
    return text


def scene_in_words(result: MarkSheet) -> str:
    """What came of one scene, in a clause."""
    if result.state != "judged":
        return f"{result.state}: {one_line(result.reason, 400)}"
    if result.reason:
        return result.reason
    if result.wrong:
        return f"{share(result.wrong, result.certain)} of the pixels wrong, from {result.stage} on"
    if not any(given for _, _, given, _ in result.tallies.values()):
        return "nothing given that this assignment asks for"
    lacking = any(given < asked for _, _, given, asked in result.tallies.values())
    return "all pixels right, not every quantity given" if lacking else "all pixels right"


def all_right(result: MarkSheet) -> bool:
    """Whether a scene has nothing wrong and nothing missing."""
    complete = all(given == asked for _, _, given, asked in result.tallies.values())
    return result.state == "judged" and not (result.wrong or result.reason) and complete


def mistake_of(closer: FailureExplanation) -> str:
    """What explains a failing scene, in a sentence."""
    return f"It {closer.mistake}." if closer.mistake else "None of the known mistakes explains it."


def explanation_in_words(closer: FailureExplanation) -> str:
    """The first wrong stage of a scene, and the rule to look at."""
    about = QUANTITIES[closer.quantity].about
    rule = f"rule {closer.rule}: {RULE_NAMES[closer.rule]}"
    first = f"The first wrong stage is {closer.stage}: {closer.quantity} ({about})."
    return f"{first} {mistake_of(closer)} The slide says, {rule}."


def message_of(student: Student) -> str:
    """Why nothing could be graded, on as many lines as it has."""
    return plain(student.message).strip()
