"""`minirt gate`: somebody else's implementation, judged on many scenes."""

from __future__ import annotations

import os
from datetime import date, timedelta
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.console import Json, answers, people, print_json, progress

if TYPE_CHECKING:
    from minirt.scene import Scene
    from reference.cache import Cache
    from reference.precision import Claim
    from reference.source import Reference
    from reports.baseline import Baseline

#: Days for which a new entry of a baseline excuses a failure.
_DAYS = 90
#: Seconds beyond a program's own limit after which what runs it is taken to hang.
GRACE = 60.0


class SceneLanguage(StrEnum):
    """In which language a program takes its scenes."""

    json = "json"
    mitsuba = "mitsuba"
    povray = "povray"
    obj = "obj"


class OutFormat(StrEnum):
    """In which format a program writes its frames."""

    exr = "exr"
    npz = "npz"
    folder = "folder"
    mitsuba = "mitsuba"


class Language(StrEnum):
    """In which language a starter kit begins a tracer."""

    cpp = "cpp"
    javascript = "javascript"
    python = "python"


class Format(StrEnum):
    """The number format that an implementation computes in."""

    float64 = "float64"
    float32 = "float32"
    half = "half"


Cmd = Annotated[
    str,
    typer.Option(
        "--cmd", metavar="'PROGRAM {scene} {out}'",
        help="A program, run once a scene: {scene} becomes the path of its scene, {out} the path "
        "to write; {nx} and {ny} the size.",
    ),
]  # fmt: skip
Python = Annotated[
    str,
    typer.Option(
        "--python", metavar="MODULE:FUNCTION",
        help="A function that takes a scene's dict and returns arrays by quantity.",
    ),
]  # fmt: skip
Frames = Annotated[
    Path | None,
    typer.Option(
        "--frames", metavar="DIR",
        help="What was rendered earlier: SCENE.npz, SCENE.exr or SCENE/ in a folder.",
    ),
]  # fmt: skip
SceneAsOption = Annotated[
    SceneLanguage, typer.Option("--scene-as", help="What {scene} is: minirt's JSON, or an export.")
]
OutAsOption = Annotated[
    OutFormat,
    typer.Option(
        "--out-as",
        help="What is written to {out}: folder is one of images, mitsuba "
        "the channels of its aov integrator.",
    ),
]
PrecisionOption = Annotated[
    Format,
    typer.Option(
        "--precision",
        help="The number format that it computes in; half where it hands over half.",
    ),
]
HandedOption = Annotated[
    Format | None,
    typer.Option(
        "--handed", show_default=False,
        help="The number format in which numbers come, where it is coarser than they were computed "
        "in: half channels, say. Without it float64 for .npz and functions, else float32.",
    ),
]  # fmt: skip
DeltaOption = Annotated[
    float | None,
    typer.Option(
        "--delta", metavar="LENGTH", min=0.0, show_default=False,
        help="The error that it declares, in scene units, in place of the precision's.",
    ),
]  # fmt: skip
StartOption = Annotated[
    float | None,
    typer.Option(
        "--start", metavar="LENGTH", min=0.0, show_default=False,
        help="Where its secondary rays start, in scene units, if not at the scene's ε.",
    ),
]  # fmt: skip
SandboxOption = Annotated[
    bool,
    typer.Option(
        "--sandbox",
        help="Run the program without network and with no view of anything but its scene.",
    ),
]


def gate(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(help="JSON files, - or atlas:NAME; without any the whole atlas."),
    ] = None,
    cmd: Cmd = "",
    python: Python = "",
    frames: Frames = None,
    scene_as: SceneAsOption = SceneLanguage.json,
    out_as: OutAsOption = OutFormat.exr,
    precision: PrecisionOption = Format.float64,
    handed: HandedOption = None,
    delta: DeltaOption = None,
    start: StartOption = None,
    most: Annotated[
        float | None,
        typer.Option(
            "--max-delta", metavar="LENGTH", min=0.0, show_default=False,
            help="The widest error that may be declared; a wider one is refused.",
        ),
    ] = None,
    sandbox: SandboxOption = False,
    quantities: Annotated[
        str, typer.Option(metavar="NAMES", help="Which to judge, separated by commas; all.")
    ] = "",
    require: Annotated[
        str, typer.Option(metavar="NAMES", help="Quantities that must be given.")
    ] = "",
    baseline: Annotated[
        Path | None,
        typer.Option(metavar="FILE", show_default=False, help="Failures that are known."),
    ] = None,
    update: Annotated[
        bool, typer.Option("--update-baseline", help="Record every failure of this run as known.")
    ] = False,
    reason: Annotated[str, typer.Option(help="Why new entries of the baseline fail.")] = "",
    until: Annotated[
        str,
        typer.Option(metavar="YYYY-MM-DD", help="Until when they are excused; 90 days from now."),
    ] = "",
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where the reports go.")
    ] = Path("report"),
    jobs: Annotated[
        int, typer.Option("--jobs", "-j", min=1, help="Processes of each kind; all processors.")
    ] = len(os.sched_getaffinity(0)),
    timeout: Annotated[
        int, typer.Option(min=1, metavar="SECONDS", help="For the program and a scene.")
    ] = 60,
    no_cache: Annotated[
        bool, typer.Option("--no-cache", help="Compute minirt's own frames anew.")
    ] = False,
    init: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", show_default=False,
            help="Judge nothing: write a starter kit, with the protocol, three scenes and a stub.",
        ),
    ] = None,
    language: Annotated[
        Language, typer.Option(help="Of the starter kit's stub.")
    ] = Language.python,
    json: Json = False,
) -> None:  # fmt: skip
    """Judge another implementation, pixel by pixel.

    It is given scenes, never minirt's frames. Every quantity that it gives is compared where the
    exact answer is stable under the error that it declares; there not one pixel may be wrong.
    """
    from minirt import load_scene
    from minirt.render import chosen_quantities
    from minirt.scene import atlas_names
    from reference.diagnose import diagnose
    from reports.record import results_document
    from reports.run import run_verify
    from reports.terminal import print_run

    if init is not None:
        _init(init, language, json)
        return
    claim = claim_of(precision, handed, delta, start, out_as, frames, python)
    subject = subject_of(
        cmd, python, frames, claim, scene_as, out_as, most=most, sandbox=sandbox, timeout=timeout
    )
    loaded = [load_scene(s) for s in scenes or [f"atlas:{name}" for name in atlas_names()]]
    require_distinct(loaded)
    for scene in loaded:
        subject.declare(scene)  # refused before anything is rendered
    known = _baseline(baseline, update)
    with progress("gate") as tell:
        done = iter(range(1, len(loaded) + 1))
        run = run_verify(
            loaded, [subject], out, jobs, [subject.name],
            lambda _, total: tell(next(done), total), timeout=timeout + GRACE,
            quantities=chosen_quantities(quantities or None),
            given=chosen_quantities(require) if require else (),
            cache=None if no_cache else usual_cache(), baseline=known, diagnose=diagnose,
        )  # fmt: skip
    print_run(run, people() if json else answers())
    if json:
        print_json(results_document(run))
    if update and baseline is not None and known is not None:
        from reports.baseline import write_baseline

        number = write_baseline(
            baseline, run.results, known, reason or "recorded when the gate was set up",
            _until(until, known.today),
        )  # fmt: skip
        people().print(f"{baseline}: {number} known failures", soft_wrap=True)
        raise typer.Exit(0)
    raise typer.Exit(run.exit_status)


def _init(folder: Path, language: Language, json: bool) -> None:
    from reports.starter_kit import write_kit

    files = [str(path) for path in write_kit(folder, language.value)]
    if json:
        print_json({"folder": str(folder), "files": files})
    people().print(f"{folder}: {len(files)} files. Begin with README.md.", soft_wrap=True)


def claim_of(
    precision: Format,
    handed: Format | None,
    delta: float | None,
    start: float | None,
    out_as: OutFormat,
    frames: Path | None,
    python: str,
) -> Claim:
    """What is claimed of the errors, the format of the files included."""
    from reference.precision import Claim

    ours = bool(python) or out_as is OutFormat.npz
    exact = ours if frames is None else _only_npz(frames)
    usual = Format.float64 if exact else Format.float32
    return Claim(precision.value, delta, start, (handed or usual).value)


def _only_npz(folder: Path) -> bool:
    return all(path.suffix == ".npz" for path in folder.iterdir()) if folder.is_dir() else False


def subject_of(
    cmd: str,
    python: str,
    frames: Path | None,
    claim: Claim,
    scene_as: SceneLanguage = SceneLanguage.json,
    out_as: OutFormat = OutFormat.exr,
    *,
    most: float | None = None,
    sandbox: bool = False,
    timeout: float = 60.0,
) -> Reference:
    """The implementation that is to be judged.

    Raises
    ------
    InputError
        None was named, or more than one; a command that says nowhere where to write.
    """
    from minirt.errors import InputError
    from reference.program import Limits
    from reference.renderers.external import (
        CommandSubject,
        FramesSubject,
        PythonSubject,
        command_words,
    )

    named = [name for name in (cmd, python, frames) if name]
    if len(named) != 1:
        raise InputError(
            "one implementation at a time is judged",
            got=f"{len(named)} of them", expected="one of --cmd, --python and --frames",
        )  # fmt: skip
    if sandbox and not cmd:
        raise InputError("only a program can run in a sandbox", where="--sandbox", expected="--cmd")
    if cmd:
        command_words(cmd)
        limits = Limits(wall_seconds=timeout, cpu_seconds=4 * timeout)
        return CommandSubject(
            cmd, claim, scene_as=scene_as.value, out_as=out_as.value,
            limits=limits, sandbox=sandbox, most=most,
        )  # fmt: skip
    if python:
        if ":" not in python:
            raise InputError(
                "not a function", where="--python", got=python[:80], expected="as module:function"
            )
        return PythonSubject(python, claim, most=most)
    return FramesSubject(Path(frames or "").absolute(), claim, most=most)


def require_distinct(scenes: list[Scene]) -> None:
    """Frames, and entries of a baseline, go by a scene's name.

    Raises
    ------
    InputError
        Two scenes of one name.
    """
    from minirt.errors import InputError

    names = [scene.name for scene in scenes]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise InputError("two scenes have the same name", got=", ".join(sorted(twice))[:200])


def usual_cache() -> Cache:
    """Where minirt's own frames and their stability are kept."""
    from reference.cache import Cache, usual_folder

    return Cache(usual_folder())


def _baseline(path: Path | None, update: bool) -> Baseline | None:
    from minirt.errors import InputError
    from reports.baseline import Baseline, read_baseline

    today = date.today()
    if path is None:
        if update:
            raise InputError("no baseline to update", expected="--baseline FILE")
        return None
    if update and not path.exists():
        return Baseline((), today)
    return read_baseline(path, today)


def _until(text: str, today: date) -> date:
    from minirt.errors import InputError

    if not text:
        return today + timedelta(days=_DAYS)
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise InputError(
            "not a date", where="--until", got=repr(text)[:80], expected="as 2027-01-31"
        ) from None
