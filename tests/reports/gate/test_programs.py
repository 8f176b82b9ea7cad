"""Real programs through the gate's command line: Mitsuba's, POV-Ray's, and the starter kit's."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import minirt
from converters.frames.io import read_frame
from reference.renderers.mitsuba.cli import find_command
from reports.cli.main import run
from reports.gate.starter_kit import SCENES, STUBS

Gate = Callable[..., tuple[int, dict[str, Any]]]


@pytest.fixture
def gate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Gate:
    """Runs the gate; exit status and results."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def judged(*options: str) -> tuple[int, dict[str, Any]]:
        status = run(["gate", *options, "-o", str(tmp_path / "report"), "--json"])
        document: dict[str, Any] = json.loads(capsys.readouterr().out)
        return status, document

    return judged


def passed(document: dict[str, Any]) -> list[set[str]]:
    """The quantities that were compared and agree, scene by scene."""
    return [
        {check["quantity"] for check in scene["references"][0]["checks"] if check["compared"]}
        for scene in document["scenes"]
        if scene["state"] == "passed"
    ]


def smaller(name: str, folder: Path) -> str:
    """A scene of the atlas in a quarter of its pixels, as a file."""
    document = minirt.load_scene(f"atlas:{name}").to_dict()
    document["screen"] |= {"nx": 128, "ny": 96}
    path = folder / f"{name}.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return str(path)


@pytest.mark.full
def test_mitsubas_own_command_passes_and_says_what_it_cannot(gate: Gate) -> None:
    scenes = [f"atlas:{name}" for name in ("off-axis-screen", "ball-on-quad-far-away")]
    command = f"{find_command()} -m scalar_rgb {{scene}} -o {{out}}"
    options = "--scene-as", "mitsuba", "--out-as", "mitsuba", "--precision", "float32"
    status, document = gate(*scenes, "atlas:non-square-pixels", "--cmd", command, *options)
    assert status == 0, document["verdict"]
    hits = {"hit", "object", "triangle", "t", "depth", "distance", "position", "normal"}
    assert passed(document) == [hits | {"barycentric"}] * 2
    assert document["scenes"][2]["state"] == "not compared"


@pytest.mark.full
def test_povrays_own_colours_pass_and_its_wrong_ones_do_not(gate: Gate, tmp_path: Path) -> None:
    command = "povray +I{scene} +O{out} +W{nx} +H{ny} +FE -A -D -P File_Gamma=1.0"
    options = "--scene-as", "povray", "--handed", "half", "--start", "1e-4"
    scenes = [smaller(name, tmp_path) for name in ("contact-shadow", "glass-ball")]
    status, document = gate(*scenes, "--cmd", command, *options)
    assert status == 0, document["verdict"]
    assert passed(document) == [{"color"}] * 2
    antialiased = command.replace("-A", "+A0.1")
    status, document = gate(scenes[0], "--cmd", antialiased, *options)
    assert status == 1
    assert document["scenes"][0]["first_wrong_stage"] == "colour"


@pytest.mark.full
def test_the_starter_kit_is_whole_and_its_stub_passes(gate: Gate, tmp_path: Path) -> None:
    kit = tmp_path / "kit"
    status, document = gate("--init", str(kit))
    assert status == 0
    assert "README.md" in document["files"]
    for name in SCENES:
        loaded = minirt.load_scene(str(kit / "scenes" / name / "scene.json"))
        expected = read_frame(kit / "expected" / f"{name}.npz")
        for quantity, array in minirt.render(loaded).items():
            assert expected[quantity].tobytes() == array.tobytes()
    scene = str(kit / "scenes" / "one-sphere" / "scene.json")
    command = f"{sys.executable} {kit / 'stub.py'} {{scene}} {{out}}"
    status, document = gate(scene, "--cmd", command, "--out-as", "npz", "--require", "hit,depth")
    assert status == 0
    assert passed(document) == [{"hit", "depth"}]
    status, document = gate("--init", str(kit))
    assert status == 2
    assert "not empty" in document["error"]["what"]


@pytest.mark.parametrize("language", STUBS)
def test_every_language_has_its_stub(gate: Gate, tmp_path: Path, language: str) -> None:
    status, document = gate("--init", str(tmp_path / "kit"), "--language", language)
    assert status == 0
    assert STUBS[language] in document["files"]
