"""Another implementation as the gate's options name it, and how it is judged."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reference.compare.precision import Claim
    from reference.source import Reference

#: Seconds beyond a program's own limit after which the process that runs it is ended.
GRACE = 60.0


class SceneLanguage(StrEnum):
    """The format in which a program takes its scenes."""

    json = "json"
    mitsuba = "mitsuba"
    povray = "povray"
    obj = "obj"


class OutFormat(StrEnum):
    """The format in which a program writes its frames."""

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
    """Somebody else's implementation; each field is one option of the command line.

    Attributes
    ----------
    cmd, python, frames : what runs it, or what it rendered earlier: one of the three
    scene_as, out_as : the formats of a program's input and output
    precision, handed : the number formats that it computes in, and in which its numbers arrive
    delta, max_delta, start : lengths in scene units: the error that it declares, the widest that
        it may declare, and where its secondary rays start
    sandbox, timeout : whether a program runs in the sandbox, and the seconds for each scene
    """

    cmd: str = ""
    python: str = ""
    frames: Path | None = None
    scene_as: SceneLanguage = SceneLanguage.json
    out_as: OutFormat = OutFormat.exr
    precision: Format = Format.float64
    handed: Format | None = None
    delta: float | None = None
    max_delta: float | None = None
    start: float | None = None
    sandbox: bool = False
    timeout: float = 60.0

    @classmethod
    def of(cls, options: Mapping[str, Any]) -> Subject:
        """An implementation from options by name; numbers may be text.

        Raises
        ------
        InputError
            An option has a value that it does not take.
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
    def name(self) -> str:
        """How reports name it: its command, its function or its folder."""
        return self.cmd or self.python or str(self.frames)

    @property
    def process_timeout(self) -> float:
        """Seconds after which the process that runs it is ended."""
        return self.timeout + GRACE

    def reference(self) -> Reference:
        """The implementation in the form in which references are compared.

        Raises
        ------
        InputError
            None is named, or more than one, or a command that names no output path.
        """
        from minirt.errors import InputError
        from reference.renderers.external.frames import FramesSubject
        from reference.renderers.external.function import PythonSubject

        named = [name for name in (self.cmd, self.python, self.frames) if name]
        if len(named) != 1:
            raise InputError(
                "one implementation at a time is judged",
                got=f"{len(named)} of them", expected="one of --cmd, --python and --frames",
            )  # fmt: skip
        if self.cmd:
            return _program(self)
        if self.sandbox:
            raise InputError(
                "only a program can run in a sandbox", where="--sandbox", expected="--cmd"
            )
        if self.frames:
            return FramesSubject(self.frames.absolute(), claim_of(self), most=self.max_delta)
        if ":" not in self.python:
            raise InputError(
                "not a function", where="--python", got=self.python[:80],
                expected="as module:function",
            )  # fmt: skip
        return PythonSubject(self.python, claim_of(self), most=self.max_delta)

    def options(self) -> dict[str, Any]:
        """The options that differ from their defaults; valid in any working folder."""
        from reference.renderers.external.command import command_words

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


def _program(subject: Subject) -> Reference:
    from reference.jobs.program import Limits
    from reference.renderers.external.command import CommandSubject, command_words

    command_words(subject.cmd)
    return CommandSubject(
        subject.cmd, claim_of(subject), scene_as=subject.scene_as.value,
        out_as=subject.out_as.value, sandbox=subject.sandbox, most=subject.max_delta,
        limits=Limits(wall_seconds=subject.timeout, cpu_seconds=4 * subject.timeout),
    )  # fmt: skip


def claim_of(subject: Subject) -> Claim:
    """What is claimed of its errors, the format of its files included."""
    from reference.compare.precision import Claim

    if subject.frames is None:
        exact = bool(subject.python) or subject.out_as is OutFormat.npz
    else:
        exact = subject.frames.is_dir() and not any(map(_is_coarse, subject.frames.iterdir()))
    usual = Format.float64 if exact else Format.float32
    handed = subject.handed or usual
    return Claim(subject.precision.value, subject.delta, subject.start, handed.value)


def _is_coarse(path: Path) -> bool:
    """Whether a file or folder holds a frame in float32 (EXR or images); a README does not."""
    return path.suffix == ".exr" or (path.is_dir() and not path.name.startswith("."))
