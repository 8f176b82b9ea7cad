"""The doctor's findings for people."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from reports.console import answers
from reports.doctor import Examination, Package, Trial


def print_examination(found: Examination) -> None:
    """Print what is here and what is missing, with the command that brings it."""
    console = answers()
    _print(console, "machine", [("", name, value) for name, value in found.machine.items()])
    _print(console, "packages", [_package(package) for package in found.packages])
    _print(console, "references, each tried", [_trial(trial) for trial in found.references])
    verdict = "all that is needed is here" if found.healthy else "something required is missing"
    console.print()
    console.print(verdict, style="green" if found.healthy else "bold red")


def _print(console: Console, title: str, rows: list[tuple[str, str, str]]) -> None:
    table = Table(box=None, show_header=False, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column(no_wrap=True, width=1)
    table.add_column(no_wrap=True, min_width=14)
    table.add_column(ratio=1, overflow="fold")
    for mark, name, text in rows:
        table.add_row(Text(mark, "green" if mark == "✓" else "red"), name, Text(text))
    if title != "machine":
        console.print()
    console.print(title, style="bold")
    console.print(table)


def _package(package: Package) -> tuple[str, str, str]:
    if package.version:
        return "✓", package.name, package.version
    return ("✗" if package.needed else "–"), package.name, f"missing: {package.brings}"


def _trial(trial: Trial) -> tuple[str, str, str]:
    if trial.state == "works":
        return "✓", trial.reference, f"{trial.program}, {trial.seconds:.1f} s"
    text = f"{trial.state}: {trial.reason}"
    last = trial.output.strip().splitlines()[-3:]
    mark = "–" if trial.state == "missing" and not trial.required else "✗"
    return mark, trial.reference, "\n".join([text, *last])
