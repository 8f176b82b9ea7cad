"""Implementations for the gate's tests: minirt under given rules, as functions and as programs."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import minirt
from converters.frames.io import write_frame
from minirt.frame import Frame
from minirt.rules import Rules
from minirt.screen import VirtualScreen, pixel_center
from minirt.vectors import Floats

Arrays = dict[str, Any]


def _rendered(scene: dict[str, Any], rules: Rules = minirt.SLIDES) -> Arrays:
    folder = scene.pop("folder")
    return dict(minirt.render(minirt.load_scene(scene, folder), rules=rules).arrays)


def honest(scene: dict[str, Any]) -> Arrays:
    """Every quantity, right."""
    return _rendered(scene)


def corner(screen: VirtualScreen, i: Floats, j: Floats) -> tuple[Floats, Floats]:
    """A pixel's corner in the place of its centre."""
    return pixel_center(screen, i - 0.5, j - 0.5)


def no_half_pixel(scene: dict[str, Any]) -> Arrays:
    """Rays through the pixels' corners."""
    return _rendered(scene, minirt.SLIDES.replace(pixel_center=corner))


def few(scene: dict[str, Any]) -> Arrays:
    """Only hit and depth."""
    arrays = _rendered(scene)
    return {name: arrays[name] for name in ("hit", "depth")}


def single(scene: dict[str, Any]) -> Arrays:
    """Every quantity, float64 numbers rounded to float32."""
    return {
        name: array.astype(np.float32) if array.dtype == np.float64 else array
        for name, array in _rendered(scene).items()
    }


def one_nan(scene: dict[str, Any]) -> Arrays:
    """A pixel of depth that is no number where a number belongs."""
    arrays = _rendered(scene)
    row, column = np.argwhere(arrays["hit"])[100]
    arrays["depth"][row, column] = np.nan
    return arrays


def wrong_size(scene: dict[str, Any]) -> Arrays:
    """Half of the rows."""
    return {"hit": _rendered(scene)["hit"][::2]}


def unknown_name(scene: dict[str, Any]) -> Arrays:
    """A quantity that there is not."""
    return {"dept": _rendered(scene)["depth"]}


def no_mapping(scene: dict[str, Any]) -> list[int]:
    """Something else than arrays by name."""
    return [1, 2, 3]


def raising(scene: dict[str, Any]) -> Arrays:
    """A mistake of its own."""
    raise ZeroDivisionError("the light is off")


def leaving(scene: dict[str, Any]) -> Arrays:
    """What a function that was a program does at its end."""
    sys.exit(0)


def widening(scene: dict[str, Any]) -> Arrays:
    """Positions far off, and a claim put in the place of its author's."""
    from dataclasses import replace

    from reference.renderers.external import function

    claimed = function.declared  # type: ignore[attr-defined]
    function.declared = lambda *args: replace(claimed(*args), steps=(("position", 1e9),))  # type: ignore[attr-defined]
    arrays = _rendered(scene)
    arrays["position"] += 1
    return arrays


def main(path: str, out: str, answer: Callable[[dict[str, Any]], Arrays] = honest) -> None:
    """Render the scene in a file to a file or a folder."""
    scene = minirt.load_scene(path)
    document = scene.to_dict() | {"folder": str(Path(path).parent)}
    write_frame(Frame(answer(document)), out)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
