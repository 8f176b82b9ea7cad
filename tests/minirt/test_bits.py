"""The same bits on every CPU: scenes rendered by children with other instruction sets."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import minirt

_SCREEN = {"P0": [0.2, 0.3, 5.0], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
           "l": -0.41, "r": 0.39, "b": -0.3, "t": 0.3, "nx": 40, "ny": 30}  # fmt: skip
_LOOK_AT = {"look_at": {"eye": [1.7, 2.1, 4.9], "target": [0.1, 0.2, 0.3], "up": [0.1, 1, 0.2],
                        "fov_y": 37.7}, "nx": 40, "ny": 30}  # fmt: skip
_LIGHT = {"direction": [-1, -2, -1.3]}
_MATERIALS = {
    "phong": {"ambient": [0.1, 0.05, 0.02], "diffuse": [0.7, 0.3, 0.1],
              "specular": [0.5, 0.4, 0.3], "shininess": 37},
    "mirror": {"specular": [0.9, 0.9, 0.9], "shininess": 37, "reflectance": 0.7},
    "glass": {"transmittance": 0.8, "reflectance": 0.1, "ior": 1.5},
}  # fmt: skip
_TURN = np.arange(7) * (2 * np.pi / 7)
_SPHERES = [
    {"type": "sphere", "material": material, "center": [x, 0.1 * x, z], "radius": 0.61}
    for material, x, z in (("phong", -1.1, 0.3), ("mirror", 0.2, -0.7), ("glass", 0.9, 1.1))
]
_FLOOR = {"type": "polygon", "material": "phong",
          "vertices": [[-4, -1.3, 4], [4, -0.7, 4], [4, -0.7, -4], [-4, -1.3, -4]]}  # fmt: skip
_OBJECTS: dict[str, list[dict[str, Any]]] = {
    "sphere": _SPHERES[:1],
    "triangle": [{"type": "triangle", "material": "mirror",
                  "vertices": [[-1.3, -0.7, 0.1], [1.1, -0.9, 0.7], [0.3, 1.2, -0.9]]}],
    "polygon": [{"type": "polygon", "material": "glass", "vertices": [
        [1.3 * float(np.cos(a)), 0.9 * float(np.sin(a)), 0.0] for a in _TURN]}],
    "mesh": [{"type": "mesh", "material": "phong", "file": "ball.ply",
              "transform": [[0.9, 0.1, 0.3, 0.1], [0.2, 1.1, -0.3, 0.2],
                            [-0.3, 0.2, 0.9, 0.3], [0, 0, 0, 1]]}],
    "glb": [{"type": "mesh", "material": "glass", "file": "two.glb"}],
    "everything": [*_SPHERES, _FLOOR],
}  # fmt: skip

_CHILD = """
import hashlib, json, sys
import numpy as np
import minirt
features = np._core._multiarray_umath.__cpu_features__
answer = {"on": [name for name, on in features.items() if on], "scenes": {}}
for path in sys.argv[1:]:
    frame = minirt.render(minirt.load_scene(path))
    answer["scenes"][path] = {
        "hits": int(frame["hit"].sum()),
        "sha256": {q: hashlib.sha256(frame[q].tobytes()).hexdigest() for q in frame},
    }
print(json.dumps(answer))
"""


def _dispatched() -> list[str]:
    """Instruction sets that this NumPy uses on this CPU beyond its baseline."""
    module = np._core._multiarray_umath  # type: ignore[attr-defined]
    return [name for name in module.__cpu_dispatch__ if module.__cpu_features__.get(name)]


def _environments() -> dict[str, dict[str, str]]:
    sets = _dispatched()
    newest = {f"without {name}": {"NPY_DISABLE_CPU_FEATURES": name} for name in sets[-1:]}
    baseline = {"baseline only": {"NPY_DISABLE_CPU_FEATURES": " ".join(sets)}} if sets else {}
    cores = {
        f"OpenBLAS for {core}": {"OPENBLAS_CORETYPE": core, "OPENBLAS_VERBOSE": "2"}
        for core in ("Prescott", "Nehalem", "Haswell")
    }
    return {"as it is": {}, **newest, **baseline, **cores}


def _write_scenes(folder: Path) -> list[str]:
    trimesh.creation.icosphere(subdivisions=2).export(folder / "ball.ply")
    graph = trimesh.Scene()
    turn = np.eye(4)
    turn[:3] = [[0.36, 0.48, -0.8, 0.1], [-0.8, 0.6, 0.0, 0.2], [0.48, 0.64, 0.6, 0.3]]
    graph.add_geometry(trimesh.creation.box((1.0, 0.7, 0.9)), transform=turn)
    turn[:3, 3] += (0.9, 0.4, -0.3)
    graph.add_geometry(trimesh.creation.icosphere(subdivisions=1, radius=0.5), transform=turn)
    graph.export(folder / "two.glb")  # type: ignore[no-untyped-call]
    paths = []
    for name, objects in _OBJECTS.items():
        for form, screen in (("slides", _SCREEN), ("look_at", _LOOK_AT)):
            document = {"minirt": 1, "name": name, "screen": screen, "objects": objects,
                        "light": _LIGHT, "materials": _MATERIALS}  # fmt: skip
            path = folder / f"{name}-{form}.json"
            path.write_text(json.dumps(document))
            paths.append(str(path))
    return paths


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """What a child of each environment answers, and its standard error."""
    paths = _write_scenes(tmp_path_factory.mktemp("bits"))
    children = {
        name: subprocess.Popen(
            [sys.executable, "-c", _CHILD, *paths],
            env={**os.environ, **changes},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for name, changes in _environments().items()
    }
    result = {}
    for name, child in children.items():
        out, err = child.communicate(timeout=120)
        assert child.returncode == 0, err
        result[name] = {**json.loads(out), "err": err}
    return result


@pytest.mark.parametrize("environment", list(_environments())[1:])
def test_every_quantity_has_the_same_bits(
    answers: dict[str, dict[str, Any]], environment: str
) -> None:
    expected, found = answers["as it is"]["scenes"], answers[environment]["scenes"]
    assert len(found) == 2 * len(_OBJECTS)
    for path, scene in found.items():
        assert scene["hits"] > 50
        assert set(scene["sha256"]) == set(minirt.QUANTITIES)
        assert scene == expected[path], path


def test_the_children_really_lack_the_instructions(answers: dict[str, dict[str, Any]]) -> None:
    sets = _dispatched()
    assert set(sets) <= set(answers["as it is"]["on"])
    if sets:
        assert not set(sets) & set(answers["baseline only"]["on"])
        assert sets[-1] not in answers[f"without {sets[-1]}"]["on"]


def test_the_children_really_use_another_blas_kernel(answers: dict[str, dict[str, Any]]) -> None:
    cores = {
        line.removeprefix("Core: ")
        for answer in answers.values()
        for line in answer["err"].splitlines()
        if line.startswith("Core: ")
    }
    assert len(cores) >= 2
