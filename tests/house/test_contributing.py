"""The way from `render` to a rule, as CONTRIBUTING.md has it, is the way that the calls take."""

from __future__ import annotations

import sys
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

import minirt
from tests.helpers.documents import rows, text_of
from tests.helpers.places import ROOT

Step = tuple[str, str]
#: By rule: the heading of its table, a scene and a quantity that need it, and the call that the
#: table leads through.
WAYS = {
    "S8": ("### S8: a sphere", "one-sphere", "depth", "trace_pixels"),
    "S12": ("### S12: a shadow", "ball-on-quad", "shadow", "RayTree.shadow"),
    "S16": ("### S16: a refracted ray", "glass-ball", "refraction", "RayTree.refracted"),
}


def written(heading: str) -> list[Step]:
    """The calls and files of a table, without its header."""
    section = text_of("CONTRIBUTING.md").partition(heading)[2].partition("\n#")[0]
    return [(row[0].strip("`"), row[1].strip("`")) for row in rows(section)[2:]]


def taken(scene: str, quantity: str, steps: list[Step]) -> list[Step]:
    """The calls from `render` to the last of some steps, at the first time that all are passed."""
    found: list[Step] = []

    def watch(frame: FrameType, event: str, _: Any) -> None:
        if event == "call" and not found and step_of(frame) == steps[-1]:
            way = way_to(frame)
            if set(steps) <= set(way):
                found.extend(way)

    loaded = minirt.load_scene(f"atlas:{scene}")
    sys.setprofile(watch)
    try:
        minirt.render(loaded, quantities=quantity)
    finally:
        sys.setprofile(None)
    return found


def way_to(frame: FrameType | None) -> list[Step]:
    way: list[Step] = []
    while frame is not None and step_of(frame)[1].startswith("minirt/"):
        way.insert(0, step_of(frame))
        frame = frame.f_back
    return way


def step_of(frame: FrameType) -> Step:
    file = Path(frame.f_code.co_filename)
    inside = file.is_relative_to(ROOT)
    return frame.f_code.co_qualname, file.relative_to(ROOT).as_posix() if inside else str(file)


@pytest.mark.parametrize("rule", WAYS)
def test_the_way_to_a_rule_is_the_one_that_is_written_down(rule: str) -> None:
    heading, scene, quantity, through = WAYS[rule]
    steps = written(heading)
    assert through in [name for name, _ in steps]
    assert taken(scene, quantity, steps) == steps
