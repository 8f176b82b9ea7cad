"""`minirt doctor`: what is installed here, and what brings what is missing."""

from __future__ import annotations

import typer

from reports.cli.options import Json, RequireOption
from reports.inputs import names_in
from reports.terminal.console import print_json, progress


def doctor(
    require: RequireOption = "",
    json: Json = False,
) -> None:
    """Show what is installed, and what brings what is missing.

    Every reference renderer is tried on a tiny scene.
    """
    from reports.doctor import examine
    from reports.terminal.doctor import print_examination

    with progress("trying the reference renderers") as tell:
        found = examine(names_in(require), tell)
    if json:
        print_json(found.document())
    else:
        print_examination(found)
    if not found.healthy:
        raise typer.Exit(3)
