"""Folders that another author's program can write to: their sizes, and the files in them.

Nothing in them is trusted: a symbolic link may point to anything.
"""

from __future__ import annotations

import os
import stat
import subprocess
from collections.abc import Iterator
from pathlib import Path

from minirt.errors import InputError

#: Far more entries and levels than a frame needs; counting them must not take long.
MOST_ENTRIES = 10_000
MOST_LEVELS = 32


def plain_files(folder: Path) -> list[Path]:
    """Every file in a folder, sorted; each can be read without leaving the folder.

    Call it after all programs that write there have ended, and before anything there is read.

    Raises
    ------
    InputError
        A symbolic link, a second name of a file (a hard link), a device, a pipe or a socket, a
        name that cannot be shown, or too many entries. The message names the first one.
    """
    found = []
    try:
        if not stat.S_ISDIR(folder.lstat().st_mode):
            raise InputError("not a folder", where=str(folder))
        for count, (entry, level) in enumerate(_entries(folder), start=1):
            if count > MOST_ENTRIES or level > MOST_LEVELS:
                raise InputError(_too_many(level), where=str(folder))
            if _is_file(entry, folder):
                found.append(Path(entry.path))
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise InputError("the folder cannot be read", where=str(folder), got=reason) from None
    return sorted(found)


def excess(folders: list[Path], most_file: int, most_in_all: int, beside: int = 0) -> str:
    """What is too large in the folders of a running program, as a sentence; else empty.

    Parameters
    ----------
    folders : list of path
    most_file, most_in_all : int
        Bytes of one file, and of all files; of length and space on the disk the larger counts.
    beside : int
        Bytes of files that are in no folder, which count too.
    """
    total, count = beside, 0
    for folder in folders:
        try:
            for entry, level in _entries(folder):
                count += 1
                if count > MOST_ENTRIES or level > MOST_LEVELS:
                    return _too_many(level)
                here = entry.stat(follow_symlinks=False)
                if not stat.S_ISREG(here.st_mode):
                    continue
                if here.st_size > most_file:
                    return f"one of its files grew beyond {size_text(most_file)}"
                total += max(here.st_size, 512 * here.st_blocks)
        except FileNotFoundError:  # it has just been removed
            continue
        except OSError as error:
            return f"its folder cannot be looked through: {error.strerror}"
    return f"its files grew beyond {size_text(most_in_all)} in all" if total > most_in_all else ""


def hand_over(folders: list[Path], uid: int, gid: int) -> None:
    """Give folders and all their entries to a user, as far as that is allowed.

    Unreadable files become readable, and no file keeps its set-user-ID or set-group-ID. `chmod` and
    `chown` walk folders of any depth and follow no link in them.
    """
    for command in (["chmod", "-R", "u+rwX,u-s,g-s"], ["chown", "-RhP", f"{uid}:{gid}"]):
        subprocess.run([*command, "--", *map(str, folders)], capture_output=True, check=False)


def remove(folder: Path) -> None:
    """Remove a folder of any depth without following links in it."""
    command = ["rm", "-rf", "--", str(folder)]
    subprocess.run(command, capture_output=True, check=False)


def size_text(count: int) -> str:
    """A number of bytes with its unit, such as 2 GiB."""
    for unit, name in ((2**30, "GiB"), (2**20, "MiB"), (2**10, "KiB")):
        if count >= unit:
            return f"{count / unit:.3g} {name}"
    return f"{count} bytes"


def _entries(folder: Path) -> Iterator[tuple[os.DirEntry[str], int]]:
    """Each entry below a folder, with its level; links are not followed, nor levels too deep."""
    waiting = [(str(folder), 1)]
    while waiting:
        place, level = waiting.pop()
        with os.scandir(place) as entries:
            for entry in entries:
                yield entry, level
                if entry.is_dir(follow_symlinks=False) and level <= MOST_LEVELS:
                    waiting.append((entry.path, level + 1))


def _too_many(level: int) -> str:
    if level > MOST_LEVELS:
        return f"its folders nest more than {MOST_LEVELS} deep"
    return f"its folder holds more than {MOST_ENTRIES:,} files"


def _is_file(entry: os.DirEntry[str], folder: Path) -> bool:
    """Whether it is a file, not a folder; everything else is refused."""
    name = os.path.relpath(entry.path, folder)
    where = f"{folder}: {ascii(name)[:200]}"
    if not name.isprintable():
        raise InputError("a name that cannot be shown", where=where)
    here = entry.stat(follow_symlinks=False)
    kind = _kind(here.st_mode)
    if kind not in ("file", "folder"):
        raise InputError(f"a {kind} among the files, which is not read", where=where)
    if kind == "file" and here.st_nlink > 1:
        raise InputError("a file with a second name (hard link), which is not read", where=where)
    return kind == "file"


def _kind(mode: int) -> str:
    tests = {
        "file": stat.S_ISREG,
        "folder": stat.S_ISDIR,
        "symbolic link": stat.S_ISLNK,
        "pipe": stat.S_ISFIFO,
        "socket": stat.S_ISSOCK,
    }
    return next((name for name, test in tests.items() if test(mode)), "device")
