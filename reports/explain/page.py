"""`minirt explain --html`: the inspector of one pixel, a page of its own."""

from __future__ import annotations

import base64
import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from converters.atomic import atomic_file
from minirt.errors import InputError
from minirt.explain.pixel import Explanation
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reports.explain.second_opinion import SecondOpinion
from reports.explain.space import surroundings
from reports.explain.text import spelled
from reports.page.data import inside_script
from reports.page.inspector.details import explanation_json
from reports.page.matrix import CAUSAL
from reports.page.rerun import command_test
from reports.page.template import template
from reports.page.thumbnails import Thumbnail, scene_thumbnail
from reports.results.words import RULE_NAMES, number, times, values

#: The parts of the page's script, in the order in which they need each other.
_SCRIPT = ("dom", "space")


def write_pixel_page(
    path: Path,
    scene: Scene,
    explanation: Explanation,
    opinion: SecondOpinion | None,
    command: Sequence[str],
) -> None:
    """Write the page of one pixel, whole or not at all.

    Parameters
    ----------
    path : Path
    scene : Scene
    explanation : Explanation
        Of one of its pixels.
    opinion : SecondOpinion or None
        What another implementation has there.
    command : sequence of str
        The words of the command that explains this pixel.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    text = pixel_html(scene, explanation, opinion, command)
    try:
        with atomic_file(path) as new:
            new.write_text(text, encoding="utf-8", newline="\n")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        where = repr(str(path))[:300]
        raise InputError("the page cannot be written", where=where, got=reason) from None


def pixel_html(
    scene: Scene,
    explanation: Explanation,
    opinion: SecondOpinion | None,
    command: Sequence[str],
) -> str:
    """The page of one pixel."""
    column, row = explanation.column, explanation.row
    thumbnail = scene_thumbnail(scene)
    steps_and_lines = json.loads(explanation_json(scene, column, row))
    test = command_test("this_pixel", command)
    return template("pixel.html.j2").render(
        scene=scene,
        column=column,
        row=row,
        sentence=_sentence(explanation, opinion),
        wrong=opinion is not None and bool(opinion.first or opinion.trouble),
        who="" if opinion is None else opinion.name,
        rows=_own_values(explanation)
        if opinion is None or not opinion.rows
        else _both_values(opinion),
        steps=[
            (
                step.rule,
                step.title,
                step.sentence,
                [(k, spelled(v)) for k, v in step.values.items()],
            )
            for step in explanation.steps
        ],
        rules=RULE_NAMES,
        thumbnail=_placed(thumbnail, scene, column, row),
        command=shlex.join(command),
        test=test.replace("COLUMN", str(column)).replace("ROW", str(row)),
        data=inside_script({"space": surroundings(scene), "explanation": steps_and_lines}),
        script=[f"scripts/{part}.js" for part in _SCRIPT],
    )


def _sentence(explanation: Explanation, opinion: SecondOpinion | None) -> str:
    if opinion is not None:
        return opinion.sentence
    return next(step.sentence for step in explanation.steps if step.title == "the first object hit")


def _placed(thumbnail: Thumbnail, scene: Scene, column: int, row: int) -> dict[str, Any]:
    """minirt's picture of the scene, and where the pixel is on it, in per cent."""
    screen = scene.screen
    return {
        "png": base64.b64encode(thumbnail.png).decode(),
        "width": thumbnail.width,
        "height": thumbnail.height,
        "left": 100 * (column + 0.5) / screen.nx,
        "top": 100 * (row + 0.5) / screen.ny,
    }


def _own_values(explanation: Explanation) -> list[dict[str, Any]]:
    """minirt's own values; a quantity that no step computes is left out."""
    found: dict[str, Any] = {}
    for step in explanation.steps:
        if step.rule == "S1" or step.title.startswith("object "):
            continue  # t is the screen's upper border there, or one candidate's own
        found |= {k: v for k, v in step.values.items() if k in QUANTITIES and k not in found}
    return [
        {"quantity": name, "rule": QUANTITIES[name].rules[0], "ours": _lines(found[name])}
        for name in CAUSAL
        if name in found
    ]


def _lines(value: Any) -> list[str]:
    return [spelled(x).strip() for x in (value if isinstance(value, tuple) else (value,))]


def _both_values(opinion: SecondOpinion) -> list[dict[str, Any]]:
    rows = []
    for row in opinion.rows:
        discrete = QUANTITIES[row.quantity].discrete
        state = "uncertain" if row.ratio != row.ratio else "wrong" if row.wrong else "agrees"
        rows.append(
            {
                "quantity": row.quantity,
                "rule": QUANTITIES[row.quantity].rules[0],
                "ours": _components(row.quantity, row.ours),
                "theirs": _components(row.quantity, row.theirs),
                "tolerance": "equal" if discrete else number(row.tolerance),
                "state": state,
                "ratio": "" if discrete or state == "uncertain" else times(row.ratio),
            }
        )
    return rows


def _components(name: str, components: tuple[float, ...]) -> list[str]:
    if QUANTITIES[name].discrete:
        return [values(name, list(components))]
    return _lines(components)
