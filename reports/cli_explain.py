"""`minirt explain`: the algorithm's own steps at one pixel."""

from __future__ import annotations

from typing import Annotated

import typer

from reports.console import Json, SceneArgument, print_json


def explain(
    scene: SceneArgument,
    pixel: Annotated[
        tuple[int, int],
        typer.Option(metavar="COL ROW", help="Column from the left, row from the TOP; from 0."),
    ],
    json: Json = False,
) -> None:
    """Show the algorithm's own steps at one pixel, with the numbers."""
    import minirt
    from minirt.explain import explain as explanation_of

    explanation = explanation_of(minirt.load_scene(scene), *pixel)
    if json:
        print_json(explanation.to_dict())
    else:
        from reports.explain_text import print_explanation

        print_explanation(explanation)
