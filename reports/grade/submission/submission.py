"""A submission on disk: rendered frames, or a program with `minirt.toml` beside it."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from minirt.errors import InputError
from minirt.scene import Scene
from reference.compare.precision import Claim, Precision
from reference.jobs.program import Limits, run_program
from reference.renderers.external.command import CommandSubject
from reference.renderers.external.frames import FramesSubject
from reports.grade.assignment.rubric import ProgramLimits, Rubric
from reports.grade.submission.manifest import MANIFEST, Manifest, command_words, read_manifest
from reports.grade.submission.unpack import unpack

#: Folders that hold nothing but one other folder, which are passed on the way to the content.
_MOST_WRAPPERS = 3


@dataclass(frozen=True)
class Submission:
    """A submission, unpacked.

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


def open_submission(path: Path, folder: Path, scenes: Sequence[str], rubric: Rubric) -> Submission:
    """Unpack a submission and find out what it is. Runs in a child process.

    Raises
    ------
    InputError
        It is nothing that can be graded, and why.
    """
    unpack(path, folder)
    root = _content_folder(folder, scenes)
    manifest = read_manifest(root / MANIFEST)
    claimed = manifest.precision or rubric.precision
    if claimed not in (rubric.precision, *rubric.may_claim):
        raise InputError(
            "a precision that this assignment does not take", where=f"{MANIFEST}: precision",
            got=claimed, expected=" or ".join((rubric.precision, *rubric.may_claim)),
        )  # fmt: skip
    if not manifest.run and not _has_frames(root, scenes):
        raise InputError(
            "neither a program nor a frame of any scene", where=MANIFEST,
            expected="the key run, or frames beside it",
        )  # fmt: skip
    if manifest.run:
        command_words(manifest.run, root)
    return Submission(root, manifest, claimed)


def build(submission: Submission, limits: ProgramLimits, sandbox: bool) -> str:
    """Run a program's build command; an error with its last output, or empty."""
    if not submission.manifest.build:
        return ""
    seconds = limits.build_seconds
    bounds = _limits(limits, seconds)
    command = ["sh", "-c", f"\n{submission.manifest.build}"]  # a path alone would become visible
    ended = run_program(command, submission.folder, bounds, sandbox)
    return f"the build {ended.reason}\n{ended.output}".strip() if ended.reason else ""


def subject_of(
    submission: Submission, scene: Scene, limits: ProgramLimits, sandbox: bool
) -> CommandSubject | FramesSubject:
    """A submission as the gate judges it."""
    manifest = submission.manifest
    if not manifest.run:
        exact = (submission.folder / f"{scene.name}.npz").is_file()
        claim = Claim(submission.precision, handed="float64" if exact else "float32")
        return FramesSubject(submission.folder, claim, "submission")
    claim = Claim(submission.precision, handed="float64" if manifest.out_as == "npz" else "float32")
    command = shlex.join(command_words(manifest.run, submission.folder))
    return CommandSubject(
        command, claim, "submission", manifest.scene_as, manifest.out_as,
        _limits(limits, limits.seconds), sandbox, visible=(submission.folder,),
    )  # fmt: skip


def _limits(limits: ProgramLimits, seconds: float) -> Limits:
    return replace(
        Limits(), wall_seconds=seconds, cpu_seconds=4 * seconds, memory=limits.memory_mb * 2**20
    )


def _content_folder(folder: Path, scenes: Sequence[str]) -> Path:
    """The folder of the content: archives often hold a single folder that holds everything."""
    place = folder
    for _ in range(_MOST_WRAPPERS):
        if (place / MANIFEST).is_file() or _has_frames(place, scenes):
            return place
        entries = list(place.iterdir())
        if len(entries) != 1 or not entries[0].is_dir():
            break
        place = entries[0]
    if (place / MANIFEST).is_file() or _has_frames(place, scenes):
        return place
    raise InputError(
        "nothing to grade", got=_first_names(place),
        expected=f"{MANIFEST} with a program, or frames such as {scenes[0]}.npz, {scenes[0]}.exr "
        f"or a folder {scenes[0]}",
    )  # fmt: skip


def _has_frames(place: Path, scenes: Sequence[str]) -> bool:
    names = [f"{scene}{suffix}" for scene in scenes for suffix in (".npz", ".exr", "")]
    return any((place / name).exists() for name in names)


def _first_names(place: Path) -> str:
    names = sorted(path.name for path in place.iterdir())
    return ", ".join(ascii(name)[1:-1][:40] for name in names[:5]) or "nothing"
