"""The submissions of a class: one folder or archive for each student."""

from __future__ import annotations

import hashlib
import stat
from pathlib import Path

from minirt.errors import InputError
from reference.jobs.program import plain_files
from reports.grade.submission.unpack import MOST_BYTES, SUFFIXES
from reports.results.words import plain


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


def ignored_files(folder: Path) -> list[str]:
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
