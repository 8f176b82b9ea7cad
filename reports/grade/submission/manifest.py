"""`minirt.toml`: how a submitted program is built and run."""

from __future__ import annotations

import os
import shlex
import sys
import tomllib
from pathlib import Path

from pydantic import Field, ValidationError

from minirt.errors import InputError
from reference.compare.precision import Precision
from reference.renderers.external.languages import OutAs, SceneAs
from reports.grade.assignment.rubric import validation_error
from reports.results.json_model import Model

#: The file that says how a submission is built and run.
MANIFEST = "minirt.toml"
#: Bytes beyond which a file is no manifest.
_LONGEST = 64 * 2**10
#: What every program sees in the sandbox.
_VISIBLE = ("/usr", "/bin", "/sbin", "/opt")


class Manifest(Model):
    """`minirt.toml` of a submission."""

    build: str = Field(default="", max_length=2000, description="run once, by sh, before all")
    run: str = Field(default="", max_length=2000, description="as 'PROGRAM {scene} {out}'")
    scene_as: SceneAs = "json"
    out_as: OutAs = "exr"
    precision: Precision | None = Field(default=None, description="the number format it claims")


def read_manifest(path: Path) -> Manifest:
    """The manifest at a path; an empty one where there is no file."""
    if not path.is_file():
        return Manifest()
    if path.stat().st_size > _LONGEST:
        raise InputError("too long", where=MANIFEST, expected="at most 64 KiB")
    try:
        return Manifest.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except (ValueError, RecursionError) as error:
        if isinstance(error, ValidationError):
            raise validation_error(error, MANIFEST) from None
        raise InputError("not TOML", where=MANIFEST, got=str(error)[:200]) from None


def command_words(command: str, folder: Path) -> list[str]:
    """The words of a command, with those that name its own files made absolute."""
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise InputError("not a command", where=f"{MANIFEST}: run", got=str(error)) from None
    if not any("{out}" in word for word in words) or not any("{scene}" in word for word in words):
        raise InputError(
            "the command does not say what to read and where to write", where=f"{MANIFEST}: run",
            got=repr(command)[:200], expected="as 'PROGRAM {scene} {out}'",
        )  # fmt: skip
    return [_absolute(word, folder.resolve(), first=k == 0) for k, word in enumerate(words)]


def _absolute(word: str, own: Path, first: bool) -> str:
    """A word, absolute where it names a file of the submission.

    The sandbox shows each file that its command names. So no word may name one that is neither
    the submission's nor shown anyway: the rubric, say, or what somebody else has handed in.
    """
    if word.startswith("-") or "{" in word:
        return word
    if word.startswith("/"):
        place, homes = Path(word), [Path(home) for home in (*_VISIBLE, sys.prefix, sys.base_prefix)]
        allowed = any(Path(os.path.normpath(place)).is_relative_to(home) for home in homes)
    else:
        place = own / word.removeprefix("./")
        allowed = place.resolve().is_relative_to(own)
    if not allowed or ".." in place.parts:
        raise InputError("a file outside the submission", where=f"{MANIFEST}: run", got=word[:200])
    return str(place) if place.exists() or (first and word.startswith("./")) else word
