"""One night's folder, and the note of what is done in it.

`night.json` is written whole after every step, so that a night that was killed goes on with what
is missing. A lock that ends with its process tells a night that is still at work.
"""

from __future__ import annotations

import fcntl
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationError

from converters.atomic import atomic_file
from reports.results.json_model import Model, Natural

#: A killed night is gone on with for so long; then a new one begins.
RESUMABLE = timedelta(hours=24)
NAME = re.compile(r"\d{4}-\d\d-\d\d(-\d+)?")
FILE = "night.json"
_LOCK, _REMOVED = ".lock", ".removed-"


def _of_a_zone(text: str) -> str:
    """A time that can be set beside others."""
    if datetime.fromisoformat(text).tzinfo is None:
        raise ValueError("a time without its offset from UTC")
    return text


class StepModel(Model):
    """How one step ended."""

    exit_status: int = Field(ge=0, le=3)
    sentence: str = Field(description="for people")
    seconds: float


class SettingsModel(Model):
    """What a night was asked for; a night goes on only with the same."""

    commit: str | None
    scenes: list[str] = Field(description="SHA-256 of each")
    references: list[str]
    required: list[str]
    budget: float = Field(description="seconds of fuzzing")
    mutants: list[str] = Field(description="empty: all")


class NightModel(Model):
    """`night.json`."""

    minirtNight: Literal[1] = Field(default=1, description="version of this format")  # noqa: N815
    started: Annotated[str, AfterValidator(_of_a_zone)] = Field(description="ISO 8601, UTC")
    number: Natural = Field(
        default=0, description="in the order in which nights began, whatever a clock says"
    )
    seed: Natural = Field(description="of the first round of fuzzing")
    settings: SettingsModel
    steps: dict[str, StepModel] = Field(default={})
    run: int | None = Field(default=None, description="number of the run in the history")
    finished: str | None = None

    @property
    def exit_status(self) -> int:
        """1 where a step failed, else 3 where one is incomplete, else 0."""
        found = {step.exit_status for step in self.steps.values()}
        return 1 if 1 in found else max(found, default=3)


@dataclass
class Night:
    """A night's folder and its note."""

    folder: Path
    note: NightModel

    @property
    def name(self) -> str:
        """The day, and a number from the second night of a day on."""
        return self.folder.name

    def done(self, step: str, result: StepModel, **also: int | str | None) -> None:
        """Note that a step is done."""
        steps = {**self.note.steps, step: result}
        self.save(steps=steps, **also)

    def save(self, **changes: object) -> None:
        """Change the note, and write it."""
        self.note = self.note.model_copy(update=changes)
        write(self.folder / FILE, self.note.model_dump_json(indent=1) + "\n")


def write(path: Path, text: str) -> None:
    """A file of a night, whole or not at all."""
    with atomic_file(path) as new:
        new.write_text(text, encoding="utf-8", newline="\n")


@contextmanager
def begun(out: Path, settings: SettingsModel) -> Iterator[Night]:
    """The night that was killed with these settings, or a new one; locked until the block ends.

    Parameters
    ----------
    out : Path
        Exists.
    settings : SettingsModel
    """
    now = datetime.now(UTC)
    earlier = nights(out)
    for night in reversed(earlier):
        if _resumable(night, settings, now):
            with _locked(night.folder / _LOCK, wait=False) as ours:
                fresh = _read(night.folder) if ours else None
                if fresh is not None and _resumable(fresh, settings, now):
                    yield fresh
                    return
    folder = _new_folder(out, now)
    with _locked(folder / _LOCK, wait=True):
        note = NightModel(
            started=now.isoformat(timespec="microseconds"),
            number=max((night.note.number for night in earlier), default=0) + 1,
            seed=secrets.randbits(32),
            settings=settings,
        )
        night = Night(folder, note)
        night.save()
        yield night


def nights(out: Path) -> list[Night]:
    """Every night of a folder that can be read, oldest first."""
    found = [night for night in map(_read, _folders(out)) if night is not None]
    return sorted(found, key=lambda n: (n.note.number, n.note.started, n.name))


def unreadable(out: Path) -> list[str]:
    """The names of the folders of nights whose note cannot be read."""
    return sorted(path.name for path in _folders(out) if _read(path) is None)


@contextmanager
def alone(out: Path) -> Iterator[None]:
    """Nobody else changes what all nights of a folder share."""
    with _locked(out / _LOCK, wait=True):
        yield


def remove_old(out: Path, keep: int, current: Night) -> list[str]:
    """Remove all but the newest nights; those at work stay. The history keeps their runs.

    Returns
    -------
    list of str
        The names of those removed.
    """
    for left in out.glob(f"{_REMOVED}*"):  # of a kill in the midst of this
        shutil.rmtree(left, ignore_errors=True)
    removed = []
    for night in nights(out)[:-keep]:
        if night.name == current.name:
            continue  # its lock is this process's own
        with _locked(night.folder / _LOCK, wait=False) as ours:
            if ours:
                away = out / f"{_REMOVED}{night.name}-{secrets.token_hex(4)}"
                night.folder.rename(away)
                shutil.rmtree(away, ignore_errors=True)
                removed.append(night.name)
    return removed


def _resumable(night: Night, settings: SettingsModel, now: datetime) -> bool:
    note = night.note
    recent = now - datetime.fromisoformat(note.started) < RESUMABLE
    return note.finished is None and note.settings == settings and recent


def _new_folder(out: Path, now: datetime) -> Path:
    day, number = now.date().isoformat(), 1
    while True:
        folder = out / (day if number == 1 else f"{day}-{number}")
        with suppress(FileExistsError):
            folder.mkdir()
            return folder
        number += 1


def _folders(out: Path) -> list[Path]:
    return [path for path in out.iterdir() if NAME.fullmatch(path.name) and path.is_dir()]


def _read(folder: Path) -> Night | None:
    """A night by its folder; None where it holds no note that can be read."""
    try:
        text = (folder / FILE).read_text(encoding="utf-8")
        return Night(folder, NightModel.model_validate_json(text))
    except (OSError, ValidationError, ValueError):
        return None


@contextmanager
def _locked(path: Path, *, wait: bool) -> Iterator[bool]:
    """A lock that ends with the process, however that ends; whether it is ours."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    try:
        try:
            fcntl.lockf(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            yield False
        else:
            yield True
    finally:
        os.close(descriptor)
