"""Hostile archives: whatever they hold, nothing is written outside their own folder."""

from __future__ import annotations

import io
import os
import stat
import tarfile
import zipfile
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import pytest

from minirt.errors import InputError
from reports.grade.submission import unpack as unpacking
from reports.grade.submission.unpack import unpack
from tests.helpers.tiers import tiered

Maker = Callable[[Path], None]


def zipped(*members: tuple[str, bytes], mode: int = 0o644, system: int = 3) -> Maker:
    def make(path: Path) -> None:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in members:
                info = zipfile.ZipInfo(name)
                info.filename = info.orig_filename = name
                info.compress_type = zipfile.ZIP_DEFLATED
                info.create_system, info.external_attr = system, mode << 16
                twice = name in archive.namelist()
                with pytest.warns(UserWarning, match="Duplicate") if twice else nullcontext():
                    archive.writestr(info, data)

    return make


def tarred(*members: tuple[str, bytes, bytes, str]) -> Maker:
    """Members as (name, type, data, link)."""

    def make(path: Path) -> None:
        with tarfile.open(path, "w:gz") as archive:
            for name, kind, data, link in members:
                info = tarfile.TarInfo(name)
                info.type, info.size, info.linkname = kind, len(data), link
                archive.addfile(info, io.BytesIO(data))

    return make


def raw(data: bytes) -> Maker:
    def make(path: Path) -> None:
        path.write_bytes(data)

    return make


def bomb(path: Path) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("zeros.npz", bytes(3 * 2**20))


def lying_bomb(path: Path) -> None:
    """Its headers promise a hundred bytes."""
    bomb(path)
    data = path.read_bytes().replace((3 * 2**20).to_bytes(4, "little"), b"\x64\0\0\0")
    path.write_bytes(data)


FILE, LINK, HARD = tarfile.REGTYPE, tarfile.SYMTYPE, tarfile.LNKTYPE

HOSTILE: dict[str, tuple[str, Maker, str]] = {
    "zip-dot-dot": (".zip", zipped(("../evil.txt", b"x")), "leads out"),
    "zip-deep-dot-dot": (".zip", zipped(("a/b/../../../evil.txt", b"x")), "leads out"),
    "zip-absolute": (".zip", zipped(("/tmp/evil.txt", b"x")), "leads out"),  # noqa: S108
    "zip-drive": (".zip", zipped(("C:/evil.txt", b"x")), "leads out"),
    "zip-backslash": (".zip", zipped(("..\\evil.txt", b"x")), "leads out"),
    "zip-symlink": (".zip", zipped(("l", b"/etc"), mode=stat.S_IFLNK | 0o777), "symbolic link"),
    "zip-device": (".zip", zipped(("d", b""), mode=stat.S_IFCHR | 0o666), "a device"),
    "zip-pipe": (".zip", zipped(("p", b""), mode=stat.S_IFIFO | 0o666), "a pipe"),
    "zip-twice": (".zip", zipped(("a", b"1"), ("a", b"2")), "stands twice"),
    "zip-file-as-folder": (".zip", zipped(("a", b"1"), ("a/b", b"2")), "stands twice"),
    "zip-controls": (".zip", zipped(("a\x1b[2J", b"1")), "no file can have"),
    "zip-reordering": (".zip", zipped(("a\u202egnp", b"1")), "no file can have"),
    "zip-long": (".zip", zipped(("x" * 300, b"1")), "no file can have"),
    "zip-deep": (".zip", zipped(("d/" * 40 + "f", b"1")), "deep"),
    "zip-many": (".zip", zipped(*((f"{k}", b"") for k in range(10_000))), "more than 5,000"),
    "zip-bomb": (".zip", bomb, "unpacks to more"),
    "zip-lying-bomb": (".zip", lying_bomb, "cannot be read|unpacks to more"),
    "zip-garbage": (".zip", raw(os.urandom(5000)), "cannot be read"),
    "zip-empty-file": (".zip", raw(b""), "cannot be read"),
    "tar-dot-dot": (".tar.gz", tarred(("../evil.txt", FILE, b"x", "")), "leads out"),
    "tar-absolute": (".tar.gz", tarred(("/tmp/evil.txt", FILE, b"x", "")), "leads out"),  # noqa: S108
    "tar-symlink": (
        ".tar.gz",
        tarred(("out", LINK, b"", ".."), ("out/evil.txt", FILE, b"x", "")),
        "symbolic link",
    ),
    "tar-hard-link": (".tar.gz", tarred(("passwd", HARD, b"", "/etc/passwd")), "hard link"),
    "tar-device": (".tar.gz", tarred(("null", tarfile.CHRTYPE, b"", "")), "a device"),
    "tar-block": (".tar.gz", tarred(("sda", tarfile.BLKTYPE, b"", "")), "a device"),
    "tar-pipe": (".tar.gz", tarred(("p", tarfile.FIFOTYPE, b"", "")), "a pipe"),
    "tar-twice": (".tar.gz", tarred(("a", FILE, b"1", ""), ("a", FILE, b"2", "")), "twice"),
    "tar-latin": (".tar.gz", tarred(("caf\udce9", FILE, b"1", "")), "no file can have"),
    "tar-bomb": (".tar.gz", tarred(("z", FILE, bytes(3 * 2**20), "")), "unpacks to more"),
    "tar-many": (
        ".tar.gz", tarred(*((f"{k}", FILE, b"", "") for k in range(6_000))), "more than 5,000",
    ),
    "tar-garbage": (".tar.gz", raw(os.urandom(5000)), "cannot be read"),
    "tar-truncated": (".tar.gz", raw(b"\x1f\x8b\x08\0\0\0\0\0\0\x03abc"), "read|ended|Error"),
}  # fmt: skip


@pytest.fixture
def place(tmp_path: Path) -> Path:
    (tmp_path / "room" / "inside").mkdir(parents=True)
    return tmp_path


def snapshot(folder: Path) -> list[tuple[str, int]]:
    """All that lies in a folder but in the one that is unpacked into."""
    paths = [p for p in folder.rglob("*") if "inside" not in p.parts]
    return sorted((str(p), p.lstat().st_size) for p in paths if p.is_file() or p.is_symlink())


@pytest.mark.parametrize("name", tiered(HOSTILE, lambda name: not name.endswith("-many")))
def test_a_hostile_archive_stays_in_its_folder(
    name: str, place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    suffix, make, words = HOSTILE[name]
    archive = place / f"student{suffix}"
    make(archive)
    if "bomb" in name:
        monkeypatch.setattr(unpacking, "MOST_BYTES", 2**20)
    before = snapshot(place)
    inside = place / "room" / "inside"
    with pytest.raises(InputError, match=words):
        unpack(archive, inside)
    assert snapshot(place) == before
    assert not (place / "evil.txt").exists()
    found = list(inside.rglob("*"))
    assert all(not p.is_symlink() and (p.is_dir() or p.is_file()) for p in found)
    assert sum(p.stat().st_size for p in found if p.is_file()) <= 2 * 2**20


def test_names_in_other_alphabets_are_names(place: Path) -> None:
    make = zipped(("ćŕęšć/жůλ.txt", b"1"), ("__MACOSX/._x", b"2"), ("a/.DS_Store", b"3"))
    make(place / "s.zip")
    unpack(place / "s.zip", place / "room" / "inside")
    assert (place / "room" / "inside" / "ćŕęšć" / "жůλ.txt").read_bytes() == b"1"
    files = [p for p in (place / "room" / "inside").rglob("*") if p.is_file()]
    assert len(files) == 1


def test_what_is_executable_stays_so(place: Path) -> None:
    zipped(("run.sh", b"#!/bin/sh\n"), mode=stat.S_IFREG | 0o755)(place / "s.zip")
    unpack(place / "s.zip", place / "room" / "inside")
    assert (place / "room" / "inside" / "run.sh").stat().st_mode & 0o777 == 0o755


def test_a_folder_is_copied_without_links(place: Path) -> None:
    folder = place / "student"
    folder.mkdir()
    (folder / "a.txt").write_text("1", encoding="utf-8")
    unpack(folder, place / "room" / "inside")
    assert (place / "room" / "inside" / "a.txt").read_text(encoding="utf-8") == "1"
    (folder / "b").symlink_to("/etc/passwd")
    with pytest.raises(InputError, match="symbolic link"):
        unpack(folder, place / "room" / "inside")


def test_a_link_in_the_place_of_a_submission_is_not_followed(place: Path) -> None:
    (place / "student").symlink_to(place / "room")
    with pytest.raises(InputError, match="symbolic link"):
        unpack(place / "student", place / "room" / "inside")


def test_a_pipe_in_the_place_of_a_submission_is_not_opened(place: Path) -> None:
    os.mkfifo(place / "student.zip")
    with pytest.raises(InputError, match="neither a folder nor a file"):
        unpack(place / "student.zip", place / "room" / "inside")
