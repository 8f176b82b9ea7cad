"""`minirt report`: what a history knows."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.cli.options import Json
from reports.history import HISTORY_FILE
from reports.terminal.console import print_json, stderr_console, stdout_console

if TYPE_CHECKING:
    from reports.history.entry import Entry

report = typer.Typer(
    name="report", no_args_is_help=True, rich_markup_mode=None,
    help="Read the history of runs: what changed, and since when.",
)  # fmt: skip

History = Annotated[
    str,
    typer.Option(
        "--history", metavar="FILE|URL", envvar="MINIRT_HISTORY",
        help="The history: a SQLite file, or the URL of a database.",
    ),
]  # fmt: skip
Run = Annotated[
    str,
    typer.Argument(
        metavar="RUN",
        help="A run's number, latest, previous, or a results.json or the folder that holds one.",
    ),
]
_USUAL = f"report/{HISTORY_FILE}"


@report.command(epilog="Example: minirt report compare previous latest --html compare.html")
def compare(
    first: Run,
    second: Run = "latest",
    history: History = _USUAL,
    html: Annotated[
        Path | None,
        typer.Option("--html", metavar="FILE", show_default=False, help="Write a page as well."),
    ] = None,
    json: Json = False,
) -> None:
    """Show what changed from one run to another, cell by cell.

    Exit status 1 where a cell fails, or has no answer, that did better before.
    """
    from reports.history.difference import difference
    from reports.history.text import print_difference

    found = difference(*_entries([first, second], history))
    if html is not None:
        from converters.atomic import atomic_file
        from reports.history.pages import compare_html

        with atomic_file(html) as path:
            path.write_text(compare_html(found), encoding="utf-8", newline="\n")
        stderr_console().print(f"page: {html}", soft_wrap=True)
    if json:
        from reports.history.documents import difference_document

        print_json(difference_document(found))
    else:
        print_difference(found, stdout_console())
    raise typer.Exit(int(found.regressions > 0))


@report.command("history", epilog="Example: minirt report history one-sphere")
def scene_history(
    scene: Annotated[str, typer.Argument(help="A scene's name, or atlas:NAME.")],
    history: History = _USUAL,
    most: Annotated[int, typer.Option(min=1, help="Runs to show of each series.")] = 30,
    json: Json = False,
) -> None:
    """Show how a scene did from run to run, and where that changed.

    Runs that ask the same question make a series: minirt against the same references, or a gate of
    the same implementation.
    """
    from reports.history.store import History as Store
    from reports.history.text import print_trend
    from reports.history.trends import changes_of

    name = scene.removeprefix("atlas:")
    with Store(history, create=False) as store:
        found = store.trends([name])
        if not found:
            raise _unknown(name, store)
    (by_series,) = found.values()
    if json:
        from reports.history.documents import trend_document

        print_json({"scene": name, "series": [trend_document(*s) for s in by_series.items()]})
        return
    for series, trend in by_series.items():
        print_trend(series, trend, changes_of(trend), most, stdout_console())


@report.command(epilog="Example: minirt report record report/results.json")
def record(
    results: Annotated[Path, typer.Argument(help="A results.json, or the folder that holds one.")],
    history: History = _USUAL,
    json: Json = False,
) -> None:
    """Add a run to a history from its results; one that is there is not added again."""
    from reports.history.entry import read_entry
    from reports.history.store import History as Store

    entry = read_entry(results)
    with Store(history) as store:
        number, shown = store.append(entry), store.shown
    if json:
        print_json({"run": number, "history": shown})
    stderr_console().print(f"history: run {number} in {shown}", soft_wrap=True)


def _entries(words: list[str], target: str) -> list[Entry]:
    """Runs by number, word or path; the history is only opened where one of them asks for it."""
    from reports.history.entry import read_entry
    from reports.history.store import History as Store

    paths = [Path(word) if _is_path(word) else None for word in words]
    if all(paths):
        return [read_entry(path) for path in paths if path]
    with Store(target, create=False) as store:
        return [
            read_entry(path) if path else store.entry(store.number(word))
            for word, path in zip(words, paths, strict=True)
        ]


def _is_path(word: str) -> bool:
    """A number is a run's, whatever lies in the working folder."""
    return (
        not word.isdigit()
        and word not in ("latest", "previous")
        and ("/" in word or word.endswith(".json") or Path(word).exists())
    )


def _unknown(name: str, store: Any) -> Exception:
    from difflib import get_close_matches

    from minirt.errors import InputError

    newest = store.latest()
    names = store.scenes_of(newest) if newest is not None else []
    near = get_close_matches(name, names, 3) or names[:3]
    return InputError(
        "no run of this scene", where=store.shown, got=repr(name)[:80],
        expected=", ".join(near) if near else "a scene that was verified",
    )  # fmt: skip
