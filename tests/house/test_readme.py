"""What the README shows is what the code does."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import minirt
from minirt.quantities import QUANTITIES
from minirt.scene_file.schema import key_names
from reference.compare.check import CERTAIN_FLOOR
from reports.cli.main import run
from tests.helpers.places import ROOT

KINDS = ("sphere", "triangle", "polygon", "mesh")

README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language: str, containing: str) -> str:
    """The one code block of a language that contains a text."""
    blocks = re.findall(rf"^```{language}\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
    (found,) = [b for b in blocks if containing in b]
    return str(found)


def rows(first: str) -> list[list[str]]:
    """Cells of the table rows whose first cell matches a pattern."""
    cells = [re.split(r"(?<!\\)\|", line.strip("|\n")) for line in README.splitlines()]
    stripped = [[cell.strip() for cell in row] for row in cells]
    return [row for row in stripped if re.fullmatch(first, row[0])]


COMMANDS = [
    line.split("#")[0].strip()
    for line in block("sh", "minirt render").splitlines()
    if line.startswith("minirt")
]


@pytest.mark.full
def test_the_commands_run_in_their_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for command in COMMANDS:
        status = run(command.split()[1:])
        assert status == 0, (command, capfd.readouterr().err)


def test_the_command_is_on_the_path_of_the_environment(tmp_path: Path) -> None:
    """As the README calls it; the other commands need no process of their own to be tried."""
    words = COMMANDS[0].split()
    done = subprocess.run(
        [str(Path(sys.executable).with_name(words[0])), *words[1:]],
        cwd=tmp_path, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_the_commands_are_all_there() -> None:
    assert {c.split()[1] for c in COMMANDS} == {
        "render", "explain", "verify", "report", "gate", "mutants", "fuzz", "export", "scenes",
        "rules", "doctor", "pack", "exercises",
    }  # fmt: skip


def test_the_nightly_example_is_taken() -> None:
    """All but the night itself: a mistake in its last option is told before anything is done."""
    (line,) = [b for b in block("sh", "minirt nightly").splitlines() if b]
    words = shlex.split(line)[1:]
    assert run([*words, "--mutants", "none"]) == 2
    units = block("ini", "OnCalendar")
    cron = block("text", "* * *")
    for text in (units, cron):
        assert re.search(r"minirt nightly --out \S+$", text, re.MULTILINE)


def test_the_python_example_runs() -> None:
    names: dict[str, object] = {}
    exec(block("python", "minirt.load_scene"), names)  # noqa: S102 - our own README
    frame = names["frame"]
    assert isinstance(frame, minirt.Frame)
    assert frame["depth"].shape == (192, 256)


def test_the_executor_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(block("python", "ThreadPoolExecutor"), names)  # noqa: S102 - our own README
    assert names["run"].verdict.exit_status == 0


def test_the_scene_example_loads() -> None:
    scene = minirt.load_scene(json.loads(block("json", '"minirt": 1')))
    assert [thing.type for thing in scene.objects] == ["sphere", "polygon"]


def test_every_key_of_a_scene_is_in_its_table() -> None:
    section = README.partition("## Scenes")[2].partition("## Frames")[0]
    firsts = re.findall(r"^\| ([^|]+) \|[^|]*\|[^|]*\|$", section, re.MULTILINE)
    named = {key for cell in firsts for key in re.findall(r"`(\w+)`", cell)}
    places: list[tuple[int | str, ...]] = [("objects", 0, kind) for kind in KINDS]
    places += [
        ("screen", "slides form"),
        ("screen", "look_at form"),
        ("light",),
        ("materials", "m"),
    ]
    keys = {key for place in ((), *places) for key in key_names(place)} - {"type", "material"}
    assert named - keys == set(KINDS)
    assert keys - named == set()


def test_the_defaults_of_a_scene_are_those_of_its_table() -> None:
    document = json.loads(block("json", '"minirt": 1'))
    document["materials"]["red"] = {}
    scene = minirt.load_scene(document)
    red = scene.materials["red"]
    assert (red.ambient, red.diffuse, red.specular) == ((0,) * 3, (0.8,) * 3, (0,) * 3)
    assert (red.shininess, red.reflectance, red.transmittance) == (1, 0, 0)
    assert (red.ior, red.alpha) == (None, 1)
    assert (scene.light_color, scene.background, scene.max_depth) == ((1,) * 3, (0,) * 3, 5)
    assert (scene.shadow_color, scene.floor, CERTAIN_FLOOR) == (None, None, 0.99)


def test_the_table_of_quantities_is_the_codes() -> None:
    table = {row[0].strip("`"): row for row in rows(r"`[a-z_]+`") if len(row) == 4}
    assert list(table) == list(QUANTITIES)
    for name, quantity in QUANTITIES.items():
        size = f" ×{quantity.components}" if quantity.components > 1 else ""
        assert table[name][1] == quantity.dtype + size
        meaning = table[name][3].replace("\\|", "|")
        assert meaning == f"{quantity.about} ({', '.join(quantity.rules)})"


def test_every_rule_and_departure_has_its_row_and_its_file() -> None:
    assert [row[0] for row in rows(r"S\d+")] == [f"S{k}" for k in range(1, 18)]
    assert [row[0] for row in rows(r"E\d")] == [f"E{k}" for k in range(1, 9)]
    for row in rows(r"S\d+"):
        for file in re.findall(r"`(minirt/[^`]+)`", row[2]):
            assert (ROOT / file).is_file(), file
