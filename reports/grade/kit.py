"""What Gradescope needs to grade by a rubric: its two scripts, the rubric, and the scenes."""

from __future__ import annotations

import shutil
from pathlib import Path

from converters.atomic import atomic_folder
from minirt import load_scene
from reports.grade.assignment import Assignment

_SCRIPTS = ("setup.sh", "run_autograder")
_KIT = Path(__file__).parents[1] / "gate" / "kit"


def write_kit(assignment: Assignment, rubric: Path, folder: Path) -> None:
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
