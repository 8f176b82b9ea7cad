"""Arguments and options that several commands share, each declared once."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from reports.history import HISTORY_FILE

#: Processors that this process may use.
CORES = len(os.sched_getaffinity(0))

Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON document on standard output, nothing else.")
]
SceneArgument = Annotated[
    str, typer.Argument(help="A scene's JSON file, - for standard input, or atlas:NAME.")
]
ScenesArgument = Annotated[
    list[str] | None,
    typer.Argument(help="JSON files, - or atlas:NAME; without any the whole atlas."),
]
JobsOption = Annotated[
    int, typer.Option("--jobs", "-j", min=1, help="Processes of each kind; all processors.")
]
RequireOption = Annotated[
    str,
    typer.Option(
        "--require", metavar="NAMES", envvar="MINIRT_REQUIRE",
        help="References that must be there and work, separated by commas; else exit status 3.",
    ),
]  # fmt: skip
NoCacheOption = Annotated[
    bool, typer.Option("--no-cache", help="Take nothing from earlier runs: render all anew.")
]
ClusterOption = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS", show_default=False,
        help="A Dask scheduler, as tcp://HOST:PORT, whose workers do the jobs in place of this "
        "machine.",
    ),
]  # fmt: skip
MutantsOption = Annotated[
    Path | None,
    typer.Option(
        "--mutants", metavar="FILE", show_default=False,
        help="What minirt mutants --json printed, to be shown in the report.",
    ),
]  # fmt: skip
HistoryOption = Annotated[
    str,
    typer.Option(
        "--history", metavar="FILE|URL", envvar="MINIRT_HISTORY", show_default=False,
        help="The history that the run is added to: a SQLite file, or the URL of a database; "
        f"without it {HISTORY_FILE} beside the reports.",
    ),
]  # fmt: skip
NoHistoryOption = Annotated[bool, typer.Option("--no-history", help="Add the run to no history.")]
