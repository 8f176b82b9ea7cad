"""Other people's tracers: run one on a scene, read the frame it wrote, and judge it."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

from converters.frames.io import read_frame
from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.compare.comparison import Comparison, compare
from reference.compare.stability import Exact, Stability, exact_answer, stability_of
from reference.source import Declared
from tests.helpers.places import ROOT

SUBJECTS = ROOT / "tests" / "subjects"
KIT = ROOT / "reports" / "gate" / "kit"


def subject_scene(scene: Scene, folder: Path) -> Path:
    """A scene as the gate hands it over: in the slides' form, ε a number, meshes beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    document = {**scene.to_dict(), "epsilon": scene.epsilon}
    for thing in document["objects"]:
        if thing["type"] == "mesh":
            (folder / thing["file"]).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(Path(scene.folder or ".") / thing["file"], folder / thing["file"])
    path = folder / "scene.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def frame_of(command: Sequence[str | Path], scene: Scene, out: Path) -> Frame:
    """What a program writes to `out`, given the scene in a file beside it."""
    path = subject_scene(scene, out.parent / f"{out.stem}-scene")
    done = subprocess.run([*command, path, out], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    return read_frame(out, (scene.screen.ny, scene.screen.nx))


def judge(scene: Scene, frame: Frame, single: bool = False) -> Comparison:
    """The verdict on a tracer that computes in double; `single` where its files are float32."""
    exact, stability = measured(scene, single)
    return compare(scene, exact.frame, stability, frame, {})


@cache
def answered(scene: Scene) -> Exact:
    """minirt's answer: one for all programs that are given the same scene."""
    return exact_answer(scene)


@cache
def measured(scene: Scene, single: bool) -> tuple[Exact, Stability]:
    """minirt's answer and how stable it is under the errors of such a tracer."""
    exact = answered(scene)
    error = declared(scene, float32_steps(exact.frame) if single else ())
    return exact, stability_of(exact, error)


def declared(scene: Scene, steps: tuple[tuple[str, float], ...]) -> Declared:
    """Double precision: 256 roundings of 2⁻⁵² at the scale of the scene and its coordinates."""
    corners = [] if scene.bounds is None else [float(np.abs(scene.bounds).max())]
    reach = max(scene.extent, *map(abs, scene.screen.P0), *corners)
    return Declared(
        delta=2.0**-44 * reach,
        vertex=0.0,
        angle=2.0**-44,
        color=2.0**-44,
        start=None,
        derivation="256 roundings of 2⁻⁵² at the scale of the largest coordinate or the extent",
        steps=steps,
    )


def float32_steps(exact: Frame) -> tuple[tuple[str, float], ...]:
    """Half a unit in the last place of float32, at each quantity's largest value."""
    steps = []
    for name, array in exact.items():
        quantity, values = QUANTITIES[name], array[np.isfinite(array)]
        if quantity.discrete or not values.size:
            continue
        step = float(np.spacing(np.float32(np.abs(values).max()))) / 2
        step *= math.sqrt(quantity.components)
        if name == "t":  # whose step is declared as a length: t·‖d‖
            hit = exact["hit"]
            step *= float((exact["distance"][hit] / exact["t"][hit]).max())
        steps.append((name, step))
    return tuple(steps)
