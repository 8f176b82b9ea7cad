"""One pixel by two: minirt's values, another implementation's, and what may lie between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from minirt.quantities import QUANTITIES, STAGES
from minirt.scene import Scene
from reference.diagnose.by_mutant import diagnose
from reference.source import Reference
from reference.verify.options import Callbacks, Options
from reference.verify.results import Evidence
from reference.verify.run import verify
from reports.results.json_model import spelled
from reports.results.words import RULE_NAMES, number, one_line, times, values


@dataclass(frozen=True)
class Row:
    """One quantity of the pixel.

    Attributes
    ----------
    quantity, stage : str
    ours, theirs : tuple of float
    error, tolerance, ratio : float
        The tolerance is 0 and the ratio 0 or +inf for discrete quantities; the ratio is NaN
        where the exact answer is not stable under the declared error: there nothing is judged.
    """

    quantity: str
    stage: str
    ours: tuple[float, ...]
    theirs: tuple[float, ...]
    error: float
    tolerance: float
    ratio: float

    @property
    def wrong(self) -> bool:
        """Whether the other's value is wrong."""
        return self.ratio > 1


@dataclass(frozen=True)
class SecondOpinion:
    """What another implementation has at a pixel.

    Attributes
    ----------
    name : str
    rows : tuple of Row
        In causal order; only what it gives.
    trouble : str
        Why there is nothing, where there is nothing; else empty.
    mistake : str
        What explains the whole picture's failure, in a clause; empty where nothing does.
    """

    name: str
    rows: tuple[Row, ...]
    trouble: str = ""
    mistake: str = ""

    @property
    def first(self) -> Row | None:
        """The first wrong quantity in causal order."""
        return next((row for row in self.rows if row.wrong), None)

    @property
    def sentence(self) -> str:
        """What is wrong, and why, in a sentence."""
        if self.trouble:
            return f"{self.name} has no frame of this scene: {one_line(self.trouble)}"
        row = self.first
        if row is None:
            open_ = sum(np.isnan(each.ratio) for each in self.rows)
            tail = f"; {open_} of them hang on less than its declared error" if open_ else ""
            return (
                f"{self.name} agrees here in all {len(self.rows)} quantities that it gives{tail}."
            )
        rule = QUANTITIES[row.quantity].rules[0]
        ours, theirs = (values(row.quantity, list(v)) for v in (row.ours, row.theirs))
        why = f" Over the whole picture it {self.mistake}." if self.mistake else ""
        return (
            f"The first wrong stage is {row.stage}: {row.quantity} is {ours}, {self.name} has "
            f"{theirs}. Look at rule {rule} ({RULE_NAMES[rule]}).{why}"
        )

    def to_dict(self) -> dict[str, object]:
        """As JSON data; a number that is not finite is 'inf', '-inf' or 'nan'."""
        rows = [
            {
                "quantity": row.quantity,
                "stage": row.stage,
                "ours": [spelled(x) for x in row.ours],
                "theirs": [spelled(x) for x in row.theirs],
                "error": spelled(row.error),
                "tolerance": spelled(row.tolerance),
                "ratio": spelled(row.ratio),
                "state": _state(row),
            }
            for row in self.rows
        ]
        return {"name": self.name, "sentence": self.sentence, "quantities": rows}


def second_opinion(
    scene: Scene, column: int, row: int, subject: Reference, timeout: float
) -> SecondOpinion:
    """Have another implementation render the scene, and look at one pixel.

    Parameters
    ----------
    scene : Scene
    column, row : int
        From the left, and from the TOP; inside the image.
    subject : Reference
    timeout : float
        Seconds for its rendering.
    """
    values_there: Callable[[Evidence], tuple[Row, ...]] = partial(rows_at, row, column)
    options = Options(timeout=timeout, jobs=1, callbacks=Callbacks(values_there, diagnose=diagnose))
    (result,) = verify([scene], [subject], options)
    (answer,) = result.references
    if answer.details is None:
        return SecondOpinion(subject.name, (), answer.checks[0].reason)
    named = [each.sentence for each in answer.diagnosis or ()]
    return SecondOpinion(subject.name, answer.details, mistake="".join(named[:1]))


def rows_at(row: int, column: int, evidence: Evidence) -> tuple[Row, ...]:
    """The values at a pixel, in causal order. A `MakeDetails` when partially applied."""
    names = sorted(evidence.comparison.ratio, key=lambda name: STAGES.index(QUANTITIES[name].stage))
    return tuple(_row(name, (row, column), evidence) for name in names)


def _row(name: str, pixel: tuple[int, int], evidence: Evidence) -> Row:
    quantity = QUANTITIES[name]
    ours, theirs = evidence.ours[name], evidence.theirs[name]
    tolerance = evidence.stability.tolerance.get(name)
    return Row(
        quantity=name,
        stage=quantity.stage,
        ours=tuple(np.atleast_1d(ours[pixel]).astype(float).tolist()),
        theirs=tuple(np.atleast_1d(theirs[pixel]).astype(float).tolist()),
        error=float(evidence.comparison.error[name][pixel]),
        tolerance=0.0 if tolerance is None else float(tolerance[pixel]),
        ratio=float(evidence.comparison.ratio[name][pixel]),
    )


def _state(row: Row) -> str:
    if np.isnan(row.ratio):
        return "uncertain"
    return "wrong" if row.wrong else "agrees"


def print_second_opinion(opinion: SecondOpinion, console: Console) -> None:
    """The table of both, and the sentence."""
    console.print()
    if opinion.rows:
        table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
        for title in ("quantity", "minirt", opinion.name):
            table.add_column(Text(one_line(title)), overflow="fold")
        for title in ("error", "tolerance", ""):
            table.add_column(title, justify="right", no_wrap=True)
        for row in opinion.rows:
            table.add_row(*_cells(row))
        console.print(table)
    style = "bold dark_orange" if opinion.trouble or opinion.first else "bold blue"
    console.print(Text(opinion.sentence, style), soft_wrap=True)


def _cells(row: Row) -> list[Text]:
    signs = {"agrees": ("✓", "blue"), "wrong": ("✗", "bold dark_orange"), "uncertain": ("?", "dim")}
    sign, style = signs[_state(row)]
    discrete = QUANTITIES[row.quantity].discrete
    ratio = "" if discrete or not np.isfinite(row.ratio) else f" {times(row.ratio)}"
    error = "" if discrete or not np.isfinite(row.error) else number(row.error)
    tolerance = "" if discrete else number(row.tolerance)
    both = (values(row.quantity, list(v)) for v in (row.ours, row.theirs))
    return [
        Text(row.quantity, style),
        *(Text(text, style if row.wrong else "") for text in both),
        Text(error), Text(tolerance), Text(sign + ratio, style),
    ]  # fmt: skip
