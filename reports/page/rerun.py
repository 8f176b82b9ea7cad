"""How to look at a pixel of a run again: a command and a test, for people to copy."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from minirt import load_scene
from minirt.scene import Scene
from minirt.scene_file.atlas import atlas_names
from reference.registry import REFERENCES
from reports.gate.subject import Subject
from reports.results.record import Run

#: What stands for the pixel's column and row in a command and in a test.
PLACEHOLDERS = ("COLUMN", "ROW")


def rerun_command(run: Run, scene: Scene) -> str:
    """The command that explains a pixel of a scene; COLUMN and ROW stand for the pixel."""
    words = ["minirt", "explain", source_of(run, scene), "--pixel", *PLACEHOLDERS, *_subject(run)]
    return shlex.join(words)


def source_of(run: Run, scene: Scene) -> str:
    """How the command line names a scene; SCENE.json where its file is not known."""
    if scene.name in atlas_names() and load_scene(f"atlas:{scene.name}").sha256 == scene.sha256:
        return f"atlas:{scene.name}"
    files = [word for word in shlex.split(run.provenance.command) if word.endswith(".json")]
    named = [word for word in files if scene.name in (Path(word).stem, Path(word).parent.name)]
    return (named or (files if len(run.results) == 1 else []) or ["SCENE.json"])[0]


def _subject(run: Run) -> list[str]:
    """The options of the run's own command that name an implementation."""
    kinds = {"--" + f.name.replace("_", "-"): isinstance(f.default, bool) for f in fields(Subject)}
    words = shlex.split(run.provenance.command)
    found: list[str] = []
    for place, word in enumerate(words):
        name, equals, _ = word.partition("=")
        if name in kinds:
            found += [word] if equals or kinds[name] else words[place : place + 2]
    named = ("--cmd", "--python", "--frames")
    return found if any(word.startswith(named) for word in found) else []


def ready_test(run: Run, scene: Scene, reference: str) -> str:
    """A test that fails while a reference is wrong; COLUMN and ROW stand for the pixel."""
    source = source_of(run, scene)
    name = re.sub(r"\W+", "_", f"{scene.name} {reference}").strip("_").lower()[:60]
    if reference in REFERENCES:
        return _REFERENCE.format(name=name, source=source, reference=reference)
    return command_test(name, shlex.split(rerun_command(run, scene)))


def command_test(name: str, words: Sequence[str]) -> str:
    """A test that runs a command, which must end with status 0."""
    return _COMMAND.format(name=name, words=[*words])


_REFERENCE = """\
from minirt import load_scene
from reference.fuzz.trial import try_once
from reference.registry import choose_references


def test_{name}_at_COLUMN_ROW() -> None:
    scene = load_scene({source!r})
    (reference,) = choose_references([{reference!r}])
    trial = try_once(scene, reference)
    assert trial.state == "passed", f"{{trial.state}}, {{trial.stage}}: {{trial.reason}}"
"""

_COMMAND = """\
import subprocess


def test_{name}_at_COLUMN_ROW() -> None:
    command = {words}
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
"""
