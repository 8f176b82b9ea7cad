"""`minirt exercises`: the lecture's three exercises, solved; more of them; answers marked."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.cli.options import Json
from reports.terminal.console import indented, print_json, stdout_console

if TYPE_CHECKING:
    from collections.abc import Sequence

    from minirt.explain.exercise_kinds import Exercise

#: Bytes beyond which a file holds no answers.
_LONGEST = 2**20


def exercises(
    generate: Annotated[
        int | None,
        typer.Option(
            metavar="SEED", min=0, show_default=False,
            help="Three new exercises of the same kinds instead of the lecture's.",
        ),
    ] = None,
    check: Annotated[
        Path | None,
        typer.Option(
            metavar="ANSWERS.json", show_default=False,
            help='Mark answers, by their exercise: {"1": {"direction": [1, 0, 0]}, "2": '
            '{"center": [0, 0, 0], "radius": 1}, "3": {"direction": [1, 0, 0]}}.',
        ),
    ] = None,
    unsolved: Annotated[
        bool, typer.Option("--unsolved", help="Without the solutions, to hand out.")
    ] = False,
    json: Json = False,
) -> None:  # fmt: skip
    """Print the lecture's exercises with worked solutions, or mark answers.

    An answer is judged by its property: a direction is tangent where its ray meets the sphere
    in exactly one point, whichever of the tangents it is. Exit status 1 if one is wrong.
    """
    from minirt.explain.exercises import EXERCISES, checked, generated

    chosen = EXERCISES if generate is None else generated(generate)
    if check is None:
        _show(chosen, unsolved, json)
        return
    found = checked(chosen, _read(check))
    if json:
        print_json({"wrong": found})
    else:
        for number, fault in found.items():
            words = "not answered" if fault is None else (fault and f"wrong: {fault}") or "right"
            stdout_console().print(f"{number}. {words}", soft_wrap=True)
    raise typer.Exit(int(any(fault != "" for fault in found.values())))


def _read(path: Path) -> dict[str, Any]:
    import json

    from minirt.errors import InputError

    if path.exists() and not (path.is_file() and path.stat().st_size <= _LONGEST):
        raise InputError("no answers", where=str(path), expected="a file of at most 1 MiB")
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        got = reason.partition(";")[0]
        raise InputError("the answers cannot be read", where=str(path), got=got) from None
    if not isinstance(document, dict):
        raise InputError(
            "not answers", where=str(path), expected='as {"1": {"direction": [1, 0, 0]}}'
        )
    return document


def _show(chosen: Sequence[Exercise], unsolved: bool, json: bool) -> None:
    if json:
        documents = [
            {"number": k, "text": each.text}
            | ({} if unsolved else {"solution": list(each.solution), "answer": each.answer})
            for k, each in enumerate(chosen, start=1)
        ]
        print_json({"exercises": documents})
        return
    console = stdout_console()
    for k, each in enumerate(chosen, start=1):
        console.print(f"{k}. {indented(each.text, 3, console).lstrip()}", soft_wrap=True)
        for line in () if unsolved else each.solution:
            console.print(indented(line, 5, console), style="dim", soft_wrap=True)
        console.print()
