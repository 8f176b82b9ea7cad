"""Tracers by other hands in C++, JavaScript and Python, judged as the gate judges them."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.compare.comparison import Comparison
from tests.helpers.places import ROOT
from tests.helpers.subject_runs import KIT, SUBJECTS, frame_of, judge, subject_scene
from tests.helpers.tiers import tiered

#: A sphere, a mesh in a transform, glass with total reflection, mirrors, polygons, an empty view.
SCENES = (
    "one-sphere", "glass-gem", "snells-window", "grazing-mirror", "pentagon-and-octagon",
    "nothing-hit",
)  # fmt: skip

Command = list[str | Path]

TRACERS = ("tracer.cpp", "tracer.mjs", "tracer.py")


@cache
def small(name: str) -> Scene:
    """A scene of the atlas in a sixteenth of its pixels."""
    document = minirt.load_scene(f"atlas:{name}").to_dict()
    document["screen"] |= {"nx": 64, "ny": 48}
    return minirt.load_scene(document, ROOT / "minirt" / "atlas")


@pytest.fixture(scope="session")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path], Path]:
    """A C++ file compiled, once a session."""
    folder, done = tmp_path_factory.mktemp("compiled"), dict[Path, Path]()

    def compile_(source: Path) -> Path:
        if source not in done:
            done[source] = folder / source.stem
            options = ["-std=c++17", "-O2", "-Wall", "-Wextra", "-Werror"]
            command: Command = ["g++", *options, source, "-o", done[source]]
            run = subprocess.run(command, capture_output=True, text=True)
            assert run.returncode == 0, run.stderr
        return done[source]

    return compile_


def interpreted(program: str) -> bool:
    """Whether a program needs no compiler, which takes longer than all the scenes."""
    return not program.endswith(".cpp")


def command_for(source: Path, compiled: Callable[[Path], Path]) -> Command:
    if source.suffix == ".cpp":
        return [compiled(source)]
    return ["node" if source.suffix == ".mjs" else sys.executable, source]


def imported(path: Path) -> Any:
    spec = importlib.util.spec_from_file_location(f"subject_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def assert_passed(comparison: Comparison, given: set[str]) -> None:
    state = {check.quantity: (check.state, check.reason) for check in comparison.checks}
    passed = {name for name, (what, _) in state.items() if what == "passed"}
    assert passed == given, {name: why for name, why in state.items() if name in given - passed}
    assert {state[name][0] for name in set(QUANTITIES) - given} <= {"not given"}
    assert all(check.certain > 0.99 * check.pixels for check in comparison.checks if check.pixels)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("program", tiered(TRACERS, interpreted))
def test_tracer_passes_in_every_quantity(
    program: str, name: str, compiled: Callable[[Path], Path], tmp_path: Path
) -> None:
    scene = small(name)
    folder = program == "tracer.cpp"
    out = tmp_path / ("out" if folder else "out.npz")
    frame = frame_of(command_for(SUBJECTS / program, compiled), scene, out)
    assert_passed(judge(scene, frame, single=folder), set(QUANTITIES))


def test_tracer_in_python_is_a_function_too(tmp_path: Path) -> None:
    scene = small("one-sphere")
    arrays = imported(SUBJECTS / "tracer.py").render({**scene.to_dict(), "epsilon": scene.epsilon})
    assert_passed(judge(scene, Frame(arrays)), set(QUANTITIES))


@pytest.mark.parametrize("program", tiered(TRACERS, interpreted))
def test_tracer_of_nothing_at_all(
    program: str, compiled: Callable[[Path], Path], tmp_path: Path
) -> None:
    document = minirt.load_scene("atlas:one-sphere").to_dict()
    scene = minirt.load_scene({**document, "objects": []})
    out = tmp_path / program / ("out" if program == "tracer.cpp" else "out.npz")
    frame = frame_of(command_for(SUBJECTS / program, compiled), scene, out)
    assert not frame["hit"].any()
    assert len(frame) == len(QUANTITIES)
    assert np.isinf(frame["depth"]).all()


@pytest.mark.parametrize("type_", ["ascii", "binary_big_endian", "binary_little_endian"])
@pytest.mark.parametrize("program", tiered(TRACERS, interpreted))
def test_tracer_reads_every_kind_of_ply(
    program: str, type_: str, compiled: Callable[[Path], Path], tmp_path: Path
) -> None:
    """A pyramid with a square base, a colour a vertex, and a face's own number before its list."""
    points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, 0, 1)]
    faces = [(3, 2, 1, 0), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    head = (
        f"ply\nformat {type_} 1.0\ncomment a pyramid\nelement vertex 5\nproperty double x\n"
        "property double y\nproperty double z\nproperty uchar red\nelement face 5\n"
        "property short number\nproperty list uchar int vertex_index\nend_header\n"
    )
    order = ">" if type_ == "binary_big_endian" else "<"
    body = b""
    if type_ == "ascii":
        rows = [" ".join(map(str, (*p, 7))) for p in points]
        rows += [" ".join(map(str, (5, len(f), *f))) for f in faces]
        body = "\n".join(rows).encode() + b"\n"
    else:
        for p in points:
            body += np.array(p, dtype=f"{order}f8").tobytes() + b"\x07"
        for f in faces:
            body += np.array(5, dtype=f"{order}i2").tobytes() + bytes([len(f)])
            body += np.array(f, dtype=f"{order}i4").tobytes()
    (tmp_path / "pyramid.ply").write_bytes(head.encode() + body)
    document = minirt.load_scene("atlas:one-sphere").to_dict()
    material = document["objects"][0]["material"]
    document["objects"] = [{"type": "mesh", "material": material, "file": "pyramid.ply"}]
    document["screen"] |= {"nx": 32, "ny": 24}
    scene = minirt.load_scene(document, tmp_path)
    out = tmp_path / ("out" if program == "tracer.cpp" else "out.npz")
    frame = frame_of(command_for(SUBJECTS / program, compiled), scene, out)
    assert frame["hit"].sum() > 20
    assert np.array_equal(frame["triangle"], minirt.render(scene)["triangle"])


@pytest.mark.parametrize("stub", tiered(["stub.cpp", "stub.mjs", "stub.py"], interpreted))
def test_stub_of_the_kit_passes_at_once(
    stub: str, compiled: Callable[[Path], Path], tmp_path: Path
) -> None:
    scene = minirt.load_scene("atlas:one-sphere")
    out = tmp_path / ("out.npz" if stub == "stub.py" else "out")
    frame = frame_of(command_for(KIT / stub, compiled), scene, out)
    assert_passed(judge(scene, frame), {"hit", "depth"})


def test_stub_in_python_is_a_function_too(tmp_path: Path) -> None:
    scene = small("one-sphere")
    arrays = imported(KIT / "stub.py").render(scene.to_dict())
    assert_passed(judge(scene, Frame(arrays)), {"hit", "depth"})


def test_a_stub_fails_where_there_is_more_than_spheres(tmp_path: Path) -> None:
    scene = small("one-triangle")
    frame = frame_of([sys.executable, KIT / "stub.py"], scene, tmp_path / "out.npz")
    state = {check.quantity: check.state for check in judge(scene, frame).checks}
    assert (state["hit"], state["depth"]) == ("failed", "failed")


def test_kit_names_every_quantity_as_the_table_does() -> None:
    text = (KIT / "README.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| (\w+ \| \d) \|", text, flags=re.M))
    assert rows == {q.name: f"{q.dtype} | {q.components}" for q in QUANTITIES.values()}
    assert all(q.about.replace("|", r"\|") in text for q in QUANTITIES.values())


def test_scene_is_handed_over_in_the_slides_form(tmp_path: Path) -> None:
    scene = minirt.load_scene("atlas:closed-mesh")
    again = minirt.load_scene(subject_scene(scene, tmp_path))
    assert (again.screen, again.epsilon) == (scene.screen, scene.epsilon)
    assert "look_at" not in again.to_dict()["screen"]
    assert again.to_dict()["epsilon"] == scene.epsilon


def test_subjects_owe_nothing_to_minirt() -> None:
    texts = [path.read_text(encoding="utf-8") for path in (*SUBJECTS.iterdir(), *KIT.glob("*.py"))
             if path.is_file()]  # fmt: skip
    assert len(texts) >= 4
    assert not any(re.search(r"^\s*(import|from) minirt", text, flags=re.M) for text in texts)
    packages = (ROOT / ".ci" / "system-packages").read_text(encoding="utf-8")
    assert all(name in packages for name in ("g++", "nodejs", "nlohmann-json3-dev"))
