"""The gate as a pytest plugin: ``pytest --minirt-gate-cmd '…'``, one test a scene and quantity.

Nothing of minirt is imported until one of its options is used.
"""

from __future__ import annotations

import fcntl
import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from minirt.scene import Scene
    from reference.compare.check import Check
    from reference.source import Reference
    from reports.gate.subject import Subject

#: By scene and quantity.
Checks = dict[tuple[str, str], "Check"]

_CHECKS = pytest.StashKey[Checks]()
_PREFIX = "--minirt-gate-"
_OPTIONS = {
    "cmd": "a program, as 'PROGRAM {scene} {out}': one test a scene and quantity",
    "python": "a function, as module:function",
    "frames": "a folder of frames rendered earlier",
    "scenes": "scenes separated by commas (default: the whole atlas)",
    "quantities": "quantities separated by commas (default: all)",
    "require": "quantities that must be given, separated by commas",
    "precision": "float64 (default), float32 or half",
    "handed": "the number format in which numbers come: float64, float32 or half",
    "delta": "the error that it declares, in scene units",
    "max-delta": "the widest error that may be declared, in scene units",
    "start": "where its secondary rays start, in scene units",
    "scene-as": "json (default), mitsuba, povray or obj",
    "out-as": "exr (default), npz or folder",
    "timeout": "seconds for each scene (default: 60)",
}
#: Those that say what is judged, not who.
_CHOICES = ("scenes", "quantities", "require")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options: those of ``minirt gate``."""
    group = parser.getgroup("minirt", "minirt's gate: another implementation, pixel by pixel")
    for name, about in _OPTIONS.items():
        group.addoption(_PREFIX + name, default="", help=about)
    group.addoption(f"{_PREFIX}sandbox", action="store_true", help="run the program in a sandbox")


@pytest.hookimpl(tryfirst=True)  # before -k chooses
def pytest_collection_modifyitems(session: pytest.Session, items: list[pytest.Item]) -> None:
    """Add a test for each scene and quantity, where something is to be judged."""
    if any(_option(session.config, name) for name in ("cmd", "python", "frames")):
        gate = _Gate.from_parent(session, name="minirt-gate", nodeid="minirt-gate")
        items.extend(gate.collect())


def _option(config: pytest.Config, name: str) -> str:
    value: str = config.getoption(_PREFIX + name)
    return value


def _subject(config: pytest.Config) -> Subject:
    """The implementation that the options name."""
    from reports.gate.subject import Subject

    given = {name: _option(config, name) for name in (*_OPTIONS, "sandbox")}
    own = {name: value for name, value in given.items() if value and name not in _CHOICES}
    return Subject.of({name.replace("-", "_"): value for name, value in own.items()})


class _Gate(pytest.Collector):
    """All tests of one implementation."""

    def collect(self) -> list[pytest.Item]:
        from minirt.errors import MinirtError
        from minirt.render import chosen_quantities
        from reports.inputs import chosen_scenes, names_in

        chosen = names_in(_option(self.config, "scenes"))
        try:
            subject = _subject(self.config).reference()
            scenes = chosen_scenes(chosen)
            names = chosen_quantities(_option(self.config, "quantities") or None)
            for scene in scenes:
                subject.declare(scene)
        except MinirtError as error:
            raise pytest.UsageError(f"minirt's gate: {error}") from None
        return [
            GateItem.from_parent(
                self, name=f"{scene.name}-{name}", scene=scene, quantity=name, subject=subject
            )
            for scene in scenes
            for name in names
        ]


class GateItem(pytest.Item):
    """One quantity of one scene."""

    def __init__(self, *, scene: Scene, quantity: str, subject: Reference, **more: Any) -> None:
        super().__init__(**more)
        self.scene, self.quantity, self.subject = scene, quantity, subject

    def runtest(self) -> None:
        """Look up how it ended; the first test has all scenes judged that were selected."""
        check = _checks(self)[self.scene.name, self.quantity]
        if check.state in ("not given", "not supported"):
            pytest.skip(f"{check.state}: {check.reason}")
        if check.state != "passed":
            raise GateFailure(check)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """What is wrong, in a sentence, with the worst pixel."""
        if isinstance(excinfo.value, GateFailure):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Where pytest says that the test is."""
        return Path("minirt-gate"), None, f"minirt-gate: {self.name}"


class GateFailure(Exception):
    """A check that did not pass."""

    def __init__(self, check: Check) -> None:
        from reports.results.words import worst_in_words

        worst = f"\nworst pixel {worst_in_words(check)}" if check.wrong else ""
        super().__init__(f"{check.quantity}: {check.state}: {check.reason}{worst}")


def _checks(item: GateItem) -> Checks:
    """The checks of every selected scene; with pytest-xdist made by one worker for all."""
    stash = item.config.stash
    if _CHECKS not in stash:
        stash[_CHECKS] = _shared(item) if hasattr(item.config, "workerinput") else _judged(item)
    return stash[_CHECKS]


def _shared(item: GateItem) -> Checks:
    kept = Path(item.config.option.basetemp).parent / "minirt-gate.pickle"
    kept.parent.mkdir(parents=True, exist_ok=True)
    with kept.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not kept.exists():
            kept.write_bytes(pickle.dumps(_judged(item)))
        found: Checks = pickle.loads(kept.read_bytes())  # noqa: S301 - this run's own
        return found


def _judged(item: GateItem) -> Checks:
    from minirt.render import chosen_quantities
    from reference.verify.options import Options
    from reference.verify.run import verify
    from reports.inputs import usual_cache

    chosen = [each for each in item.session.items if isinstance(each, GateItem)]
    scenes = list({each.scene.name: each.scene for each in chosen}.values())
    required = _option(item.config, "require")
    options = Options(
        quantities=tuple(dict.fromkeys(each.quantity for each in chosen)),
        required=chosen_quantities(required) if required else (),
        timeout=_subject(item.config).process_timeout,
        cache=usual_cache(),
    )
    return dict(_by_name(verify(scenes, [item.subject], options)))


def _by_name(results: Any) -> Iterator[tuple[tuple[str, str], Check]]:
    for result in results:
        for answer in result.references:
            for check in answer.checks:
                yield (result.scene.name, check.quantity), check
