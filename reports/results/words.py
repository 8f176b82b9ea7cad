"""How results are put into words and numbers: one place for every report."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from minirt.quantities import QUANTITIES
from reference.compare.check import Check, State
from reference.exact import Judgement, Opinion

#: Every state a cell can have, worst first.
STATES: tuple[State, ...] = (
    "failed", "crashed", "timed out", "missing", "known", "passed", "not supported", "not given",
)  # fmt: skip

ICONS: dict[State, str] = {
    "failed": "✗", "crashed": "!", "timed out": "!", "missing": "!",
    "known": "≈", "passed": "✓", "not supported": "–", "not given": "–",
}  # fmt: skip

#: The lecture's rules, and the departures from its letter, in a few words each, for tables.
RULE_NAMES: dict[str, str] = {
    "S1": "the viewing frame P0, u, v, n and the virtual screen n = ν",
    "S2": "pixel centres, half a pixel in; row j = 0 at the bottom",
    "S3": "from viewing to modelling coordinates",
    "S4": "a ray through each pixel; the first object hit",
    "S5": "r(t) = P0 + t·d with t = 1 at the screen; order in t",
    "S6": "RT(P0, d, t0, t1): ∅ or the first hit in [t0, t1]",
    "S7": "the colour of a ray",
    "S8": "sphere: the smallest positive root",
    "S9": "triangle: t, β, γ; its three cases",
    "S10": "a polygon's plane",
    "S11": "convex polygon: a fan of m − 2 triangles",
    "S12": "shadow: RT(M, −l, ε, ∞)",
    "S13": "illumination: ambient + diffuse + specular",
    "S14": "reflected direction ρ",
    "S15": "Snell's law",
    "S16": "refracted direction ϱ",
    "E1": "S16 with s turned along the ray that goes on",
    "E2": "total internal reflection",
    "S17": "the three exercises",
    "E3": "t ∈ [t0, t1]; only the weights lie in [0, 1]",
    "E4": "ε is the third argument of RT",
    "E5": "M is the surface point, not the pixel's centre",
    "E6": "(−δ·s)s is the projection of −δ",
    "E7": "p is the normal of the polygon's plane",
    "E8": "sphere: the same roots, without the lost digits",
}

#: Characters that XML forbids or a terminal obeys, and lone surrogates; not line ends and tabs.
_UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]")
#: Marks that reorder the text around them.
_DIRECTIONS = re.compile("[\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def plain(text: str) -> str:
    """Text that a page, an XML file and a terminal can all show: control characters become �."""
    return _DIRECTIONS.sub("�", _UNPRINTABLE.sub("�", text.replace("\r\n", "\n")))


def one_line(text: str, longest: int = 300) -> str:
    """Plain text on one line, cut with an ellipsis."""
    line = " ".join(plain(text).split())
    return line if len(line) <= longest else line[: longest - 1] + "…"


def number(value: float) -> str:
    """A number for people, three significant digits: 0.123, 1.5, 12, 3.2e-07, ∞, none."""
    if math.isnan(value):
        return "none"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return f"{value:.3g}"


def times(ratio: float) -> str:
    """An error over its tolerance: 0×, <0.01×, 0.42×, <1×, >1×, 1.4×, 14×, 3e+05×, ∞×."""
    if ratio == 0 or math.isinf(ratio):
        return f"{'0' if ratio == 0 else '∞'}×"
    for low, high, words in ((0.0, 0.005, "<0.01×"), (0.995, 1.0, "<1×"), (1.0, 1.005, ">1×")):
        if low < ratio < high:
            return words
    if ratio < 1e5:
        return f"{ratio:.{2 if ratio < 1 else 1 if ratio < 9.95 else 0}f}×"
    return f"{ratio:.0e}×"


def share(part: int, whole: int) -> str:
    """A share in per cent, never rounded up to 100 %."""
    if whole == 0:
        return "none"
    percent = 100 * part / whole
    return "100 %" if part == whole else f"{min(percent, 99.99):.2f} %"


def count(n: int, singular: str, plural: str = "") -> str:
    """A number with its noun: 1 scene, 2 scenes."""
    return f"{n} {singular if n == 1 else plural or singular + 's'}"


def listed(names: Sequence[str]) -> str:
    """Names in a sentence: a, b and c."""
    *most, last = names
    return f"{', '.join(most)} and {last}" if most else last


def values(quantity: str, components: Sequence[float]) -> str:
    """A pixel's value with enough digits to see a difference: 2, (0.1, 0.25), none."""
    if QUANTITIES[quantity].discrete:
        return " ".join("none" if math.isnan(v) else f"{v:.0f}" for v in components)
    words = [number(v) if not math.isfinite(v) else f"{v:.9g}" for v in components]
    return words[0] if len(words) == 1 else f"({', '.join(words)})"


def is_consequence(check: Check) -> bool:
    """Whether all wrong pixels of a check were wrong at an earlier stage already."""
    return check.state == "failed" and check.wrong > 0 and check.first_wrong == 0


def icon(check: Check) -> str:
    """The sign of a check's state; ↳ where it fails only because an earlier stage did."""
    return "↳" if is_consequence(check) else ICONS[check.state]


def figure(check: Check) -> str:
    """What a cell shows beside its icon: 0.42×, equal, 7 px, 14×, not supported."""
    if check.state == "passed":
        return _passed_figure(check)
    if check.state == "failed":
        return _failed_figure(check)
    if check.state == "known":
        return f"known: {_failed_figure(check)}"
    return check.state


def _passed_figure(check: Check) -> str:
    if check.compared == 0:
        return "none"
    if check.quantity in QUANTITIES and QUANTITIES[check.quantity].discrete:
        return "equal"
    return times(check.ratio or 0.0)


def _failed_figure(check: Check) -> str:
    if check.wrong:
        wrong = f"{check.wrong} px"
        finite = check.ratio is not None and math.isfinite(check.ratio)
        return f"{wrong}, {times(check.ratio or 0.0)}" if finite else wrong
    if check.pixels == 0:
        return "unusable"
    if check.certain >= check.floor * check.pixels:
        if check.ssim is not None and check.ssim < (check.ssim_floor or 0.0):
            return f"SSIM {check.ssim:.3f}"
        if check.flip is not None:
            return f"FLIP {check.flip:.3f}"
    return f"{share(check.certain, check.pixels)} certain"


def worst_in_words(check: Check) -> str:
    """The worst pixel with both values; empty where no pixel differs."""
    worst = check.worst
    if worst is None or check.ratio is None or check.ratio == 0:
        return ""
    ours, theirs = (values(check.quantity, v) for v in (worst.ours, worst.theirs))
    text = f"({worst.column}, {worst.row}): ours {ours}, theirs {theirs}"
    if math.isfinite(check.ratio) and not QUANTITIES[check.quantity].discrete:
        text += f"; error {number(worst.error)}, tolerance {number(worst.tolerance)}"
    return text


def judgement_in_words(judgement: Judgement) -> str:
    """The judgement in a sentence."""
    decided = sum(each.decided for each in judgement.counts)
    if judgement.convictions:
        first = judgement.convictions[0]
        return (
            f"contradicts minirt: {_answers(len(judgement.convictions))} of {decided} wrong, "
            f"first {opinion_in_words(first)}"
        )
    judged = sum(each.judged for each in judgement.counts)
    worst = judgement.worst.ulps if judgement.worst is not None else None
    error = "" if worst is None else f", t within {number(worst or 0.0)} ulp of its condition"
    return (
        f"confirms minirt: {decided} of {_answers(judged)} at "
        f"{count(judgement.pixels, 'pixel')} are certain and right{error}"
    )


def all_in_words(judgements: Sequence[Judgement]) -> str:
    """The judgements of a run that contradict nothing, in a clause; empty where there is none."""
    decided = sum(each.decided for judgement in judgements for each in judgement.counts)
    return f"exact arithmetic confirms {_answers(decided)}" if decided else ""


def opinion_in_words(opinion: Opinion) -> str:
    """Quantity, pixel and both values."""
    ours, exact = (values(opinion.quantity, list(v)) for v in (opinion.ours, opinion.exact))
    place = f"{opinion.quantity} at ({opinion.column}, {opinion.row})"
    return f"{place}: ours {ours}, exact {exact}"


def _answers(n: int) -> str:
    return f"{n:,} answer" + ("" if n == 1 else "s")
