"""The doctor's findings for people."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from reports.doctor import Examination, Package, Trial
from reports.results.words import one_line
from reports.terminal.console import stdout_console

#: A mark, a name and what is to be said of it.
Row = tuple[str, str, str]


def print_examination(found: Examination) -> None:
    """Print what is here and what is missing, with the command that brings it."""
    console = stdout_console()
    _print(console, "machine", [(" ", name, value) for name, value in found.machine.items()])
    _print(console, "packages", [_package(package) for package in found.packages])
    _print(console, "references, each tried", [_trial(trial) for trial in found.references])
    if not found.healthy:
        console.print("Something that is required is missing.", style="bold dark_orange")
    elif not any(trial.state == "works" for trial in found.references):
        console.print("minirt renders, but verify has no reference to compare with.")
    else:
        console.print("All that is needed is here.", style="bold blue")


def _print(console: Console, title: str, rows: list[Row]) -> None:
    console.print(title, style="bold")
    width = max(len(name) for _, name, _ in rows)
    for mark, name, text in rows:
        style = "blue" if mark == "✓" else "bold dark_orange"
        lines = text.replace("\n", "\n" + " " * (width + 6))
        line = Text.assemble("  ", (mark, style), f" {name:<{width}}  ", lines)
        console.print(line, soft_wrap=True)
    console.print()


def _package(package: Package) -> Row:
    if package.version:
        return "✓", package.name, package.version
    return ("✗" if package.needed else "–"), package.name, f"missing: {package.brings}"


def _trial(trial: Trial) -> Row:
    if trial.state == "works":
        return "✓", trial.reference, f"{trial.program}, {trial.seconds:.1f} s"
    text = one_line(f"{trial.state}: {trial.reason}", 1000)
    last = [one_line(line) for line in trial.output.strip().splitlines()[-3:]]
    mark = "–" if trial.state == "missing" and not trial.required else "✗"
    return mark, trial.reference, "\n".join([text, *last])
