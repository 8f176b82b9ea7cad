"""`minirt explain`: the algorithm's own steps at one pixel, and another implementation's values."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from reports.cli.options import Json, SceneArgument
from reports.cli.subject_options import takes_subject
from reports.gate.subject import Subject
from reports.terminal.console import print_json, stdout_console


@takes_subject
def explain(
    scene: SceneArgument,
    pixel: Annotated[
        tuple[int, int],
        typer.Option(metavar="COL ROW", help="Column from the left, row from the TOP; from 0."),
    ],
    *,
    subject: Subject,
    html: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", show_default=False,
            help="Write a page too: the values, the steps, and the rays in space.",
        ),
    ] = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Show the algorithm's own steps at one pixel, with the numbers.

    With an implementation named, its values beside them, and which stage is wrong first.
    """
    import minirt
    from minirt.explain.pixel import explain as explanation_of

    loaded = minirt.load_scene(scene)
    explanation = explanation_of(loaded, *pixel)
    opinion = None
    if subject.named:
        from reports.explain.second_opinion import second_opinion

        opinion = second_opinion(loaded, *pixel, subject.reference(), subject.process_timeout)
    if html is not None:
        from reports.explain.page import write_pixel_page

        place = map(str, pixel)
        again = ["minirt", "explain", scene, "--pixel", *place, *subject.arguments()]
        write_pixel_page(html, loaded, explanation, opinion, again)
    if json:
        other = {} if opinion is None else {"other": opinion.to_dict()}
        print_json(explanation.to_dict() | other)
    else:
        from reports.explain.text import print_explanation

        print_explanation(explanation)
        if opinion is not None:
            from reports.explain.second_opinion import print_second_opinion

            print_second_opinion(opinion, stdout_console())
    if opinion is not None and (opinion.trouble or opinion.first):
        raise typer.Exit(3 if opinion.trouble else 1)
