"""A submission as bytes, on its way to a worker that does not share our disk."""

from __future__ import annotations

import stat
from dataclasses import dataclass
from pathlib import Path

from minirt.errors import InputError
from reference.jobs.scratch_folders import excess, plain_files
from reports.grade.unpack import MOST_BYTES, MOST_FILES, MOST_PACKED


@dataclass(frozen=True)
class Handed:
    """What a student has handed in.

    Attributes
    ----------
    name : str
        Of the archive, or of the folder.
    content : bytes or dict
        The archive's; or by a file's path in the folder: its bytes, and whether it may be run.
    """

    name: str
    content: bytes | dict[str, tuple[bytes, bool]]

    def put(self, room: Path) -> Path:
        """Put it into a folder, where it has its own name."""
        place = room / self.name
        if isinstance(self.content, bytes):
            place.write_bytes(self.content)
            return place
        place.mkdir()
        for name, (content, executable) in self.content.items():
            path = place / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
            path.chmod(0o755 if executable else 0o644)
        return place


def read_handed(path: Path) -> Handed | None:
    """A submission; None of one that is refused, whoever opens it."""
    try:
        if path.is_symlink():
            return None
        if path.is_dir():
            return _folder(path)
        if not path.is_file() or path.stat().st_size > MOST_PACKED:
            return None
        return Handed(path.name, path.read_bytes())
    except (OSError, InputError):
        return None


def _folder(path: Path) -> Handed | None:
    files = plain_files(path)
    if len(files) > MOST_FILES or excess([path], MOST_BYTES, MOST_BYTES):
        return None
    return Handed(
        path.name,
        {
            str(each.relative_to(path)): (
                each.read_bytes(),
                bool(each.stat().st_mode & stat.S_IXUSR),
            )
            for each in files
        },
    )
