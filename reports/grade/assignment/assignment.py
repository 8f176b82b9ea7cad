"""An assignment: a rubric with its scenes loaded, their hidden variants made, all of it checked."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from minirt import load_scene
from minirt.errors import InputError
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.traceability import TRACED
from reports.grade.assignment.hidden import variant
from reports.grade.assignment.part_quantities import known_rule, quantities_judged
from reports.grade.assignment.rubric import Part, Rubric, read_rubric


@dataclass(frozen=True, eq=False)
class AssignedScene:
    """One scene that a submission is judged on.

    Attributes
    ----------
    scene : Scene
    number : int
        0 for the public scene; 1 and more for its hidden variants, which bear the same name.
    """

    scene: Scene
    number: int

    @property
    def public(self) -> bool:
        """Whether students may see it."""
        return self.number == 0


@dataclass(frozen=True, eq=False)
class Assignment:
    """What a class is graded by.

    Attributes
    ----------
    rubric : Rubric
    sha256 : str
        Of the rubric's file and every scene: another one, and marks are made anew.
    sheets : tuple of Sheet
        The public scenes, in the rubric's order, then the hidden ones.
    parts : tuple of (tuple of str, tuple of str)
        By part of the rubric: names of its scenes, and the quantities that it is judged by.
    """

    rubric: Rubric
    sha256: str
    scenes: tuple[AssignedScene, ...]
    parts: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]


def read_assignment(path: Path) -> Assignment:
    """Read a rubric and all that it names.

    Raises
    ------
    InputError, SceneError
        One error that names what is wrong and where.
    """
    rubric, sha256 = read_rubric(path)
    given: dict[str, Scene] = {}
    by_name: dict[str, Scene] = {}
    for text in rubric.scenes:
        scene = load_scene(text if text.startswith("atlas:") else _beside(path, text))
        _require_file_name(scene, f"{path}: scenes: {text}")
        if scene.name in by_name:
            raise InputError("two scenes have the same name", where=str(path), got=scene.name)
        given[text] = by_name[scene.name] = scene
    parts = tuple(_part(rubric, part, given, f"{path}: part {part.name!r}") for part in rubric.part)
    scenes = [AssignedScene(scene, 0) for scene in by_name.values()]
    if rubric.hidden is not None:
        seed, variants = rubric.hidden.seed, rubric.hidden.variants
        scenes += [
            AssignedScene(variant(scene, seed, k), k)
            for scene in by_name.values()
            for k in range(1, variants + 1)
        ]
    together = " ".join([sha256, *(assigned.scene.sha256 for assigned in scenes)])
    return Assignment(rubric, together, tuple(scenes), parts)


def _beside(path: Path, text: str) -> Path:
    if Path(text).is_absolute() or ".." in Path(text).parts:
        raise InputError(
            "a scene that lies elsewhere", where=f"{path}: scenes", got=text[:200],
            expected="a file beside the rubric or below it, or atlas:NAME",
        )  # fmt: skip
    return path.parent / text


def _require_file_name(scene: Scene, where: str) -> None:
    if "/" in scene.name or scene.name.startswith(".") or not scene.name.isprintable():
        raise InputError(
            "frames go by their scene's name, and this is no file's", where=where,
            got=ascii(scene.name)[:80],
        )  # fmt: skip


def _part(
    rubric: Rubric, part: Part, given: dict[str, Scene], where: str
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    unknown = [rule for rule in part.rules if not known_rule(rule)]
    if unknown:
        raise InputError(
            "no rule that pictures can show", where=where, got=unknown[0],
            expected=", ".join(TRACED),
        )  # fmt: skip
    for text in part.scenes:
        if text not in given:
            raise InputError(
                "not among the rubric's scenes", where=where, got=text[:80],
                expected=", ".join(given)[:300],
            )  # fmt: skip
    chosen = [given[text] for text in part.scenes or given]
    if part.rules and not part.scenes:
        chosen = [scene for scene in chosen if set(part.rules) & set(scene.rules)]
    if not chosen:
        raise InputError(
            "no scene of the rubric lists its rules", where=where, got=", ".join(part.rules),
            expected="such a scene, or scenes named in the part",
        )  # fmt: skip
    names = quantities_judged(part, rubric.quantities)
    if not names:
        raise InputError(
            "nothing that is asked for shows it", where=where, got=", ".join(rubric.quantities),
            expected=", ".join(quantities_judged(part, tuple(QUANTITIES))),
        )  # fmt: skip
    return tuple(scene.name for scene in chosen), names
