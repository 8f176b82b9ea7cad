"""The options that name another implementation, declared once for all the commands that take it."""

from __future__ import annotations

import inspect
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

if TYPE_CHECKING:
    from reference.compare.precision import Claim
    from reference.source import Reference

#: Seconds beyond a program's own limit after which what runs it is taken to hang.
GRACE = 60.0


class SceneLanguage(StrEnum):
    """In which language a program takes its scenes."""

    json = "json"
    mitsuba = "mitsuba"
    povray = "povray"
    obj = "obj"


class OutFormat(StrEnum):
    """In which format a program writes its frames."""

    exr = "exr"
    npz = "npz"
    folder = "folder"
    mitsuba = "mitsuba"


class Format(StrEnum):
    """The number format that an implementation computes in."""

    float64 = "float64"
    float32 = "float32"
    half = "half"


@dataclass(frozen=True)
class Subject:
    """Somebody else's implementation, as options name it; each field is one option."""

    cmd: Annotated[
        str,
        typer.Option(
            metavar="'PROGRAM {scene} {out}'",
            help="A program, run once a scene: {scene} becomes the path of its scene, {out} the "
            "path to write; {nx} and {ny} the size.",
        ),
    ] = ""  # fmt: skip
    python: Annotated[
        str,
        typer.Option(
            metavar="MODULE:FUNCTION",
            help="A function that takes a scene's dict and returns arrays by quantity.",
        ),
    ] = ""
    frames: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", show_default=False,
            help="What was rendered earlier: SCENE.npz, SCENE.exr or SCENE/ in a folder.",
        ),
    ] = None  # fmt: skip
    scene_as: Annotated[
        SceneLanguage, typer.Option(help="What {scene} is: minirt's JSON, or an export.")
    ] = SceneLanguage.json
    out_as: Annotated[
        OutFormat,
        typer.Option(
            help="What is written to {out}: folder is one of images, mitsuba the channels of its "
            "aov integrator.",
        ),
    ] = OutFormat.exr
    precision: Annotated[
        Format,
        typer.Option(
            help="The number format that it computes in; half where it hands over half.",
        ),
    ] = Format.float64
    handed: Annotated[
        Format | None,
        typer.Option(
            show_default=False,
            help="The number format in which numbers come, where it is coarser than they were "
            "computed in: half channels, say. Without it float64 for .npz and functions, else "
            "float32, also for folders, even of .npy.",
        ),
    ] = None  # fmt: skip
    delta: Annotated[
        float | None,
        typer.Option(
            metavar="LENGTH", min=0.0, show_default=False,
            help="The error that it declares, in scene units, in place of the precision's.",
        ),
    ] = None  # fmt: skip
    max_delta: Annotated[
        float | None,
        typer.Option(
            metavar="LENGTH", min=0.0, show_default=False,
            help="The widest error that may be declared; a wider one is refused.",
        ),
    ] = None  # fmt: skip
    start: Annotated[
        float | None,
        typer.Option(
            metavar="LENGTH", min=0.0, show_default=False,
            help="Where its secondary rays start, in scene units, if not at the scene's ε; in "
            "float32 not at 64 times its error either.",
        ),
    ] = None  # fmt: skip
    sandbox: Annotated[
        bool,
        typer.Option(
            "--sandbox",
            help="Run the program without network; it sees the system, its scene and the folder "
            "that it lies in.",
        ),
    ] = False
    timeout: Annotated[
        float, typer.Option(min=1, metavar="SECONDS", help="For each scene, whoever renders it.")
    ] = 60.0

    @classmethod
    def of(cls, options: Mapping[str, Any]) -> Subject:
        """An implementation from options by name, numbers as text too.

        Raises
        ------
        InputError
            An option is not what it must be.
        """
        from pydantic import TypeAdapter, ValidationError

        from minirt.errors import InputError

        try:
            return TypeAdapter(cls).validate_python(options)
        except ValidationError as error:
            first = error.errors()[0]
            raise InputError(
                "not what the option takes",
                where=f"{first['loc'][0]}".replace("_", "-"),
                got=repr(first["input"])[:80],
                expected=first["msg"].removeprefix("Input should be "),
            ) from None

    @property
    def named(self) -> bool:
        """Whether any implementation is named."""
        return bool(self.cmd or self.python or self.frames)

    @property
    def patience(self) -> float:
        """Seconds after which the process that runs it is ended."""
        return self.timeout + GRACE

    def reference(self) -> Reference:
        """It, to be judged as a reference is.

        Raises
        ------
        InputError
            None is named, or more than one; a command that says nowhere where to write.
        """
        from minirt.errors import InputError
        from reference.renderers.external import FramesSubject, PythonSubject

        named = [name for name in (self.cmd, self.python, self.frames) if name]
        if len(named) != 1:
            raise InputError(
                "one implementation at a time is judged",
                got=f"{len(named)} of them", expected="one of --cmd, --python and --frames",
            )  # fmt: skip
        if self.cmd:
            return self._command()
        if self.sandbox:
            raise InputError(
                "only a program can run in a sandbox", where="--sandbox", expected="--cmd"
            )
        if self.frames:
            return FramesSubject(self.frames.absolute(), self.claim(), most=self.max_delta)
        if ":" not in self.python:
            raise InputError(
                "not a function", where="--python", got=self.python[:80],
                expected="as module:function",
            )  # fmt: skip
        return PythonSubject(self.python, self.claim(), most=self.max_delta)

    def claim(self) -> Claim:
        """What is claimed of its errors, the format of its files included."""
        from reference.compare.precision import Claim

        if self.frames is None:
            exact = bool(self.python) or self.out_as is OutFormat.npz
        else:
            exact = self.frames.is_dir() and not any(map(_is_coarse, self.frames.iterdir()))
        usual = Format.float64 if exact else Format.float32
        handed = self.handed or usual
        return Claim(self.precision.value, self.delta, self.start, handed.value)

    def options(self) -> dict[str, Any]:
        """The options that differ from what they are by themselves, good in whatever folder."""
        from reference.renderers.external import command_words

        given = {f.name: getattr(self, f.name) for f in fields(self)}
        if self.cmd:
            given["cmd"] = shlex.join(command_words(self.cmd))
        return {
            f.name: value.value if isinstance(value, StrEnum) else value
            for f in fields(self)
            if (value := given[f.name]) != f.default
        }

    def arguments(self) -> list[str]:
        """The options as words of a command line."""
        words: list[str] = []
        for f in fields(self):
            value = getattr(self, f.name)
            if value != f.default:
                words.append("--" + f.name.replace("_", "-"))
                words += [] if value is True else [str(value)]
        return words

    def _command(self) -> Reference:
        from reference.jobs.program import Limits
        from reference.renderers.external import CommandSubject, command_words

        command_words(self.cmd)
        return CommandSubject(
            self.cmd, self.claim(), scene_as=self.scene_as.value, out_as=self.out_as.value,
            limits=Limits(wall_seconds=self.timeout, cpu_seconds=4 * self.timeout),
            sandbox=self.sandbox, most=self.max_delta,
        )  # fmt: skip


def _is_coarse(path: Path) -> bool:
    """Whether something beside frames in .npz is one in a format of float32; a README is none."""
    return path.suffix == ".exr" or (path.is_dir() and not path.name.startswith("."))


def takes_subject(command: Callable[..., None]) -> Callable[..., None]:
    """A command with all options of a subject in place of its parameter `subject`."""
    hints = get_type_hints(command, include_extras=True)
    options = get_type_hints(Subject, include_extras=True)
    given = [
        inspect.Parameter(
            f.name, inspect.Parameter.KEYWORD_ONLY, default=f.default, annotation=options[f.name]
        )
        for f in fields(Subject)
    ]
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
