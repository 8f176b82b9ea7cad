"""What goes to which stream: answers to standard output, all else to standard error.

Colours and progress bars appear on a terminal only, and no colours where ``NO_COLOR`` is set.
A pipe whose reader has ended (``| head``) is no error.
"""

from __future__ import annotations

import json
import os
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TextIO

from reports.terminal.streams import discard_output

if TYPE_CHECKING:
    from rich.console import Console

#: Columns of an answer that goes into a file or a pipe.
_WIDTH = 100
#: A progress bar in one colour.
_PROGRESS_STYLES = {
    "bar.complete": "blue", "bar.finished": "blue", "bar.back": "dim",
    "progress.percentage": "none", "progress.elapsed": "dim",
}  # fmt: skip
#: Least width of a paragraph, on however narrow a terminal.
_NARROWEST = 20


def stdout_console() -> Console:
    """Where a command's answer goes that was not asked for as JSON."""
    return console_on(sys.stdout)


def stderr_console() -> Console:
    """Where progress, remarks and errors go."""
    return console_on(sys.stderr)


def print_lines(lines: Iterable[str], console: Console) -> None:
    """Print lines that the terminal wraps, whatever their length."""
    for line in lines:
        console.print(line, soft_wrap=True)


def print_json(document: Any) -> None:
    """Print one JSON document on standard output; it must hold no NaN and no infinity."""
    with _broken_pipe_ignored(sys.stdout):
        text = json.dumps(document, indent=2, allow_nan=False)
        sys.stdout.write(text + "\n")
        sys.stdout.flush()


@contextmanager
def progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on a terminal, nothing elsewhere; yields what to call with (done, total)."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    console = stderr_console()
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=30),
        TaskProgressColumn(),
        TimeElapsedColumn(),
    )
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task(what, total=1)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def indented(text: str, columns: int, console: Console) -> str:
    """A paragraph that is as wide as the console allows, some columns from its left edge."""
    width = max(console.width, columns + _NARROWEST)
    return textwrap.fill(
        text, width, initial_indent=" " * columns, subsequent_indent=" " * columns,
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def console_on(stream: TextIO) -> Console:
    """A console that writes to a stream; plain text where that is no terminal."""
    from rich.console import Console
    from rich.theme import Theme

    class PipeConsole(Console):
        def on_broken_pipe(self) -> None:
            discard_output(stream)

    return PipeConsole(
        file=stream,
        theme=Theme(_PROGRESS_STYLES),
        color_system=None if os.environ.get("NO_COLOR") else "auto",
        highlight=False,
        markup=False,
        emoji=False,
        width=None if stream.isatty() else _WIDTH,
    )


@contextmanager
def _broken_pipe_ignored(stream: TextIO) -> Iterator[None]:
    try:
        yield
    except BrokenPipeError:
        discard_output(stream)
