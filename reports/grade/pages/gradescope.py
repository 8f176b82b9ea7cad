"""Gradescope: the folder of its autograder, and the results of one student."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from converters.atomic import atomic_folder
from minirt import load_scene
from reports.grade.assignment.assignment import Assignment
from reports.grade.pages.words import (
    explanation_in_words,
    headline,
    lateness,
    message_of,
    missing_in_words,
    part_in_words,
)
from reports.grade.record import Student

_SCRIPTS = ("setup.sh", "run_autograder")
_KIT = Path(__file__).parents[2] / "gate" / "kit"


def write_autograder(assignment: Assignment, rubric: Path, folder: Path) -> None:
    """Write a folder to be zipped, with minirt's wheel beside it, for Gradescope.

    Parameters
    ----------
    assignment : Assignment
    rubric : Path
        The rubric's file.
    folder : Path
    """
    with atomic_folder(folder) as staging:
        for name in _SCRIPTS:
            shutil.copyfile(_KIT / name, staging / name)
            (staging / name).chmod(0o755)
        shutil.copyfile(rubric, staging / "rubric.toml")
        for text in assignment.rubric.scenes:
            if text.startswith("atlas:"):
                continue
            target = staging / text
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(rubric.parent / text, target)
            for thing in load_scene(rubric.parent / text).to_dict()["objects"]:
                if thing["type"] == "mesh":
                    mesh = target.parent / thing["file"]
                    mesh.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile((rubric.parent / text).parent / thing["file"], mesh)


def results_json(student: Student) -> dict[str, Any]:
    """Gradescope's `results.json`: a test a part; the score, lateness included, stands above."""
    marks = student.marks
    lines = [headline(student), lateness(student), message_of(student), *missing_in_words(student)]
    lines += [f"{each.scene}: {explanation_in_words(each)}" for each in student.closer]
    return {
        "score": marks.points,
        "output": "\n\n".join(line for line in lines if line),
        "output_format": "text",
        "visibility": "visible",
        "stdout_visibility": "hidden",
        "tests": [
            {
                "name": part.name,
                "score": part.points,
                "max_score": part.of,
                "status": "passed" if part.points == part.of else "failed",
                "output": part_in_words(part),
                "output_format": "text",
                "visibility": "visible",
            }
            for part in marks.parts
        ],
    }
