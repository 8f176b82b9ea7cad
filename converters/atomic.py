"""Atomic writing: files and folders appear complete or not at all, whatever happens meanwhile."""

from __future__ import annotations

import contextlib
import ctypes
import os
import secrets
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from minirt.errors import InputError

_AT_FDCWD = -100
_RENAME_EXCHANGE = 2


@contextmanager
def atomic_file(path: str | Path) -> Iterator[Path]:
    """A path to write to, which takes the place of `path` when the block ends without an error.

    The temporary file lies beside the target, under a hidden name with the target's suffix. On an
    error it is removed; after a crash or a power cut it may remain, but `path` itself is either
    the complete old file or the complete new one. A link at `path` is followed.

    Parameters
    ----------
    path : path
        The target; its folder must exist.

    Yields
    ------
    Path
        Does not exist yet.

    Raises
    ------
    InputError
        The target or its folder cannot be written, or the disk is full.
    """
    target, kind = _target(path)
    if kind not in ("file", "nothing"):
        raise InputError("cannot be replaced", where=str(path), got=kind, expected="a file's name")
    temporary = target.with_name(f".{secrets.token_hex(8)}{target.suffix}")
    try:
        yield temporary
        _synchronise(temporary)
        temporary.replace(target)
        _synchronise(target.parent)
    except OSError as error:
        raise _cannot_write(path, error) from None
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: str | Path) -> Iterator[Path]:
    """An empty folder to fill, which takes the place of `path` when the block ends well.

    The old folder is deleted with its content: whether that is wanted is for the caller to decide.
    Where the system can exchange two names in one step (Linux), `path` is at every moment the old
    folder or the new one; elsewhere it is missing for the moment between two renamings.

    Parameters
    ----------
    path : path
        The target; the folder that holds it must exist.

    Yields
    ------
    Path
        An empty folder beside the target.

    Raises
    ------
    InputError
        The target is a file, or it or its folder cannot be written, or the disk is full.
    """
    target, kind = _target(path)
    if kind not in ("folder", "nothing"):
        raise InputError(
            "cannot be replaced", where=str(path), got=kind, expected="a folder's name"
        )
    temporary = target.with_name(f".{secrets.token_hex(8)}")
    try:
        temporary.mkdir()
        yield temporary
        for entry in temporary.rglob("*"):
            _synchronise(entry)
        _synchronise(temporary)
        _put_in_place(temporary, target)
        _synchronise(target.parent)
    except OSError as error:
        raise _cannot_write(path, error) from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def require_replaceable(folder: Path, patterns: Sequence[str]) -> None:
    """Refuse to replace a folder that is not an earlier export.

    Parameters
    ----------
    folder : Path
        May not exist.
    patterns : sequence of str
        Patterns of the names of an export's files.

    Raises
    ------
    InputError
        The folder holds any other file.
    """
    for entry in sorted(folder.iterdir()) if folder.is_dir() else ():
        if not any(entry.match(pattern) for pattern in patterns):
            raise InputError(
                "the folder holds other files",
                where=str(folder),
                got=entry.name,
                expected="a new or empty folder, or an earlier export",
            )


def _target(path: str | Path) -> tuple[Path, str]:
    """The target, with links followed, in a folder that exists; and what is there now."""
    try:
        target = Path(path).resolve()
        if not target.parent.is_dir():
            raise FileNotFoundError("no such folder")
        target.exists()  # raises for a name that the file system does not allow
    except (OSError, ValueError, RuntimeError) as error:  # RuntimeError: a loop of links
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError("cannot be written", where=repr(str(path))[:300], got=reason) from None
    if target.is_dir():
        return target, "folder"
    if target.is_file():
        return target, "file"
    return target, "device or pipe" if target.exists() else "nothing"


def _put_in_place(temporary: Path, target: Path) -> None:
    """Give a new folder the target's name; what was there ends up under the temporary name."""
    if not target.exists():
        temporary.rename(target)
    elif not _exchange(temporary, target):
        old = target.with_name(f".{secrets.token_hex(8)}")
        target.rename(old)
        temporary.rename(target)
        old.rename(temporary)


def _exchange(first: Path, second: Path) -> bool:
    """Exchange two names in one step; False where the system or the file system cannot."""
    rename = getattr(ctypes.CDLL(None), "renameat2", None)
    if rename is None:
        return False
    status: int = rename(
        _AT_FDCWD, os.fsencode(first), _AT_FDCWD, os.fsencode(second), _RENAME_EXCHANGE
    )
    return status == 0


def _synchronise(path: Path) -> None:
    """Wait until a file's bytes, or a folder's names, are on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError) if path.is_dir() else contextlib.nullcontext():
            os.fsync(descriptor)  # some file systems refuse it for folders
    finally:
        os.close(descriptor)


def _cannot_write(path: str | Path, error: OSError) -> InputError:
    return InputError("cannot be written", where=str(path), got=error.strerror or str(error))
