"""Another implementation as a Python function."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from converters.frames.casts import as_quantity, check_size
from converters.scene_folder import plain_document
from minirt.errors import InputError, MinirtError
from minirt.frame import Array, Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.compare.precision import Claim, declared
from reference.source import Crashed, Declared, NoAnswer, Rendering


@dataclass(frozen=True)
class PythonSubject:
    """A function ``module:function`` that takes a scene's dict and returns arrays by quantity.

    The dict is the scene's JSON with the slides' form of the screen, with ε as a number, and with
    ``folder``, to which the names of mesh files are relative. The function is called in a child
    process, in the current working directory.
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


def _function(path: str) -> Any:
    module, _, name = path.partition(":")
    sys.path.insert(0, str(Path.cwd()))
    try:
        found: Any = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
    except (Exception, SystemExit) as error:  # also of a module that calls its main() on import
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
