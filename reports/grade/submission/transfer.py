"""A submission as bytes, sent to a worker that does not share this machine's disk."""

from __future__ import annotations

import stat
from dataclasses import dataclass
from pathlib import Path

from minirt.errors import InputError
from reference.jobs.scratch_folders import excess, plain_files
from reports.grade.submission.unpack import MOST_BYTES, MOST_FILES, MOST_PACKED


@dataclass(frozen=True)
class SubmissionBytes:
    """The content of a submission.

    Attributes
    ----------
    name : str
        Of the archive, or of the folder.
    content : bytes or dict
        The bytes of an archive; of a folder, by path: the bytes, and whether it is executable.
    """

    name: str
    content: bytes | dict[str, tuple[bytes, bool]]

    def write_into(self, folder: Path) -> Path:
        """Write the submission into a folder, under its own name."""
        path = folder / self.name
        if isinstance(self.content, bytes):
            path.write_bytes(self.content)
            return path
        path.mkdir()
        for name, (content, executable) in self.content.items():
            file = path / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
            file.chmod(0o755 if executable else 0o644)
        return path


def read_submission(path: Path) -> SubmissionBytes | None:
    """The bytes of a submission; None where it will be refused in any case."""
    try:
        if path.is_symlink():
            return None
        if path.is_dir():
            return _folder(path)
        if not path.is_file() or path.stat().st_size > MOST_PACKED:
            return None
        return SubmissionBytes(path.name, path.read_bytes())
    except (OSError, InputError):
        return None


def _folder(path: Path) -> SubmissionBytes | None:
    files = plain_files(path)
    if len(files) > MOST_FILES or excess([path], MOST_BYTES, MOST_BYTES):
        return None
    return SubmissionBytes(
        path.name,
        {
            str(each.relative_to(path)): (
                each.read_bytes(),
                bool(each.stat().st_mode & stat.S_IXUSR),
            )
            for each in files
        },
    )
