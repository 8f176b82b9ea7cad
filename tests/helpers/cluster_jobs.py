"""What the tests of clusters let workers do; as little as possible is imported there."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import minirt
from minirt.errors import InputError
from minirt.scene import Scene
from reference.source import Rendering
from tests.helpers.fake_references import Faulty, Honest


@dataclass(frozen=True)
class Marking(Faulty):
    """Leaves a mark where it begins to render, takes its time, and reads meshes again.

    Not from the folder that they were loaded from, unless that is none.
    """

    name: str = "marking"
    marks: Path = Path()
    loaded_from: Path = Path()
    seconds: float = 0.0

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        (self.marks / f"{scene.name} {os.getsid(0)} {os.getpid()}").touch()
        time.sleep(self.seconds)
        assert scene.folder != self.loaded_from
        return super().render(minirt.load_scene(scene.to_dict(), scene.folder), scratch)


@dataclass(frozen=True)
class Raising(Honest):
    """Cannot do what it should."""

    name: str = "raising"

    def render(self, scene: Scene, scratch: Path) -> Rendering:
        raise ValueError("no such variant")


def square(number: int) -> int:
    return number**2


def fail(number: int) -> int:
    raise InputError("no such number", got=str(number))


def kill_itself() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def kill_worker(marks: Path) -> None:
    """What no worker survives."""
    (marks / str(os.getppid())).touch()
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(60)


def mark_and_wait(marks: Path, number: int) -> None:
    (marks / str(number)).touch()
    time.sleep(0.5)
