"""What is found of a scene of the atlas by every reference that is here, made once a test run.

A scene is rendered once for all its references and quantities, in a child process that stays for
the whole session. What came out is kept in a file, which pytest-xdist's workers share: while one
is at a scene, another goes on with the next.
"""

from __future__ import annotations

import fcntl
import os
import pickle
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import NamedTuple

from minirt import load_scene
from minirt.quantities import QUANTITIES
from minirt.scene import Scene
from reference.compare.check import Check, without_answer
from reference.exact import Judgement
from reference.jobs.isolate import Workers
from reference.registry import USUAL, choose_references
from reference.source import Reference, Unsupported
from reference.verify.options import TIMEOUT
from reference.verify.rendering import render_to_file
from reference.verify.scene import compare_scene

NAMES = tuple(QUANTITIES)
#: References without which a test fails: CI names them.
REQUIRED = choose_references(
    name.strip() for name in os.environ.get("MINIRT_REQUIRE", "").split(",") if name.strip()
)
#: Compared on the whole atlas at full size, as minirt verify does.
USED = tuple(r for r in choose_references(USUAL) if r in REQUIRED or not r.missing())
#: Mitsuba's scalar variant runs pixel by pixel: it is compared on small images only.
SCALAR = choose_references(["mitsuba-scalar"])[0]
_SCALAR_IS_HERE = SCALAR in REQUIRED or not SCALAR.missing()

#: The sizes of the atlas's images in the tests.
SMALL, FULL = "64x48", "256x192"
BY_SIZE: dict[str, tuple[Reference, ...]] = {
    SMALL: tuple(dict.fromkeys((*USED, *([SCALAR] if _SCALAR_IS_HERE else [])))),
    FULL: USED,
}


class Verdict(NamedTuple):
    """The checks of one scene, by reference and quantity, and minirt before the judge."""

    checks: dict[str, dict[str, Check]]
    judgement: Judgement


#: The verdict on a scene, by its name and the size of its image.
Verdicts = Callable[[str, str], Verdict]


@contextmanager
def shared_verdicts(
    shared: Path, scratch: Callable[[str], Path], wanted: Iterable[tuple[str, str]]
) -> Iterator[Verdicts]:
    """Verdicts that the processes which share a folder make once between them.

    Parameters
    ----------
    shared : Path
        Where verdicts are kept.
    scratch : callable
        Makes a fresh folder with a name.
    wanted : iterable of (scene, size)
        What will be asked for: made while another process is at what was asked.
    """
    pending = dict.fromkeys(wanted)
    with Workers(1) as workers:

        def kept(scene: str, size: str) -> Path:
            return shared / f"{scene}-{size}.pickle"

        def make(scene: str, size: str, wait: bool = False) -> bool:
            """Whether it is made by now: if not, another process is at it."""
            with kept(scene, size).with_suffix(".lock").open("w") as lock:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
                except BlockingIOError:
                    return False
                if not kept(scene, size).exists():
                    found = _verdict(scene, size, workers, scratch(scene))
                    kept(scene, size).write_bytes(pickle.dumps(found))
            return True

        @cache
        def verdict(scene: str, size: str) -> Verdict:
            for other in pending:
                if make(scene, size):
                    break
                make(*other)
            make(scene, size, wait=True)
            result: Verdict = pickle.loads(kept(scene, size).read_bytes())  # noqa: S301 - our own
            return result

        yield verdict


def atlas_scene(name: str, size: str) -> Scene:
    """A scene of the atlas, its image in one of the sizes."""
    scene = load_scene(f"atlas:{name}")
    nx, ny = map(int, size.split("x"))
    document = scene.to_dict()
    document["screen"] |= {"nx": nx, "ny": ny}
    return load_scene(document, scene.folder)


def _verdict(name: str, size: str, workers: Workers, folder: Path) -> Verdict:
    """Render and judge one scene by every reference that is compared at this size."""
    scene = atlas_scene(name, size)
    answers, checks = [], {}
    for reference in BY_SIZE[size]:
        room = folder / reference.name
        room.mkdir()
        outcome = workers.submit(TIMEOUT, render_to_file, reference, scene, room).outcome()
        if outcome.state == "done":
            answers.append((reference, outcome.value))
        elif isinstance(outcome.value, Unsupported):
            checks[reference.name] = without_answer(NAMES, "not supported", str(outcome.value))
        else:
            reason = f"{outcome.reason}\n{outcome.output}"
            checks[reference.name] = without_answer(NAMES, "crashed", reason)
    verdict = compare_scene(scene, answers)
    checks |= {name: found.checks for name, found in verdict.references.items()}
    by_quantity = {
        name: {check.quantity: check for check in found} for name, found in checks.items()
    }
    return Verdict(by_quantity, verdict.judgement)
