"""The command `minirt`: the list of its commands, and what becomes of errors.

Nothing heavy is imported before it is known which command is wanted, so that ``--help`` is quick.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from typing import Annotated

import typer

from reports.cli.exercises import exercises
from reports.cli.explain import explain
from reports.cli.export import export
from reports.cli.fuzz import fuzz
from reports.cli.gate import gate
from reports.cli.grade import grade
from reports.cli.inventory import doctor, rules, scenes
from reports.cli.mutants import mutants
from reports.cli.nightly import nightly
from reports.cli.pack import pack
from reports.cli.render import render
from reports.cli.report import report
from reports.cli.verify import verify
from reports.terminal.console import print_json, stderr_console
from reports.terminal.streams import discard_unwritable_output, prepare

app = typer.Typer(
    name="minirt",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)

#: What asks for words only, which are to be there at once.
_HELP = frozenset({"-h", "--help", "--version"})

for command, example in (
    (render, "render atlas:glass-ball -o glass-ball.exr"),
    (explain, "explain atlas:glass-ball --pixel 128 96"),
    (verify, "verify atlas:glass-ball --reference mitsuba --out report"),
    (gate, "gate --init my-tracer --language cpp"),
    (grade, "grade submissions --rubric rubric.toml -o graded"),
    (fuzz, "fuzz --seed 7 --scenes 20 --time 60 --reference embree"),
    (export, "export atlas:glass-ball --to mitsuba -o glass-ball"),
    (scenes, "scenes glass-ball"),
    (rules, "rules"),
    (mutants, "mutants --only no-half-pixel,far-root"),
    (exercises, "exercises --generate 7"),
    (nightly, "nightly --out nights --budget 20m --keep 30"),
    (doctor, "doctor"),
):
    app.command(epilog=f"Example: minirt {example}")(command)
app.add_typer(report)


app.add_typer(pack, name="pack")


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"minirt {version('minirt')}")
        raise typer.Exit


@app.callback(
    epilog="Example: minirt render atlas:glass-ball -o glass-ball.exr\n\n"
    "Exit status: 0 all passed; 1 a check failed; 2 bad input or usage; "
    "3 a required reference or program is missing, crashed or timed out, or nothing was compared."
)
def _minirt(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """A ray tracer that follows its lecture rule by rule, and the harness that cross-checks it."""


def main() -> None:
    """Run the command that the process was started with, and end it with its exit status."""
    prepare()
    status = run(sys.argv[1:])
    discard_unwritable_output()
    sys.exit(status)


def run(arguments: Sequence[str]) -> int:
    """Run one command; whatever goes wrong becomes one sentence and an exit status.

    Parameters
    ----------
    arguments : sequence of str
        As after the program's name.

    Returns
    -------
    int
        0 all passed; 1 a check failed; 2 bad input or usage; 3 a required reference or program is
        missing, crashed or timed out, or nothing was compared; 130 interrupted.
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    as_json = "--json" in arguments
    if _HELP.isdisjoint(arguments):
        _prepare_to_trace()
    try:
        return app(args=list(arguments), prog_name="minirt", standalone_mode=False) or 0
    except typer.TyperException as error:
        return _misused(error, arguments, as_json)
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except Exception as error:
        return _failed(error, as_json)


def _prepare_to_trace() -> None:
    from minirt.memory import keep_freed_memory

    keep_freed_memory()


def _misused(error: typer.TyperException, arguments: Sequence[str], as_json: bool) -> int:
    """The command line itself is wrong."""
    text = error.format_message().replace("Value error, ", "")
    if text.startswith("Usage:"):  # nothing was asked for
        typer.echo(text, err=True)
        return error.exit_code
    hint = f"'{_command_path(arguments)} --help' shows how"
    return _say(text, {"what": text}, hint, error.exit_code, as_json)


def _command_path(arguments: Sequence[str]) -> str:
    """The words that name the command, as far as there is one."""
    path, here = ["minirt"], typer.main.get_command(app)
    for word in arguments:
        below = getattr(here, "commands", {})
        if word not in below:
            break
        path.append(word)
        here = below[word]
    return " ".join(path)


def _failed(error: Exception, as_json: bool) -> int:
    from minirt.errors import MinirtError
    from reports.results.words import plain

    if os.environ.get("MINIRT_DEBUG"):
        traceback.print_exception(error)
    if isinstance(error, MinirtError):
        parts = {name: getattr(error, name) for name in ("what", "where", "got", "expected")}
        return _say(plain(str(error)), parts, "", error.exit_status, as_json)
    if isinstance(error, OSError):
        text = f"the system refuses: {error}"
        return _say(plain(text), {"what": text}, "", 2, as_json)
    if isinstance(error, MemoryError):
        text = f"the memory is used up: {error}"
        return _say(plain(text), {"what": text}, "", 2, as_json)
    text = f"a mistake in minirt itself: {type(error).__name__}: {error}"
    hint = "MINIRT_DEBUG=1 shows where; please report it"
    return _say(plain(text), {"what": text}, hint, 3, as_json)


def _say(text: str, parts: dict[str, str], hint: str, status: int, as_json: bool) -> int:
    with suppress(OSError):  # nobody is left to be told
        _tell(text, hint)
        if as_json:
            print_json({"error": parts, "exit_status": status})
    return status


def _tell(text: str, hint: str) -> None:
    console = stderr_console()
    console.print("error:", style="bold red", end=" ")
    console.print(text, soft_wrap=True)
    if hint:
        console.print(hint, style="dim", soft_wrap=True)
