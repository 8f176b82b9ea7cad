"""What the page shows of one check, in words; and the matrix of all of them."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import groupby

from minirt.quantities import QUANTITIES, STAGES
from reference.compare.check import COMPARED, UNANSWERED, Check
from reference.verify.results import ReferenceResult, SceneResult
from reports.results.findings import SceneFindings
from reports.results.words import count, figure, icon, is_consequence, share, worst_in_words

#: Quantities in causal order, so that the first wrong one of a row is the one to look at.
CAUSAL: tuple[str, ...] = tuple(sorted(QUANTITIES, key=lambda n: STAGES.index(QUANTITIES[n].stage)))


#: Figures as short as twenty columns need them.
_SHORT = {"equal": "="}


@dataclass(frozen=True)
class MatrixCell:
    """One cell of the matrix.

    Attributes
    ----------
    kind : str
        CSS class: passed, failed, follows, silent, empty or none.
    icon, text, state : str
        What it shows, and its state in a word for who cannot see it.
    title : str
        Why, or the worst pixel.
    bar : float
        Length of its bar, 0…1: the worst error over the tolerance.
    span : int
        Columns that it covers.
    href : str
        Where its pictures are; empty where it has none.
    arrow : str
        ▲ worse or ▼ better than in the previous run; empty where neither is known.
    """

    kind: str
    icon: str
    text: str
    state: str
    title: str
    bar: float = 0.0
    span: int = 1
    href: str = ""
    arrow: str = ""


@dataclass(frozen=True)
class MatrixRow:
    """One reference on one scene."""

    reference: str
    cells: tuple[MatrixCell, ...]


def in_causal_order(names: Collection[str]) -> list[str]:
    """Quantities in causal order."""
    return [name for name in CAUSAL if name in names]


def stage_columns(names: Sequence[str]) -> list[tuple[str, int, str]]:
    """Stages with the number of columns of each, and their names short enough for one column."""
    counted = [(s, len(list(g))) for s, g in groupby(names, lambda n: QUANTITIES[n].stage)]
    return [(s, n, s if n > 1 or len(s) < 7 else f"{s[:4]}.") for s, n in counted]


def anchor(number: int, result: SceneResult) -> str:
    """A name for a scene's section that is unique, short and safe in a link."""
    slug = re.sub(r"[^a-z0-9]+", "-", result.scene.name.lower()).strip("-")[:40]
    return f"scene-{number}-{slug}".rstrip("-")


def matrix_row(answer: ReferenceResult, names: Sequence[str], section: str) -> MatrixRow:
    """The cells of one reference on one scene, in the order of `names`."""
    checks = {check.quantity: check for check in answer.checks}
    only = {(check.state, check.reason) for check in answer.checks}
    first = answer.checks[0]
    if len(only) == 1 and first.state not in COMPARED:
        cell = _cell(first, "")
        return MatrixRow(answer.reference, (_across(cell, first, len(names)),))
    return MatrixRow(answer.reference, tuple(_cell(checks[name], section) for name in names))


def _across(cell: MatrixCell, check: Check, span: int) -> MatrixCell:
    text = f"{check.state}: {check.reason}" if check.reason else check.state
    return MatrixCell(cell.kind, cell.icon, text, "", "", span=span)


def _cell(check: Check, section: str) -> MatrixCell:
    bar = min(1.0, check.ratio or 0.0)
    href = f"#{section}-{check.quantity}" if check.state == "failed" else ""
    title = f"{check.quantity}: {sentence(check)}"
    text = "" if kind(check) in ("none", "known") else _SHORT.get(figure(check), figure(check))
    return MatrixCell(kind(check), icon(check), text, check.state, title, bar, 1, href)


def kind(check: Check) -> str:
    """The CSS class of a check."""
    if is_consequence(check):
        return "follows"
    if check.state in UNANSWERED:
        return "silent"
    if check.state == "passed":
        return "empty" if check.compared == 0 else "passed"
    return check.state if check.state in ("failed", "known") else "none"


def sentence(check: Check) -> str:
    """A check in a sentence: why it is not passed, or how far it is from failing."""
    if check.state not in COMPARED:
        return f"{check.state}: {check.reason}"
    if check.compared == 0 and check.state == "passed":
        return "no pixel has a value here, and none was given"
    worst = worst_in_words(check)
    head = check.reason or f"{check.state}, {share(check.certain, check.pixels)} certain"
    return f"{head}; worst pixel {worst}" if worst else head


def facts(check: Check) -> list[str]:
    """What stands below a check's pictures, line by line."""
    lines = [check.reason] if check.reason else []
    if check.wrong and not is_consequence(check) and check.first_wrong < check.wrong:
        lines.append(f"{check.first_wrong} of them are wrong here first")
    if check.pixels:
        lines.append(
            f"{share(check.certain, check.pixels)} of {check.pixels:,} pixels certain, "
            f"at least {100 * check.floor:.4g} % asked for; {check.compared:,} with a value"
        )
    worst = worst_in_words(check)
    if worst and check.compared:
        lines.append(f"worst pixel {worst}")
    if check.ssim is not None and check.ssim_floor is not None:
        lines.append(_similarity(check, check.ssim, check.ssim_floor))
    if check.flip is not None and check.flip_ceiling is not None:
        lines.append(f"FLIP {check.flip:.5f}, ceiling {check.flip_ceiling:g}")
    return lines


def _similarity(check: Check, ssim: float, floor: float) -> str:
    text = f"SSIM {ssim if ssim == 1 else min(ssim, 0.99999):.5f}, floor {floor:g}"
    if check.wrong and ssim >= floor:
        text += f": it alone would have let {count(check.wrong, 'wrong pixel')} pass"
    if not check.wrong and ssim < floor and check.compared:
        text += ": no certain pixel is wrong; what differs is uncertain, and more of it than noise"
    return text


def scene_headline(scene: SceneFindings) -> str:
    """How a scene did, in a few words."""
    failed, passed, known = (
        sum(answer.count(state) for answer in scene.answers)
        for state in ("failed", "passed", "known")
    )
    stage = f"; first wrong stage: {scene.first_wrong_stage}" if scene.first_wrong_stage else ""
    if failed:
        return f"{failed} of {count(failed + passed, 'check')} failed{stage}"
    tail = f", {count(known, 'known failure')}" if known else ""
    head = f"{count(passed, 'check')} passed{tail}" if scene.state == "passed" else scene.state
    return head + stage
