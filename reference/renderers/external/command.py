"""Another implementation as a program, run in a folder of its own and with limits."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from converters.placement import IDENTITY, fitted_placement
from minirt.errors import InputError, ReferenceError
from minirt.scene import Scene
from reference.compare.precision import Claim, declared
from reference.jobs.program import Limits, plain_files, run_program, sandbox_missing
from reference.renderers.external.frames import read_rendering
from reference.renderers.external.languages import OutAs, SceneAs, hand_over
from reference.renderers.mitsuba.cli import read_aov
from reference.source import Crashed, Declared, NoAnswer, Rendering, TimedOut

_OUT = {"exr": "out.exr", "npz": "out.npz", "folder": "out", "mitsuba": "out.exr"}


@dataclass(frozen=True)
class CommandSubject:
    """A program that is run once for each scene.

    Attributes
    ----------
    command : str
        Quoted as for a shell, but run without one; ``{scene}``, ``{out}``, ``{nx}`` and ``{ny}``
        in its words are replaced. Words that name an existing file are made absolute, since the
        program runs in a folder of its own.
    claim : Claim
    name : str
    scene_as, out_as : str
    limits : Limits
    sandbox : bool
    most : float or None
        The largest allowed δ, in scene units.
    visible : tuple of Path
        What it can read in the sandbox, besides the folders of the files that its command names.
    """

    command: str
    claim: Claim
    name: str = "subject"
    scene_as: SceneAs = "json"
    out_as: OutAs = "exr"
    limits: Limits | None = None
    sandbox: bool = False
    most: float | None = None
    visible: tuple[Path, ...] = ()

    def missing(self) -> str | None:
        """Why it cannot run here; None where it can."""
        return sandbox_missing() if self.sandbox else None

    def declare(self, scene: Scene) -> Declared:
        """The error bounds that follow from its author's claim and from the format of its files."""
        placed = self.scene_as == "mitsuba" and self.out_as == "mitsuba"  # see `export_aov`
        where = fitted_placement(scene) if placed else IDENTITY
        return declared(scene, self.claim, self.most, where)

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Run the program on the scene and read what it has written.

        Raises
        ------
        NoAnswer
            It failed, or left no frame that can be read.
        Unsupported
            The scene cannot be expressed in the language that it reads.
        """
        workdir = scratch / "work"
        workdir.mkdir()
        out = workdir / _OUT[self.out_as]
        words = command_words(self.command)
        values: dict[str, object] = {"nx": scene.screen.nx, "ny": scene.screen.ny, "out": out}
        values["scene"] = hand_over(scene, self.scene_as, self.out_as, workdir)
        filled = [_filled(word, values) for word in words]
        ended = run_program(
            filled, workdir, self.limits, self.sandbox, [*_near(words), *self.visible]
        )
        sys.stdout.write(ended.output)
        if ended.reason:
            kind = TimedOut if ended.reason.startswith("no answer within") else Crashed
            raise kind(_sentence(ended.reason))
        _require_plain(workdir)
        program = Path(filled[0]).name
        return (_read_aov if self.out_as == "mitsuba" else read_rendering)(out, scene, program)


def command_words(command: str) -> list[str]:
    """The words of a command; those that name an existing file or folder are made absolute.

    Raises
    ------
    InputError
        Not a command, or one without ``{out}``.
    """
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise InputError("not a command", where="--cmd", got=str(error)) from None
    if not words or not any("{out}" in word for word in words):
        raise InputError(
            "the command does not say where to write",
            where="--cmd", got=repr(command)[:200], expected="as 'PROGRAM {scene} {out}'",
        )  # fmt: skip
    return [str(Path(word).absolute()) if _names_a_file(word) else word for word in words]


def _names_a_file(word: str) -> bool:
    return "{" not in word and not word.startswith("-") and Path(word).exists() and (
        "/" in word or Path(word).is_file()
    )  # fmt: skip


def _near(words: list[str]) -> list[Path]:
    """The folders of the files that a command names: a program may load others beside it."""
    return [Path(word).parent for word in words if word.startswith("/") and Path(word).is_file()]


def _require_plain(workdir: Path) -> None:
    """Refuse the output of a program that left links, pipes or devices."""
    try:
        plain_files(workdir)
    except InputError as error:
        raise NoAnswer(
            f"the program left something else than files: {error.what}", got=error.got
        ) from None


def _sentence(reason: str) -> str:
    """How a program ended, as a whole sentence."""
    whole = ("there is no program", "no answer within", "its ", "one of its ")
    return reason if reason.startswith(whole) else f"the program {reason}"


def _filled(word: str, values: Mapping[str, object]) -> str:
    for name, value in values.items():
        word = word.replace(f"{{{name}}}", str(value))
    return word


def _read_aov(path: Path, scene: Scene, program: str) -> Rendering:
    """Read the image that Mitsuba's command left."""
    try:
        return Rendering(read_aov(scene, path), {}, program)
    except ReferenceError as error:
        raise NoAnswer(error.what, where=path.name, got=error.got) from None
