"""The options that name another implementation, declared once for all the commands that take it."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from typing import Annotated, Any, get_type_hints

import typer

from reports.gate.subject import Subject

#: By field of `Subject`.
_OPTIONS: dict[str, Any] = {
    "cmd": typer.Option(
        metavar="'PROGRAM {scene} {out}'",
        help="A program, run once a scene: {scene} becomes the path of its scene, {out} the "
        "path to write; {nx} and {ny} the size.",
    ),
    "python": typer.Option(
        metavar="MODULE:FUNCTION",
        help="A function that takes a scene's dict and returns arrays by quantity.",
    ),
    "frames": typer.Option(
        metavar="DIR",
        show_default=False,
        help="What was rendered earlier: SCENE.npz, SCENE.exr or SCENE/ in a folder.",
    ),
    "scene_as": typer.Option(help="What {scene} is: minirt's JSON, or an export."),
    "out_as": typer.Option(
        help="What is written to {out}: folder is one of images, mitsuba the channels of its "
        "aov integrator.",
    ),
    "precision": typer.Option(
        help="The number format that it computes in; half where it hands over half.",
    ),
    "handed": typer.Option(
        show_default=False,
        help="The number format in which numbers come, where it is coarser than they were "
        "computed in: half channels, say. Without it float64 for .npz and functions, else "
        "float32, also for folders, even of .npy.",
    ),
    "delta": typer.Option(
        metavar="LENGTH",
        min=0.0,
        show_default=False,
        help="The error that it declares, in scene units, in place of the precision's.",
    ),
    "max_delta": typer.Option(
        metavar="LENGTH",
        min=0.0,
        show_default=False,
        help="The widest error that may be declared; a wider one is refused.",
    ),
    "start": typer.Option(
        metavar="LENGTH",
        min=0.0,
        show_default=False,
        help="Where its secondary rays start, in scene units, if not at the scene's ε; in "
        "float32 not at 64 times its error either.",
    ),
    "sandbox": typer.Option(
        "--sandbox",
        help="Run the program without network; it sees the system, its scene and the folder "
        "that it lies in.",
    ),
    "timeout": typer.Option(min=1, metavar="SECONDS", help="For each scene, whoever renders it."),
}


def takes_subject(command: Callable[..., None]) -> Callable[..., None]:
    """A command with all options of a subject in place of its parameter `subject`."""
    hints = get_type_hints(command, include_extras=True)
    types = get_type_hints(Subject)
    given = [
        inspect.Parameter(
            f.name, inspect.Parameter.KEYWORD_ONLY, default=f.default,
            annotation=Annotated[types[f.name], _OPTIONS[f.name]],
        )
        for f in fields(Subject)
    ]  # fmt: skip
    parameters: list[inspect.Parameter] = []
    for parameter in inspect.signature(command).parameters.values():
        own = parameter.replace(
            kind=inspect.Parameter.KEYWORD_ONLY, annotation=hints[parameter.name]
        )
        parameters += given if parameter.name == "subject" else [own]

    @wraps(command)
    def called(**values: Any) -> None:
        named = {parameter.name: values.pop(parameter.name) for parameter in given}
        command(**values, subject=Subject(**named))

    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    called.__annotations__ = {each.name: each.annotation for each in parameters}
    return called
