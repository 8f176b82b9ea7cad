"""A pixel's explanation for people: a step a paragraph, its numbers aligned below."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping

from rich.console import Console
from rich.text import Text

from minirt.explain.pixel import Explanation
from minirt.explain.steps import Step, Value
from reports.results.words import one_line
from reports.terminal.console import console_on, indented, stdout_console

#: Characters before a step's sentence; its numbers are indented by two more.
_INDENT = 5
#: Digits of a vector's components: three of them fit a line of 80 beside their name.
_DIGITS = 12


def print_explanation(explanation: Explanation) -> None:
    """Print every step on standard output."""
    _print(explanation, stdout_console())


def explanation_text(explanation: Explanation) -> str:
    """Every step as plain text, as it is printed into a file."""
    stream = io.StringIO()
    _print(explanation, console_on(stream))
    return stream.getvalue()


def _print(explanation: Explanation, console: Console) -> None:
    head = Text(one_line(explanation.scene), "bold")
    place = f", column {explanation.column} from the left, row {explanation.row} from the top"
    console.print(head.append(place, "not bold"))
    for step in explanation.steps:
        console.print()
        _print_step(step, console)


def spelled(value: Value) -> str:
    """A value for people: a number with every digit it has, a vector with twelve a component."""
    if isinstance(value, tuple):
        return " ".join(f"{_number(x, _DIGITS):<{_DIGITS + 7}}" for x in value).rstrip()
    if isinstance(value, bool):
        return " yes" if value else " no"
    if isinstance(value, int | float):
        return _number(value)
    return f" {one_line(value or 'none')}"


def _print_step(step: Step, console: Console) -> None:
    console.print(
        Text.assemble((f"{step.rule:<{_INDENT}}", "bold blue"), (one_line(step.title), "bold"))
    )
    console.print(indented(one_line(step.sentence, 1000), _INDENT, console))
    console.print(_values(step.values), no_wrap=True, overflow="ignore", crop=False)


def _values(values: Mapping[str, Value]) -> Text:
    width = max(map(len, values))
    lines = [
        Text.assemble(f"{'':{_INDENT + 2}}", (f"{name:<{width}} ", "dim"), spelled(value))
        for name, value in values.items()
    ]
    return Text("\n").join(lines)


def _number(value: float, digits: int = 0) -> str:
    """With a column for the sign; all digits that distinguish it from its neighbours, or fewer."""
    if math.isnan(value):
        return " none"
    if math.isinf(value):
        return " ∞" if value > 0 else "-∞"
    text = f"{value:.{digits}g}" if digits else repr(value)
    return text if text.startswith("-") else f" {text}"
