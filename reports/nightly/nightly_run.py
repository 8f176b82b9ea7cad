"""The folder of one nightly run, and the record of its steps.

`night.json` is written after every step, so that an interrupted run continues with the steps that
are missing. A lock that ends with its process marks a run that is still in progress.
"""

from __future__ import annotations

import fcntl
import json
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationError

from converters.atomic import atomic_file
from reports.results.json_model import Model, Natural

#: For so long an interrupted run may be continued; after that a new one begins.
RESUMABLE = timedelta(hours=24)
NAME = re.compile(r"\d{4}-\d\d-\d\d(-\d+)?")
FILE = "night.json"
_LOCK, _REMOVED = ".lock", ".removed-"


def _with_offset(text: str) -> str:
    """Refuse a time without its offset from UTC."""
    if datetime.fromisoformat(text).tzinfo is None:
        raise ValueError("a time without its offset from UTC")
    return text


class StepResult(Model):
    """How one step ended."""

    exit_status: int = Field(ge=0, le=3)
    sentence: str = Field(description="for people")
    seconds: float


class NightlySettings(Model):
    """What a run was asked for; it is continued only with the same settings."""

    commit: str | None
    scenes: list[str] = Field(description="SHA-256 of each")
    references: list[str]
    required: list[str]
    budget: float = Field(description="seconds of fuzzing")
    mutants: list[str] = Field(description="empty: all")


class NightlyRecord(Model):
    """`night.json`."""

    minirtNight: Literal[1] = Field(default=1, description="version of this format")  # noqa: N815
    started: Annotated[str, AfterValidator(_with_offset)] = Field(description="ISO 8601, UTC")
    number: Natural = Field(
        default=0, description="in the order in which all_runs began, whatever a clock says"
    )
    seed: Natural = Field(description="of the first round of fuzzing")
    settings: NightlySettings
    steps: dict[str, StepResult] = Field(default={})
    run: int | None = Field(default=None, description="number of the run in the history")
    finished: str | None = None

    @property
    def exit_status(self) -> int:
        """1 where a step failed, else 3 where one is incomplete, else 0."""
        found = {step.exit_status for step in self.steps.values()}
        return 1 if 1 in found else max(found, default=3)


@dataclass
class NightlyRun:
    """The folder of a nightly run, and its record."""

    folder: Path
    record: NightlyRecord

    @property
    def name(self) -> str:
        """The day, and a number from the second run of a day on."""
        return self.folder.name

    def finish_step(self, step: str, result: StepResult) -> None:
        """Record that a step is done."""
        self.save(steps={**self.record.steps, step: result})

    def save(self, **changes: object) -> None:
        """Change the record, and write it."""
        self.record = self.record.model_copy(update=changes)
        write(self.folder / FILE, self.record.model_dump_json(indent=1) + "\n")


def write(path: Path, text: str) -> None:
    """A file of a nightly run, whole or not at all."""
    with atomic_file(path) as new:
        new.write_text(text, encoding="utf-8", newline="\n")


def write_json(path: Path, document: Any) -> None:
    """A JSON file of a nightly run, whole or not at all."""
    write(path, json.dumps(document, indent=1, allow_nan=False) + "\n")


@contextmanager
def started_or_resumed(out: Path, settings: NightlySettings) -> Iterator[NightlyRun]:
    """The interrupted run with these settings, or a new one; locked until the block ends.

    Parameters
    ----------
    out : Path
        Exists.
    settings : SettingsModel
    """
    now = datetime.now(UTC)
    earlier = all_runs(out)
    for night in reversed(earlier):
        if _resumable(night, settings, now):
            with _locked(night.folder / _LOCK, wait=False) as locked:
                fresh = _read(night.folder) if locked else None
                if fresh is not None and _resumable(fresh, settings, now):
                    yield fresh
                    return
    folder = _new_folder(out, now)
    with _locked(folder / _LOCK, wait=True):
        record = NightlyRecord(
            started=now.isoformat(timespec="microseconds"),
            number=max((night.record.number for night in earlier), default=0) + 1,
            seed=secrets.randbits(32),
            settings=settings,
        )
        night = NightlyRun(folder, record)
        night.save()
        yield night


def all_runs(out: Path) -> list[NightlyRun]:
    """Every run of a folder that can be read, oldest first."""
    found = [night for night in map(_read, _folders(out)) if night is not None]
    return sorted(found, key=lambda n: (n.record.number, n.record.started, n.name))


def unreadable_folders(out: Path) -> list[str]:
    """The names of the folders of runs whose record cannot be read."""
    return sorted(path.name for path in _folders(out) if _read(path) is None)


@contextmanager
def exclusive(out: Path) -> Iterator[None]:
    """Hold the lock on the files that all runs of a folder share."""
    with _locked(out / _LOCK, wait=True):
        yield


def remove_old(out: Path, keep: int, current: NightlyRun) -> list[str]:
    """Remove all but the newest runs and those in progress; the history keeps their results.

    Returns
    -------
    list of str
        The names of those removed.
    """
    for left in out.glob(f"{_REMOVED}*"):  # where this was interrupted
        shutil.rmtree(left, ignore_errors=True)
    removed = []
    for night in all_runs(out)[:-keep]:
        if night.name == current.name:
            continue  # its lock is this process's own
        with _locked(night.folder / _LOCK, wait=False) as locked:
            if locked:
                away = out / f"{_REMOVED}{night.name}-{secrets.token_hex(4)}"
                night.folder.rename(away)
                shutil.rmtree(away, ignore_errors=True)
                removed.append(night.name)
    return removed


def _resumable(night: NightlyRun, settings: NightlySettings, now: datetime) -> bool:
    record = night.record
    recent = now - datetime.fromisoformat(record.started) < RESUMABLE
    return record.finished is None and record.settings == settings and recent


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


def _read(folder: Path) -> NightlyRun | None:
    """A run by its folder; None where it holds no record that can be read."""
    try:
        text = (folder / FILE).read_text(encoding="utf-8")
        return NightlyRun(folder, NightlyRecord.model_validate_json(text))
    except (OSError, ValidationError, ValueError):
        return None


@contextmanager
def _locked(path: Path, *, wait: bool) -> Iterator[bool]:
    """A lock that ends with the process, however that ends; whether this process holds it."""
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
