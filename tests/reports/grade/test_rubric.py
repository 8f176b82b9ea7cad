"""A rubric says what earns points; every fault in one is a sentence of its own."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from minirt.errors import MinirtError
from minirt.quantities import QUANTITIES
from reference.mutants import CATALOGUE
from reference.traceability import TRACED
from reports.grade.assignment.assignment import read_assignment
from reports.grade.assignment.part_quantities import quantities_of
from reports.grade.assignment.rubric import HiddenScenes, LatePolicy, Part, ProgramLimits, Rubric
from reports.grade.judging.tally import credit
from reports.grade.submission.manifest import Manifest
from tests.helpers.places import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")

GOOD = """
title = "Spheres"
scenes = ["atlas:one-sphere", "atlas:ball-on-quad"]
[[part]]
name = "the sphere"
points = 6
rules = ["S8"]
[[part]]
name = "shadows"
points = 4
stages = ["shadow"]
"""


def written(text: str, folder: Path) -> Path:
    path = folder / "rubric.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_good_rubric_finds_its_scenes_and_quantities(tmp_path: Path) -> None:
    got = read_assignment(written(GOOD, tmp_path))
    assert got.rubric.points == 10
    assert [assigned.scene.name for assigned in got.scenes] == ["one-sphere", "ball-on-quad"]
    assert all(assigned.public for assigned in got.scenes)
    assert got.parts[0][0] == ("one-sphere", "ball-on-quad")
    assert {"hit", "t", "normal"} <= set(got.parts[0][1])
    assert got.parts[1][1] == ("shadow",)


@pytest.mark.parametrize(
    ("was", "now", "words"),
    [
        ('rules = ["S8"]', 'rules = ["S17"]', "no rule that pictures can show; got S17"),
        ('rules = ["S8"]', 'rules = ["S16"]', "no scene of the rubric lists its rules; got S16"),
        ('rules = ["S8"]', 'rules = ["S8"]\nstages = ["t"]', "rules or stages, not both"),
        ('["shadow"]', '["shade"]', "part[1].stages[0]"),
        ("points = 4", "points = 0", "part[1].points: not what the key takes; got 0"),
        ("points = 4", 'points = "many"', "got 'many'; expected a valid number"),
        ("points = 4", "", "part[1].points: a key is missing"),
        ("points = 4", "points = 4\nbonus = 1", "part[1].bonus: there is no such key"),
        ('name = "shadows"', 'name = "the sphere"', "two parts are called 'the sphere'"),
        ("points = 4", "points = 4\nfull = 0.5\nzero = 0.5", "zero must be below full"),
        ('title = "Spheres"', 'quantities = ["dept"]', "there is no quantity 'dept'"),
        ('title = "Spheres"', 'quantities = ["ray"]', "nothing that is asked for shows it"),
        ("atlas:one-sphere", "atlas:one-spere", "one-spere"),
        ("atlas:one-sphere", "absent.json", "absent.json"),
        ('"atlas:ball-on-quad"', '"atlas:one-sphere"', "two scenes have the same name"),
        ("points = 4", 'points = 4\nscenes = ["atlas:alpha"]', "not among the rubric's scenes"),
        ("points = 4", "points = = 4", "not TOML"),
        ("points = 4", f"points = {'9' * 5000}", "not TOML; got Exceeds the limit"),
        ("points = 4", f"points = {'[' * 5000}", "not TOML; got maximum recursion"),
        ("points = 4", "points = 3.333", "hundredths of a point, and 3.333 is not"),
        ("points = 4", "points = nan", "part[1].points: not what the key takes; got nan"),
        ('title = "Spheres"', "limits = {memory_mb = 99999999}", "limits.memory_mb: not what"),
        ('["atlas:one-sphere", "atlas:ball-on-quad"]', "[]", "got []; expected at least one"),
        ('title = "Spheres"', "title = 3", "title: not what the key takes; got 3"),
        ('title = "Spheres"', "late = {deadline = 2027-01-31T12:00:00}", "an offset from UTC"),
    ],
)  # fmt: skip
def test_a_fault_is_one_sentence(was: str, now: str, words: str, tmp_path: Path) -> None:
    assert was in GOOD
    with pytest.raises(MinirtError) as caught:
        read_assignment(written(GOOD.replace(was, now, 1), tmp_path))
    text = str(caught.value)
    assert words in text
    assert "\n" not in text.split("got")[0]
    assert caught.value.exit_status == 2


def test_a_rubric_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(MinirtError, match=r"absent\.toml: cannot be read; got No such file"):
        read_assignment(tmp_path / "absent.toml")


@pytest.mark.parametrize("rule", TRACED)
def test_a_rule_is_judged_wherever_a_known_mistake_in_it_shows_first(rule: str) -> None:
    judged = {QUANTITIES[name].stage for name in quantities_of(rule)}
    assert judged >= {m.stage for m in CATALOGUE.values() if m.rule == rule}
    assert judged


@pytest.mark.parametrize(
    ("share", "earned"), [(1.0, 1.0), (0.99, 0.9), (0.95, 0.5), (0.9, 0.0), (0.2, 0.0)]
)
def test_partial_credit_is_linear(share: float, earned: float) -> None:
    assert credit(share, full=1.0, zero=0.9) == pytest.approx(earned)


def readme_blocks() -> list[str]:
    section = README.partition("## Grading a class")[2].partition("\n## ")[0]
    return re.findall(r"^```toml\n(.*?)^```", section, re.MULTILINE | re.DOTALL)


def test_the_readmes_files_are_taken(tmp_path: Path) -> None:
    manifest, rubric = readme_blocks()
    got = read_assignment(written(rubric, tmp_path))
    assert got.rubric.points == 15
    assert [assigned.number for assigned in got.scenes] == [0, 0, 1, 1]
    assert Manifest.model_validate(tomllib.loads(manifest)).build == "make"


def test_every_key_of_a_rubric_is_in_the_readme() -> None:
    section = README.partition("| key of the rubric |")[2].partition("\n\n")[0]
    named = set(re.findall(r"`(\w+)`", "".join(re.findall(r"^\|([^|]*)\|", section, re.M))))
    models = (Rubric, Part, HiddenScenes, LatePolicy, ProgramLimits)
    keys = {key for model in models for key in model.model_fields}
    assert named == keys
