"""`manifest.json`: what a pack holds, down to the bytes, and who confirmed it."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError

from minirt.errors import InputError
from minirt.frame import Array
from reports.results.json_model import Model, Natural, Number

#: The manifest, and the file with its own SHA-256, as `sha256sum -c` takes it.
MANIFEST, CHECKSUM = "manifest.json", "manifest.sha256"


class ChangedManifest(InputError):
    """A manifest that is not the one its checksum was written for."""


class ToleranceModel(Model):
    """How strictly a renderer of some precision can be judged by a quantity."""

    certain: Natural = Field(description="pixels that its errors leave certain")
    median: Number | None = Field(description="tolerance; null for a discrete quantity")
    largest: Number | None


class QuantityModel(Model):
    """One quantity of a frame."""

    sha256: str = Field(description="of its bytes in C order, in NumPy's little-endian type")
    dtype: str
    shape: list[Natural]
    confirmed_by: list[str] = Field(
        description="references that agree wherever they can be judged; 'judge' where exact "
        "arithmetic has decided pixels and agrees; empty: not checked"
    )
    precisions: dict[str, ToleranceModel]


class SceneEntry(Model):
    """One scene of a pack."""

    name: str
    folder: str = Field(pattern=r"^[A-Za-z0-9_][A-Za-z0-9._-]*$", description="in the pack")
    sha256: str = Field(description="of the scene's canonical JSON")
    nx: Natural
    ny: Natural
    quantities: dict[str, QuantityModel]
    files: dict[str, str] = Field(description="SHA-256 of each file, by its path in the folder")


class Approval(Model):
    """A scene whose frame was replaced on purpose."""

    scene: str
    who: str
    why: str
    old: dict[str, str] = Field(description="SHA-256 by quantity; empty for a scene that was new")
    new: dict[str, str]


class Manifest(Model):
    """The content of a pack of reference images. It holds no time and no place."""

    minirtPack: Literal[1] = Field(description="version of this format")  # noqa: N815
    versions: dict[str, str]
    references: dict[str, str] = Field(description="what really ran, by reference")
    required: list[str] = Field(description="references without which the pack is refused")
    scenes: list[SceneEntry]
    approvals: list[Approval] = Field(default=[], description="the oldest first")

    def entry(self, name: str) -> SceneEntry | None:
        """The scene of that name."""
        return next((entry for entry in self.scenes if entry.name == name), None)


def read_manifest(pack: Path) -> Manifest:
    """The manifest of a pack.

    Raises
    ------
    ChangedManifest
        It was changed after it was written, or its checksum was.
    InputError
        There is none, or it is not one.
    """
    try:
        text = (pack / MANIFEST).read_bytes()
        written = (pack / CHECKSUM).read_text(encoding="ascii").split()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            "not a pack", where=str(pack), got=reason, expected=f"{MANIFEST} and {CHECKSUM}"
        ) from None
    if written[:1] != [hashlib.sha256(text).hexdigest()]:
        raise ChangedManifest(
            f"{MANIFEST} is not the one that {CHECKSUM} was written for", where=str(pack)
        )
    try:
        return Manifest.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        raise InputError(
            f"not a pack's manifest: {first['msg']}", where=f"{pack / MANIFEST}: {place}"
        ) from None


def write_manifest(manifest: Manifest, folder: Path) -> None:
    """Write the manifest and its checksum. Not atomic: the folder is."""
    text = json.dumps(manifest.model_dump(mode="json"), indent=1, sort_keys=True) + "\n"
    (folder / MANIFEST).write_text(text, encoding="ascii", newline="\n")
    checksum = hashlib.sha256(text.encode("ascii")).hexdigest()
    (folder / CHECKSUM).write_text(f"{checksum}  {MANIFEST}\n", encoding="ascii", newline="\n")


def array_hash(array: Array) -> str:
    """SHA-256 of an array's bytes, in C order."""
    return hashlib.sha256(array.tobytes()).hexdigest()


def file_hash(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def files_in(folder: Path) -> dict[str, str]:
    """SHA-256 of each file below a folder, by its path there."""
    found = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): file_hash(path) for path in found}
