"""A failure of a campaign as files: the scene, an explanation of its pixel, and two ready tests."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

from converters.atomic import atomic_folder, require_replaceable
from converters.scene_folder import mesh_names
from minirt.explain.pixel import explain
from reference.fuzz.campaign import Failure
from reports.explain.text import explanation_text
from reports.fuzz.cpp import cpp_test
from reports.gate.subject import Subject
from reports.results.words import count, one_line

#: What the names of a case's files look like: an older case may be replaced, nothing else.
_FILES = ("scene.json", "explain.txt", "test_*.py", "test_*.cpp", "*.obj", "__pycache__")

_PYTEST = '''\
"""{about}"""

from pathlib import Path

from minirt import load_scene
from reference.fuzz.trial import try_once
{imports}


def test_{name}() -> None:
    scene = load_scene(Path(__file__).with_name("scene.json"))
    {reference}
    trial = try_once(scene, reference)
    assert trial.state == "passed", f"{{trial.state}}, {{trial.stage}}: {{trial.reason}}"
'''


def write_case(failure: Failure, out: Path, subject: Subject | None = None) -> Path:
    """Write a failure into a folder of its own below `out`, whole or not at all.

    Parameters
    ----------
    failure : Failure
    out : Path
        Exists.
    subject : Subject, optional
        Somebody else's implementation, if one was judged.

    Returns
    -------
    Path
        The folder: scene.json with its meshes, explain.txt, and test_NAME.py and test_NAME.cpp.

    Raises
    ------
    InputError
        It cannot be written, or the folder holds other files than an older case.
    """
    folder = out / failure.name
    require_replaceable(folder, _FILES)
    with atomic_folder(folder) as new:
        for file, text in case_texts(failure, subject).items():
            (new / file).write_text(text, encoding="utf-8", newline="\n")
        for name in mesh_names(failure.shrunk.scene):
            shutil.copy(failure.shrunk.scene.folder / name, new)
    return folder


def case_texts(failure: Failure, subject: Subject | None = None) -> dict[str, str]:
    """The text of each file of a case, by the file's name."""
    scene, trial, name = failure.shrunk.scene, failure.shrunk.trial, failure.name
    imports, reference = _makes(failure.reference, subject)
    about = one_line(sentence(failure)).replace("\\", "/").replace('"', "'")
    known = {key: value for key, value in scene.to_dict().items() if value not in ("", [], None)}
    document = {"minirt": 1, "name": scene.name, "about": about, "objects": [], **known}
    document["about"] = about
    explanation = explanation_text(explain(scene, trial.column, trial.row))
    return {
        "scene.json": readable_json(document) + "\n",
        "explain.txt": f"{about}\n\n{explanation}",
        f"test_{name}.py": _PYTEST.format(
            about=about, name=name, imports=imports, reference=reference
        ),
        f"test_{name}.cpp": cpp_test(scene, trial, about),
    }


def _makes(reference: str, subject: Subject | None) -> tuple[str, str]:
    """Two lines of a test: the import, and the statement that makes the failing renderer."""
    if subject is not None and subject.named and subject.reference().name == reference:
        made = f"reference = Subject.of({subject.options()!r}).reference()"
        return "from reports.gate.subject import Subject", made
    chosen = f"(reference,) = choose_references([{json.dumps(reference)}])"
    return "from reference.registry import choose_references", chosen


def readable_json(document: dict[str, Any]) -> str:
    """JSON with a key a line, and each array of numbers on one.

    Examples
    --------
    >>> print(readable_json({"center": [1.0, 2.5]}))
    {
     "center": [1.0, 2.5]
    }
    """
    text = json.dumps(document, indent=1, ensure_ascii=False)
    return re.sub(r"\[\n([-+.\w\s,]*?)\n\s*\]", lambda m: f"[{' '.join(m[1].split())}]", text)


def sentence(failure: Failure) -> str:
    """One line for people: who fails what, first in which stage, and how small it became."""
    scene, trial = failure.shrunk.scene, failure.shrunk.trial
    screen = scene.screen
    size = f"{count(len(scene.objects), 'object')}, {screen.nx} × {screen.ny} pixels"
    return (
        f"{failure.reference} fails {scene.name}, first in {trial.stage}; "
        f"{size}, pixel ({trial.column}, {trial.row}): {trial.reason}"
    )
