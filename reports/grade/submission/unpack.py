"""Submissions as folders: archives unpacked so that nothing can be written anywhere else.

Only plain files and folders are ever made, below an empty folder that was made for them, each
under a name that was checked first; an existing file is never opened.
Sizes are counted while writing: the sizes in an archive's headers are not trusted.
"""

from __future__ import annotations

import lzma
import resource
import shutil
import stat
import tarfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO

from minirt.errors import InputError
from reference.jobs.scratch_folders import MOST_LEVELS, excess, plain_files, size_text

#: What a submission may hold: files, bytes in all, bytes of its archive.
MOST_FILES = 5_000
MOST_BYTES = 2 * 2**30
MOST_PACKED = 2**30
#: Memory that reading an archive's directory may take beyond what the process has.
_MEMORY = 2**30
_BLOCK = 2**20
#: What operating systems and version control leave in folders; ignored.
_SYSTEM_FILES = ("__MACOSX", ".DS_Store", "Thumbs.db", ".git")

SUFFIXES = (".zip", ".tar.gz", ".tgz", ".tar")


@dataclass(frozen=True)
class _Entry:
    """One member of an archive: its name, its kind, and what opens a file's bytes."""

    name: str
    kind: str
    executable: bool
    open: Callable[[], IO[bytes]]


def unpack(submission: Path, folder: Path) -> None:
    """Write the content of a submission into an empty folder, as new plain files.

    Raises
    ------
    InputError
        It holds something that a submission must not hold, or cannot be read.
    """
    if submission.is_symlink():
        raise InputError("a symbolic link, which is not followed", expected="a folder or archive")
    if not (submission.is_dir() or submission.is_file()):
        raise InputError("neither a folder nor a file", expected="a folder or archive")
    try:
        if submission.is_dir():
            _copy(submission, folder)
        else:
            _extract(submission, folder)
    except (OSError, EOFError, RuntimeError, ValueError, MemoryError) as error:
        raise InputError(_reason(error)) from None


def _copy(source: Path, folder: Path) -> None:
    files = plain_files(source)
    if len(files) > MOST_FILES:
        raise InputError(f"more than {MOST_FILES:,} files")
    large = excess([source], MOST_BYTES, MOST_BYTES)
    if large:
        raise InputError(large)
    for path in files:
        name = path.relative_to(source)
        if not _is_system_file(name.parts):
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)
            target.chmod(0o755 if path.stat().st_mode & stat.S_IXUSR else 0o644)


def _extract(archive: Path, folder: Path) -> None:
    if archive.stat().st_size > MOST_PACKED:
        raise InputError(f"the archive is larger than {size_text(MOST_PACKED)}")
    read = _zip_entries if archive.name.lower().endswith(".zip") else _tar_entries
    try:
        with _bounded_memory():
            _write_all(read(archive), folder)
    except InputError:
        raise
    except (zipfile.BadZipFile, tarfile.TarError, zlib.error, lzma.LZMAError) as error:
        raise InputError("the archive cannot be read", got=_reason(error)) from None
    except NotImplementedError as error:
        raise InputError("the archive is packed in a way we cannot read", got=str(error)) from None


def _write_all(entries: Iterator[_Entry], folder: Path) -> None:
    left = MOST_BYTES
    for count, entry in enumerate(entries, start=1):
        if count > MOST_FILES:
            raise InputError(f"more than {MOST_FILES:,} files in the archive")
        parts = _safe_parts(entry.name)
        if entry.kind not in ("file", "folder"):
            raise InputError(f"a {entry.kind} in the archive", where=_printable(entry.name))
        if _is_system_file(parts):
            continue
        target = folder.joinpath(*parts)
        try:
            if entry.kind == "folder":
                target.mkdir(parents=True, exist_ok=True)
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            with target.open("xb") as out, entry.open() as stream:
                left -= _copy_counted(stream, out, left)
        except (FileExistsError, NotADirectoryError):
            raise InputError("a name stands twice", where=_printable(entry.name)) from None
        target.chmod(0o755 if entry.executable else 0o644)


def _copy_counted(stream: IO[bytes], out: IO[bytes], most: int) -> int:
    """Write a member's bytes, counting; returns how many there were."""
    written = 0
    while block := stream.read(_BLOCK):
        written += len(block)
        if written > most:
            raise InputError(f"it unpacks to more than {size_text(MOST_BYTES)}")
        out.write(block)
    return written


def _zip_entries(path: Path) -> Iterator[_Entry]:
    with zipfile.ZipFile(path) as archive:
        for info in archive.infolist():
            if info.flag_bits & 1:
                raise InputError("the archive is locked with a password")
            mode = info.external_attr >> 16
            kind = "folder" if info.is_dir() else _kind(mode)
            yield _Entry(
                info.orig_filename, kind, bool(mode & stat.S_IXUSR),
                partial(archive.open, info),
            )  # fmt: skip


def _kind(mode: int) -> str:
    """What a Unix mode says of a member; archives made elsewhere say nothing."""
    tests = {"symbolic link": stat.S_ISLNK, "pipe": stat.S_ISFIFO, "socket": stat.S_ISSOCK}
    tests |= {"device": lambda mode: stat.S_ISCHR(mode) or stat.S_ISBLK(mode)}
    tests |= {"folder": stat.S_ISDIR}
    return next((name for name, test in tests.items() if test(mode)), "file")


def _tar_entries(path: Path) -> Iterator[_Entry]:
    kinds = {
        tarfile.DIRTYPE: "folder", tarfile.SYMTYPE: "symbolic link", tarfile.LNKTYPE: "hard link",
        tarfile.FIFOTYPE: "pipe",
    }  # fmt: skip
    with tarfile.open(path, "r|*") as archive:
        for member in archive:
            kind = "file" if member.isreg() else kinds.get(member.type, "device")
            yield _Entry(
                member.name, kind, bool(member.mode & stat.S_IXUSR),
                partial(_open_member, archive, member),
            )  # fmt: skip


def _open_member(archive: tarfile.TarFile, member: tarfile.TarInfo) -> IO[bytes]:
    stream = archive.extractfile(member)
    if stream is None:
        raise InputError("a member without bytes in the archive", where=_printable(member.name))
    return stream


def _safe_parts(name: str) -> tuple[str, ...]:
    """The path of a member below the folder; refused where it leads elsewhere."""
    where = _printable(name)
    parts = tuple(part for part in name.split("/") if part not in ("", "."))
    if name.startswith("/") or ":" in name[:2] or "\\" in name or ".." in parts:
        raise InputError("a name that leads out of the archive", where=where)
    if not name.isprintable() or any(len(part.encode(errors="replace")) > 255 for part in parts):
        raise InputError("a name that no file can have here", where=where)
    if len(parts) > MOST_LEVELS:
        raise InputError(f"folders more than {MOST_LEVELS} deep", where=where)
    return parts or (".",)


def _is_system_file(parts: tuple[str, ...]) -> bool:
    return any(part in _SYSTEM_FILES or part.startswith("._") for part in parts)


def _printable(name: str) -> str:
    return ascii(name)[:120]


def _reason(error: BaseException) -> str:
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return " ".join(str(reason).split())[:200]


@contextmanager
def _bounded_memory() -> Iterator[None]:
    """An archive's directory may not grow this process without bound."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    with Path("/proc/self/statm").open(encoding="ascii") as stream:
        used = int(stream.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + _MEMORY, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
