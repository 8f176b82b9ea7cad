"""A class of twenty submissions: honest ones, mutants, and what else gets handed in.

Made anew for each session of tests: small pictures, and frames for nearly all.
"""

from __future__ import annotations

import importlib.util
import io
import json
import sys
import tarfile
import zipfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from converters.frames.io import write_frame
from converters.scene_folder import plain_document
from minirt import load_scene
from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.mutants import CATALOGUE, ORIGINAL
from tests.helpers.places import TESTS

SUBJECTS = TESTS / "subjects"

#: Every rule shows on these, in pictures of 48 × 36 pixels.
SCENES = (
    "ball-on-quad", "left-handed-frame", "behind-the-observer", "pentagon-and-octagon",
    "inside-a-sphere", "inside-glass", "snells-window", "overlapping-spheres",
)  # fmt: skip
PARTS: dict[str, tuple[str, ...]] = {
    "screen": ("S1", "S2", "S3"),
    "order": ("S4", "S5", "S6"),
    "spheres": ("S8",),
    "triangles": ("S9",),
    "polygons": ("S10", "S11"),
    "shadows": ("S12",),
    "light": ("S7", "S13"),
    "mirrors": ("S14",),
    "glass": ("S15", "S16"),
}
#: Each part's points.
POINTS = 4.0
TOTAL = POINTS * len(PARTS)


@dataclass(frozen=True)
class Submission:
    """One of the class, and what it must come to.

    Attributes
    ----------
    name : str
    make : callable
        Writes the submission into the class's folder.
    points : float
        What it must earn in all.
    right : str
        The part in which it must lose marks; empty where it is some other thing.
    keeps : str
        Parts that must earn all of their points, separated by blanks.
    message : str
        What must be said where there is nothing to grade.
    submitted : str
    """

    name: str
    make: Callable[[Path], None]
    points: float
    right: str = ""
    keeps: str = ""
    message: str = ""
    submitted: str = "2027-01-31T12:00:00+00:00"


def small(name: str) -> Scene:
    """A scene of the atlas in few pixels."""
    scene = load_scene(f"atlas:{name}")
    document = scene.to_dict()
    document["screen"] |= {"nx": 48, "ny": 36}
    return load_scene(document, scene.folder)


def write_rubric(folder: Path, scenes: Sequence[str] = SCENES, extra: str = "") -> Path:
    """The class's rubric, its scenes beside it."""
    for name in scenes:
        text = json.dumps(small(name).to_dict())
        (folder / f"{name}.json").write_text(text, encoding="utf-8")
    lines = ['title = "Ray tracing, the sample class"', "zero = 0.5"]
    lines += [f"scenes = {[f'{name}.json' for name in scenes]}", extra]
    for name, rules in PARTS.items():
        lines += ["[[part]]", f'name = "{name}"', f"points = {POINTS}", f"rules = {list(rules)}"]
    path = folder / "rubric.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@cache
def honest(name: str) -> Frame:
    """A scene as the NumPy tracer renders it, which has nothing of minirt in it."""
    spec = importlib.util.spec_from_file_location("sample_tracer", SUBJECTS / "tracer.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["sample_tracer"] = module
    spec.loader.exec_module(module)
    arrays: dict[str, Any] = module.render(plain_document(small(name)))
    return Frame({k: np.asarray(v, QUANTITIES[k].dtype) for k, v in arrays.items()})


@cache
def mutant(mistake: str, name: str) -> Frame:
    """A scene as a mutant renders it."""
    return CATALOGUE.get(mistake, ORIGINAL).render(small(name))


Render = Callable[[str], Frame]


def by(mistake: str) -> Render:
    return lambda name: mutant(mistake, name)


def single(render: Render) -> Render:
    """What is computed in float64 and kept in float32."""

    def rounded(name: str) -> Frame:
        arrays = {
            quantity: array.astype(np.float32).astype(array.dtype)
            if array.dtype == np.float64
            else array
            for quantity, array in render(name).items()
        }
        return Frame(arrays)

    return rounded


def only(render: Render, *quantities: str) -> Render:
    return lambda name: Frame({q: render(name)[q] for q in quantities})


def frames(
    who: str, render: Render, scenes: Iterable[str] = SCENES, suffix: str = ".npz"
) -> Callable[[Path], None]:
    """A folder of frames."""

    def make(folder: Path) -> None:
        place = folder / who
        place.mkdir()
        for name in scenes:
            write_frame(render(name), place / f"{name}{suffix}")

    return make


def zipped(who: str, render: Render) -> Callable[[Path], None]:
    """The same in an archive, below a folder of its own."""

    def make(folder: Path) -> None:
        frames(f".{who}", render)(folder)
        with zipfile.ZipFile(folder / f"{who}.zip", "w") as archive:
            for path in sorted((folder / f".{who}").iterdir()):
                archive.write(path, f"homework/{path.name}")

    return make


def tarred(who: str, render: Render) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        frames(f".{who}", render)(folder)
        with tarfile.open(folder / f"{who}.tar.gz", "w:gz") as archive:
            for path in sorted((folder / f".{who}").iterdir()):
                archive.add(path, path.name)

    return make


def hostile(folder: Path) -> None:
    with tarfile.open(folder / "olga.tar.gz", "w:gz") as archive:
        info = tarfile.TarInfo("../../evil.txt")
        info.size = 4
        archive.addfile(info, io.BytesIO(b"evil"))


def words(folder: Path) -> None:
    (folder / "pavel").mkdir()
    (folder / "pavel" / "essay.txt").write_text("why I like rays", encoding="utf-8")


def broken(folder: Path) -> None:
    frames("quentin", honest, SCENES[:4])(folder)
    for name in SCENES[4:]:
        (folder / "quentin" / f"{name}.npz").write_bytes(b"PK\x03\x04 not a frame")


def wrong(
    who: str, mistake: str, points: float, right: str, keeps: str, make: Any = frames
) -> Submission:
    return Submission(who, make(who, by(mistake)), points, right, keeps)


_ALL = " ".join(PARTS)

CLASS: tuple[Submission, ...] = (
    Submission("ana", frames("ana", honest), TOTAL, keeps=_ALL),
    Submission("boris", zipped("boris", honest), TOTAL, keeps=_ALL),
    Submission("carmen", tarred("carmen", single(honest)), TOTAL, keeps=_ALL),
    Submission("dan", frames("dan", honest, suffix=".exr"), TOTAL, keeps=_ALL),
    Submission("élodie", frames("élodie", honest), TOTAL * 0.8, keeps=_ALL,
               submitted="2027-02-02T13:00:00+01:00"),
    wrong("farid", "no-half-pixel", 11.0, "screen", "shadows light"),
    wrong("greta", "nearest-by-object-order", 29.4, "order", "screen shadows glass", zipped),
    wrong("hugo", "far-root", 29.29, "spheres", "screen triangles polygons shadows"),
    wrong("irina", "weights-exchanged", 32.0, "triangles", _ALL.replace("triangles ", "")),
    wrong("jan", "last-fan-triangle-missing", 24.96, "polygons", "screen spheres light"),
    wrong("katya", "light-not-negated", 31.2, "shadows",
          "screen order spheres triangles polygons mirrors glass"),
    wrong("lars", "no-ambient", 32.67, "light", _ALL.replace("light ", "")),
    wrong("mira", "reflection-sign", 30.86, "mirrors",
          "screen order spheres triangles polygons shadows glass"),
    wrong("nadia", "s-on-the-incident-side", 31.94, "glass",
          "screen order spheres triangles polygons shadows mirrors"),
    Submission("olga", hostile, 0.0, message="leads out of the archive"),
    Submission("pavel", words, 0.0, message="nothing to grade"),
    Submission("quentin", broken, 17.67, "glass"),
    Submission("rosa", frames("rosa", only(honest, "hit", "depth")), 5.13, "light"),
    Submission("sven", frames("sven", by("light-not-negated")), 31.2, "shadows"),
    Submission("tara", frames("tara", by("none")), TOTAL, keeps=_ALL),
)  # fmt: skip

LATE = """
[late]
deadline = 2027-02-01T12:00:00+00:00
per_day = 0.2
"""


def write_class(folder: Path) -> tuple[Path, Path, Path]:
    """The submissions, the rubric and the times of the sample class."""
    handed = folder / "submissions"
    handed.mkdir()
    for each in CLASS:
        each.make(handed)
    times = folder / "times.csv"
    rows = ["student,submitted", *(f"{each.name},{each.submitted}" for each in CLASS)]
    times.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return handed, write_rubric_late(folder), times


def write_rubric_late(folder: Path) -> Path:
    path = write_rubric(folder)
    path.write_text(path.read_text(encoding="utf-8") + LATE, encoding="utf-8")
    return path
