"""What a student has handed in: rendered frames, or a program with `minirt.toml` beside it."""

from __future__ import annotations

import hashlib
import os
import shlex
import stat
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import Field, ValidationError

from minirt.errors import InputError
from minirt.scene import Scene
from reference.compare.precision import Claim, Precision
from reference.jobs.program import Limits, plain_files, run_program
from reference.renderers.external import CommandSubject, FramesSubject, OutAs, SceneAs
from reports.grade.rubric import Bounds, Rubric, first_fault
from reports.grade.unpack import MOST_BYTES, SUFFIXES, take
from reports.results.json_model import Model
from reports.results.words import plain

#: The file that says how a submission is built and run.
MANIFEST = "minirt.toml"
_LONGEST = 64 * 2**10
#: What every program sees in the sandbox.
_SHOWN = ("/usr", "/bin", "/sbin", "/opt")
#: Folders that hold nothing but one other folder, which are passed on the way to the content.
_WRAPPINGS = 3


class Manifest(Model):
    """`minirt.toml` of a submission."""

    build: str = Field(default="", max_length=2000, description="run once, by sh, before all")
    run: str = Field(default="", max_length=2000, description="as 'PROGRAM {scene} {out}'")
    scene_as: SceneAs = "json"
    out_as: OutAs = "exr"
    precision: Precision | None = Field(default=None, description="the number format it claims")


@dataclass(frozen=True)
class Opened:
    """A submission whose files are in a folder of ours.

    Attributes
    ----------
    folder : Path
        Of the frames, or of the program.
    manifest : Manifest
    precision : str
        The number format that is claimed.
    """

    folder: Path
    manifest: Manifest
    precision: Precision

    @property
    def is_program(self) -> bool:
        """Whether it is run; else it holds frames."""
        return bool(self.manifest.run)


def students_in(folder: Path) -> dict[str, Path]:
    """The submissions of a folder by student: the names of its archives and folders.

    Raises
    ------
    InputError
        There is none, or a student has two.
    """
    if not folder.is_dir():
        raise InputError("no such folder of submissions", where=str(folder))
    found: dict[str, Path] = {}
    for path in sorted(folder.iterdir()):
        suffix = next((s for s in SUFFIXES if path.name.lower().endswith(s)), "")
        if path.name.startswith(".") or not (suffix or path.is_dir() or path.is_symlink()):
            continue
        name = path.name[: len(path.name) - len(suffix)]
        if name in found:
            raise InputError(
                "two submissions of one student", where=str(folder),
                got=plain(f"{found[name].name} and {path.name}"), expected="one of them",
            )  # fmt: skip
        found[name] = path
    if not found:
        raise InputError(
            "no submission in the folder", where=str(folder),
            expected=f"a folder a student, or {', '.join(SUFFIXES)}",
        )  # fmt: skip
    return found


def left_aside(folder: Path) -> list[str]:
    """Names of what lies among the submissions and is none: perhaps an archive of another kind."""
    return [
        path.name
        for path in sorted(folder.iterdir())
        if not path.is_dir()
        and not path.name.startswith(".")
        and not path.name.lower().endswith(SUFFIXES)
    ]


def digest_of(path: Path) -> str:
    """SHA-256 of all that a submission holds; of one that will be refused, of why."""
    digest = hashlib.sha256()
    try:
        folder = path.is_dir() and not path.is_symlink()
        files = plain_files(path) if folder else [path]
        for each in files:
            digest.update(str(each.relative_to(path)).encode(errors="surrogateescape") + b"\0")
            if each.is_symlink() or not each.is_file() or each.stat().st_size > MOST_BYTES:
                digest.update(b"not read")
                continue
            digest.update(b"run" if each.stat().st_mode & stat.S_IXUSR else b"read")
            with each.open("rb") as stream:
                digest.update(hashlib.file_digest(stream, "sha256").digest())
    except (OSError, InputError) as error:
        digest.update(str(error).encode(errors="replace"))
    return digest.hexdigest()


def open_submission(
    submission: Path, folder: Path, scenes: Sequence[str], rubric: Rubric
) -> Opened:
    """Unpack a submission and find out what it is. Runs in a child process.

    Raises
    ------
    InputError
        It is nothing that can be graded, and why.
    """
    take(submission, folder)
    root = _root(folder, scenes)
    manifest = _manifest(root / MANIFEST)
    claimed = manifest.precision or rubric.precision
    if claimed not in (rubric.precision, *rubric.may_claim):
        raise InputError(
            "a precision that this assignment does not take", where=f"{MANIFEST}: precision",
            got=claimed, expected=" or ".join((rubric.precision, *rubric.may_claim)),
        )  # fmt: skip
    if not manifest.run and not _frames(root, scenes):
        raise InputError(
            "neither a program nor a frame of any scene", where=MANIFEST,
            expected="the key run, or frames beside it",
        )  # fmt: skip
    if manifest.run:
        _words(manifest.run, root)
    return Opened(root, manifest, claimed)


def build(opened: Opened, bounds: Bounds, sandbox: bool) -> str:
    """Run a program's build command; what went wrong, with its last output, or nothing."""
    if not opened.manifest.build:
        return ""
    seconds = bounds.build_seconds
    limits = _limits(bounds, seconds)
    command = ["sh", "-c", f"\n{opened.manifest.build}"]  # a path alone would become visible
    ended = run_program(command, opened.folder, limits, sandbox)
    return f"the build {ended.reason}\n{ended.output}".strip() if ended.reason else ""


def subject_of(
    opened: Opened, scene: Scene, bounds: Bounds, sandbox: bool
) -> CommandSubject | FramesSubject:
    """A submission as the gate judges it."""
    manifest = opened.manifest
    if not manifest.run:
        exact = (opened.folder / f"{scene.name}.npz").is_file()
        claim = Claim(opened.precision, handed="float64" if exact else "float32")
        return FramesSubject(opened.folder, claim, "submission")
    claim = Claim(opened.precision, handed="float64" if manifest.out_as == "npz" else "float32")
    command = shlex.join(_words(manifest.run, opened.folder))
    return CommandSubject(
        command, claim, "submission", manifest.scene_as, manifest.out_as,
        _limits(bounds, bounds.seconds), sandbox, visible=(opened.folder,),
    )  # fmt: skip


def _limits(bounds: Bounds, seconds: float) -> Limits:
    return replace(
        Limits(), wall_seconds=seconds, cpu_seconds=4 * seconds, memory=bounds.memory_mb * 2**20
    )


def _words(command: str, folder: Path) -> list[str]:
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
    return [_word(word, folder.resolve(), first=k == 0) for k, word in enumerate(words)]


def _word(word: str, own: Path, first: bool) -> str:
    """A word, absolute where it names a file of the submission.

    The sandbox shows each file that its command names. So no word may name one that is neither
    the submission's nor shown anyway: the rubric, say, or what somebody else has handed in.
    """
    if word.startswith("-") or "{" in word:
        return word
    if word.startswith("/"):
        place, homes = Path(word), [Path(home) for home in (*_SHOWN, sys.prefix, sys.base_prefix)]
        allowed = any(Path(os.path.normpath(place)).is_relative_to(home) for home in homes)
    else:
        place = own / word.removeprefix("./")
        allowed = place.resolve().is_relative_to(own)
    if not allowed or ".." in place.parts:
        raise InputError("a file outside the submission", where=f"{MANIFEST}: run", got=word[:200])
    return str(place) if place.exists() or (first and word.startswith("./")) else word


def _root(folder: Path, scenes: Sequence[str]) -> Path:
    """Where the content begins: archives often hold one folder that holds everything."""
    place = folder
    for _ in range(_WRAPPINGS):
        if (place / MANIFEST).is_file() or _frames(place, scenes):
            return place
        entries = list(place.iterdir())
        if len(entries) != 1 or not entries[0].is_dir():
            break
        place = entries[0]
    if (place / MANIFEST).is_file() or _frames(place, scenes):
        return place
    raise InputError(
        "nothing to grade", got=_listed(place),
        expected=f"{MANIFEST} with a program, or frames such as {scenes[0]}.npz, {scenes[0]}.exr "
        f"or a folder {scenes[0]}",
    )  # fmt: skip


def _frames(place: Path, scenes: Sequence[str]) -> bool:
    names = [f"{scene}{suffix}" for scene in scenes for suffix in (".npz", ".exr", "")]
    return any((place / name).exists() for name in names)


def _listed(place: Path) -> str:
    names = sorted(path.name for path in place.iterdir())
    return ", ".join(ascii(name)[1:-1][:40] for name in names[:5]) or "nothing"


def _manifest(path: Path) -> Manifest:
    if not path.is_file():
        return Manifest()
    if path.stat().st_size > _LONGEST:
        raise InputError("too long", where=MANIFEST, expected="at most 64 KiB")
    try:
        return Manifest.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except (ValueError, RecursionError) as error:
        if isinstance(error, ValidationError):
            raise first_fault(error, MANIFEST) from None
        raise InputError("not TOML", where=MANIFEST, got=str(error)[:200]) from None
