"""What a scene's author wrote is shown as text, whatever it holds."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import minirt
from reports.cli.main import run

EVIL = "\x1b[31mred\x07 <b>\u202e \n\r\x9b2J [bold]x[/bold] :boom:"


def test_names_neither_command_the_terminal_nor_break_lines(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = minirt.load_scene("atlas:ball-on-quad").to_dict()
    document["name"] = EVIL
    for thing in document["objects"]:
        thing["name"] = thing["material"] = EVIL
    document["materials"] = {EVIL: {"diffuse": [0.5, 0.5, 0.5]}}
    path = tmp_path / "evil.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    assert run(["explain", str(path), "--pixel", "128", "96"]) == 0
    shown = capsys.readouterr().out
    assert shown.count("[bold]x[/bold] :boom:") > 2
    assert not set(shown) & set("\x1b\x07\u202e\r\x9b")
