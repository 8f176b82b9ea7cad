"""Somebody else's implementation: a program, a Python function, or frames rendered earlier.

It sees scenes, never a frame of minirt's, and is judged as a reference is.
"""

from __future__ import annotations

import importlib
import os
import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from converters.frames.casts import as_quantity, check_size
from converters.frames.io import read_frame
from converters.placement import IDENTITY, fitted_placement
from converters.scene_folder import plain_document, write_scene_folder
from minirt.errors import InputError, MinirtError, ReferenceError
from minirt.frame import Array, Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.compare.precision import Claim, declared
from reference.jobs.program import Limits, plain_files, run_program, sandbox_missing
from reference.renderers.mitsuba.cli import export_aov, read_aov
from reference.source import Crashed, Declared, NoAnswer, Rendering, TimedOut, Unsupported

#: What a program is handed: minirt's own JSON, or the scene in another program's language.
SceneAs = Literal["json", "mitsuba", "povray", "obj"]
#: What a program writes; mitsuba: the channels of its `aov` integrator, in OpenEXR.
OutAs = Literal["exr", "npz", "folder", "mitsuba"]

_OUT = {"exr": "out.exr", "npz": "out.npz", "folder": "out", "mitsuba": "out.exr"}
#: Formats of whole numbers: eight or sixteen bits of a colour are no number to compare.
_INTEGERS = frozenset({".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".tga"})


@dataclass(frozen=True)
class CommandSubject:
    """A program that is run once a scene.

    Attributes
    ----------
    command : str
        As a shell takes it, without a shell: ``{scene}``, ``{out}``, ``{nx}`` and ``{ny}`` in its
        words are replaced. Words that name a file here are made absolute: the program runs in
        a folder of its own.
    claim : Claim
    name : str
    scene_as, out_as : str
    limits : Limits
    sandbox : bool
    most : float or None
        The largest δ that is allowed, in scene units.
    visible : tuple of Path
        What it can read in the sandbox beside the folders of the files that its command names.
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
        """The bounds that follow from its author's claim and from its files' format."""
        placed = self.scene_as == "mitsuba" and self.out_as == "mitsuba"  # see `export_aov`
        where = fitted_placement(scene) if placed else IDENTITY
        return declared(scene, self.claim, self.most, where)

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Run the program on the scene and read what it has written.

        Raises
        ------
        NoAnswer
            It did not end well, or left no frame that can be read.
        Unsupported
            The scene cannot be said in the language that it takes.
        """
        room = scratch / "room"
        room.mkdir()
        out = room / _OUT[self.out_as]
        words = command_words(self.command)
        values: dict[str, object] = {"nx": scene.screen.nx, "ny": scene.screen.ny, "out": out}
        values["scene"] = _hand_over(scene, self.scene_as, self.out_as, room)
        filled = [_filled(word, values) for word in words]
        ended = run_program(filled, room, self.limits, self.sandbox, [*_near(words), *self.visible])
        sys.stdout.write(ended.output)
        if ended.reason:
            kind = TimedOut if ended.reason.startswith("no answer within") else Crashed
            raise kind(_sentence(ended.reason))
        _require_plain(room)
        program = Path(filled[0]).name
        return (_read_aov if self.out_as == "mitsuba" else _read)(out, scene, program)


@dataclass(frozen=True)
class PythonSubject:
    """A function ``module:function`` that takes a scene's dict and returns arrays by quantity.

    The dict is the JSON with the slides' screen and ε as a number, and ``folder``, which the mesh
    files' names are relative to. It is called in a child process, from the working folder.
    """

    function: str
    claim: Claim
    name: str = "subject"
    most: float | None = None

    def missing(self) -> str | None:
        """Why it cannot run here; None where it can."""
        return None

    def declare(self, scene: Scene) -> Declared:
        """The bounds that follow from its author's claim."""
        return declared(scene, self.claim, self.most)

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Call the function.

        Raises
        ------
        NoAnswer
            There is no such function, it raised, or its answer cannot be used.
        """
        function = _function(self.function)
        document = plain_document(scene) | {"folder": str(scene.folder.resolve())}
        try:
            answer = function(document)
        except (Exception, SystemExit, KeyboardInterrupt) as error:
            raise Crashed(
                f"{self.function} raised", got=f"{type(error).__name__}: {error}"
            ) from error
        return Rendering(_frame_of(answer, scene, self.function), {}, self.function)


@dataclass(frozen=True)
class FramesSubject:
    """What was rendered earlier: ``SCENE.npz``, ``SCENE.exr`` or ``SCENE/`` in a folder."""

    folder: Path
    claim: Claim
    name: str = "subject"
    most: float | None = None

    def missing(self) -> str | None:
        """Why there is nothing to judge; None where there is."""
        return None if self.folder.is_dir() else f"there is no folder {str(self.folder)!r}"

    def declare(self, scene: Scene) -> Declared:
        """The bounds that follow from its author's claim."""
        return declared(scene, self.claim, self.most)

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        """Read the scene's frame.

        Raises
        ------
        NoAnswer
            There is none, more than one, or it cannot be read.
        """
        name = scene.name
        if name in ("", ".", "..") or "/" in name or "\0" in name:
            raise NoAnswer("the scene's name is no file's", got=repr(name)[:80])
        found = [
            path
            for path in (self.folder / f"{name}{suffix}" for suffix in (".npz", ".exr", ""))
            if os.path.lexists(path)
        ]
        if len(found) == 1:
            return _read(found[0], scene, f"frames in {self.folder.name}")
        raise NoAnswer(
            "more than one frame of the scene" if found else "no frame of the scene",
            where=str(self.folder), got=" and ".join(path.name for path in found),
            expected=f"{name}.npz, {name}.exr or {name}/",
        )  # fmt: skip


def command_words(command: str) -> list[str]:
    """The words of a command; those that name a file or folder here are made absolute.

    Raises
    ------
    InputError
        Not a command, or one that says nowhere where to write.
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


def _require_plain(room: Path) -> None:
    """Read nothing where a program left links, pipes or devices."""
    try:
        plain_files(room)
    except InputError as error:
        raise NoAnswer(
            f"the program left something else than files: {error.what}", got=error.got
        ) from None


def _sentence(reason: str) -> str:
    """How a program ended, as a sentence of its own."""
    whole = ("there is no program", "no answer within", "its ", "one of its ")
    return reason if reason.startswith(whole) else f"the program {reason}"


def _filled(word: str, values: Mapping[str, object]) -> str:
    for name, value in values.items():
        word = word.replace(f"{{{name}}}", str(value))
    return word


def _hand_over(scene: Scene, scene_as: SceneAs, out_as: OutAs, room: Path) -> Path:
    """The scene in the language that the program takes."""
    folder = room / "scene"
    if scene_as == "json":
        return write_scene_folder(scene, folder)
    if scene_as == "mitsuba":
        from converters.mitsuba.scene import export_mitsuba, unsupported_camera

        fault = unsupported_camera(scene.screen)
        if fault:
            raise Unsupported(fault)
        if out_as == "mitsuba":
            return export_aov(scene, folder)
        export_mitsuba(scene, folder)
        return folder / "scene.xml"
    if scene_as == "obj":
        from converters.obj import export_obj

        export_obj(scene, folder)
        return folder / "scene.obj"
    from converters.povray.scene import export_povray

    folder.mkdir()
    export_povray(scene, folder / "scene.pov")
    return folder / "scene.pov"


def _read(path: Path, scene: Scene, program: str) -> Rendering:
    """The frame that a program left, without what its format can only hint at."""
    try:
        frame = read_frame(path, (scene.screen.ny, scene.screen.nx))
    except MinirtError as error:
        raise NoAnswer(
            error.what, where=path.name, got=error.got, expected=error.expected
        ) from None
    coarse = {
        name: "whole numbers of 8 or 16 bits are too coarse to compare: use .exr, .pfm or .npy"
        for name in frame
        if not QUANTITIES[name].discrete and path.is_dir() and _only_integers(path, name)
    }
    kept = {name: array for name, array in frame.items() if name not in coarse}
    return Rendering(Frame(kept, frame.meta), coarse, program)


def _read_aov(path: Path, scene: Scene, program: str) -> Rendering:
    """The frame that Mitsuba's command left."""
    try:
        return Rendering(read_aov(scene, path), {}, program)
    except ReferenceError as error:
        raise NoAnswer(error.what, where=path.name, got=error.got) from None


def _only_integers(folder: Path, name: str) -> bool:
    kinds = {path.suffix.lower() for path in folder.iterdir() if path.stem == name}
    return bool(kinds) and kinds <= _INTEGERS


def _function(path: str) -> Any:
    module, _, name = path.partition(":")
    sys.path.insert(0, str(Path.cwd()))
    try:
        found: Any = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
    except (Exception, SystemExit) as error:  # a module that runs its main, unguarded
        why = f"{type(error).__name__}: {error}"
        raise NoAnswer("there is no such function", where=path, got=why) from error
    if not callable(found):
        raise NoAnswer("not a function", where=path, got=type(found).__name__)
    return found


def _frame_of(answer: Any, scene: Scene, where: str) -> Frame:
    if not isinstance(answer, Mapping):
        got = type(answer).__name__
        raise NoAnswer("not a mapping", where=where, got=got, expected="arrays by quantity")
    size = scene.screen.ny, scene.screen.nx
    arrays: dict[str, Array] = {}
    try:
        for name, values in answer.items():
            if name not in QUANTITIES:
                raise InputError("unknown quantity", got=repr(name)[:80])
            array = np.asarray(values)
            ny, nx = array.shape[:2] if array.ndim > 1 else (0, 0)
            check_size(ny, nx, size, f"{where}: {name}")
            arrays[name] = as_quantity(array, QUANTITIES[name], f"{where}: {name}")
        return Frame(arrays)
    except MinirtError as error:
        raise NoAnswer(
            error.what, where=error.where, got=error.got, expected=error.expected
        ) from None
