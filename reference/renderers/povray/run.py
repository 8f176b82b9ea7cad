"""Start the `povray` program on pictures, all at once, and read the integers of its PNG files."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np

from converters.frames.images import open_image
from minirt.errors import InputError, ReferenceError
from minirt.screen import VirtualScreen
from minirt.vectors import Ints

#: Seconds for one scene. POV-Ray waits half a second whatever it draws; a million pixels of 1,000
#: spheres take some ten.
TIMEOUT = 600.0


def find_povray() -> Path | None:
    """POV-Ray's program on the search path."""
    found = shutil.which("povray")
    return Path(found) if found else None


@cache
def povray_version() -> str:
    """Its name and version, as it prints them."""
    result = subprocess.run(
        [str(find_povray()), "--version"], capture_output=True, text=True, timeout=TIMEOUT
    )
    lines = (result.stdout + result.stderr).splitlines()
    return next((line for line in lines if line.startswith("POV-Ray")), "POV-Ray")


def render_pictures(
    pictures: Mapping[str, str], screen: VirtualScreen, folder: Path
) -> dict[str, Ints]:
    """Render texts; codes (ny·nx, 3) int32 in 0…65535 of each, top row first.

    POV-Ray reads and writes in its working folder only, since its own settings may forbid others.

    Raises
    ------
    ReferenceError
        It failed or took too long.
    """
    started: dict[str, subprocess.Popen[bytes]] = {}
    try:
        for name, text in pictures.items():
            (folder / f"{name}.pov").write_text(text, encoding="utf-8")
            started[name] = _start(name, screen, folder)
        deadline = time.monotonic() + TIMEOUT
        for name, process in started.items():
            _wait(process, deadline, folder / f"{name}.log")
    finally:
        for process in started.values():
            _end(process)
    return {name: _codes(folder / f"{name}.png", screen) for name in pictures}


def _start(name: str, screen: VirtualScreen, folder: Path) -> subprocess.Popen[bytes]:
    """POV-Ray on one picture: no antialiasing, no display, linear codes, one thread."""
    switches = ["+FN16", "-A", "-D", "-V", "-P", "File_Gamma=1.0", "Dither=off", "+WT1"]
    files = [f"+I{name}.pov", f"+O{name}.png", f"+W{screen.nx}", f"+H{screen.ny}"]
    with (folder / f"{name}.log").open("wb") as log:
        return subprocess.Popen(
            [str(find_povray()), *files, *switches],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            start_new_session=True,
        )


def _wait(process: subprocess.Popen[bytes], deadline: float, log: Path) -> None:
    try:
        status = process.wait(max(0.0, deadline - time.monotonic()))
    except subprocess.TimeoutExpired:
        raise ReferenceError(f"POV-Ray took more than {TIMEOUT:g} s") from None
    if status != 0:
        output = log.read_bytes()[-2000:].decode(errors="replace").strip()
        raise ReferenceError(f"POV-Ray ended with status {status}", got=output)


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process that still runs, with its group."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _codes(path: Path, screen: VirtualScreen) -> Ints:
    try:
        with open_image(path, (screen.ny, screen.nx)) as image:
            blocks = [np.stack(planes[:3], axis=-1) for _, planes in image.blocks()]
            return np.concatenate(blocks).astype(np.int32).reshape(-1, 3)
    except InputError as error:
        raise ReferenceError("POV-Ray's image cannot be used", got=str(error)) from None
