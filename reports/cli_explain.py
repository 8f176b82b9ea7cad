"""`minirt explain`: the algorithm's own steps at one pixel, and another implementation's values."""

from __future__ import annotations

from typing import Annotated

import typer

from reports.cli_gate import (
    GRACE,
    Cmd,
    DeltaOption,
    Format,
    Frames,
    HandedOption,
    OutAsOption,
    OutFormat,
    PrecisionOption,
    Python,
    SandboxOption,
    SceneAsOption,
    SceneLanguage,
    StartOption,
    claim_of,
    subject_of,
)
from reports.console import Json, SceneArgument, answers, print_json


def explain(
    scene: SceneArgument,
    pixel: Annotated[
        tuple[int, int],
        typer.Option(metavar="COL ROW", help="Column from the left, row from the TOP; from 0."),
    ],
    cmd: Cmd = "",
    python: Python = "",
    frames: Frames = None,
    scene_as: SceneAsOption = SceneLanguage.json,
    out_as: OutAsOption = OutFormat.exr,
    precision: PrecisionOption = Format.float64,
    handed: HandedOption = None,
    delta: DeltaOption = None,
    start: StartOption = None,
    sandbox: SandboxOption = False,
    timeout: Annotated[int, typer.Option(min=1, metavar="SECONDS", help="For the program.")] = 60,
    json: Json = False,
) -> None:
    """Show the algorithm's own steps at one pixel, with the numbers.

    With an implementation named, its values beside them, and which stage is wrong first.
    """
    import minirt
    from minirt.explain import explain as explanation_of

    loaded = minirt.load_scene(scene)
    explanation = explanation_of(loaded, *pixel)
    opinion = None
    if cmd or python or frames:
        from reports.second_opinion import second_opinion

        claim = claim_of(precision, handed, delta, start, out_as, frames, python)
        subject = subject_of(
            cmd, python, frames, claim, scene_as, out_as, sandbox=sandbox, timeout=timeout
        )
        opinion = second_opinion(loaded, *pixel, subject, timeout + GRACE)
    if json:
        other = {} if opinion is None else {"other": opinion.to_dict()}
        print_json(explanation.to_dict() | other)
    else:
        from reports.explain_text import print_explanation

        print_explanation(explanation)
        if opinion is not None:
            from reports.second_opinion import print_second_opinion

            print_second_opinion(opinion, answers())
    if opinion is not None and (opinion.trouble or opinion.first):
        raise typer.Exit(3 if opinion.trouble else 1)
