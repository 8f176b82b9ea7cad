"""One run of the gate: an implementation judged on scenes, with its baseline and its history."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, field
from datetime import date, timedelta
from pathlib import Path

from minirt.errors import InputError
from minirt.render import chosen_quantities
from reference.diagnose.by_mutant import diagnose
from reference.verify.options import Callbacks, Options
from reports.gate.subject import Subject
from reports.history.recording import HistoryTarget, RecordedRun, recorded_run
from reports.inputs import cache_unless, chosen_scenes, scene_names
from reports.results.baseline import Baseline, read_baseline, write_baseline
from reports.results.mutants import read_kill_matrix
from reports.results.words import count
from reports.run import Progress, RunOptions

#: Days for which a new entry of a baseline excuses a failure.
_DAYS = 90


@dataclass(frozen=True)
class BaselineOptions:
    """The failures that are known.

    Attributes
    ----------
    path : Path or None
    update : bool
        Record every failure of the run as known.
    reason : str
        Why new entries fail.
    until : str
        The day until which they are excused, as YYYY-MM-DD; empty: 90 days from now.
    """

    path: Path | None = None
    update: bool = False
    reason: str = ""
    until: str = ""


@dataclass(frozen=True)
class GateOptions:
    """What is judged, and how.

    Attributes
    ----------
    scenes : list of str or None
        Names as on the command line; None: the atlas.
    quantities, require : str
        Names separated by commas: what to judge (empty: all), and what must be given.
    out : Path
        The folder of the reports.
    jobs : int
    mutants : Path or None
        A mutant matrix to be shown in the report.
    no_cache : bool
    baseline : BaselineOptions
    history : HistoryTarget
    """

    scenes: list[str] | None
    quantities: str = ""
    require: str = ""
    out: Path = Path("report")
    jobs: int = 2
    mutants: Path | None = None
    no_cache: bool = False
    baseline: BaselineOptions = BaselineOptions()
    history: HistoryTarget = field(default_factory=HistoryTarget)


@dataclass(frozen=True)
class GateRun:
    """A finished run of the gate, and what follows from it.

    Attributes
    ----------
    recorded : RecordedRun
    hint : str
        The command that explains the first wrong pixel; empty where there is none.
    known : Baseline or None
    until : date
        The day until which new entries of the baseline are excused.
    """

    recorded: RecordedRun
    hint: str
    known: Baseline | None
    until: date


def run_gate(subject: Subject, options: GateOptions, progress: Progress | None = None) -> GateRun:
    """Judge another implementation, and leave the reports in a folder.

    Raises
    ------
    InputError, SceneError
        An option is wrong, or a file that it names; nothing was rendered then.
    """
    judged, until = subject.reference(), _until(options.baseline.until)
    chosen = chosen_quantities(options.quantities or None)
    required = _required(options.require, chosen)
    scenes = chosen_scenes(options.scenes)
    for scene in scenes:
        judged.declare(scene)  # refused before anything is rendered
    known = _known_failures(options.baseline)
    matrix = None if options.mutants is None else read_kill_matrix(options.mutants)
    comparison = Options(
        chosen, required, subject.process_timeout, options.jobs, cache_unless(options.no_cache),
        Callbacks(diagnose=diagnose),
    )  # fmt: skip
    run_options = RunOptions(comparison, [judged.name], known, subject.name, mutants=matrix)
    recorded = recorded_run(scenes, [judged], options.out, run_options, options.history, progress)
    names = dict(zip((scene.name for scene in scenes), scene_names(options.scenes), strict=True))
    return GateRun(recorded, _explain_command(recorded, names, subject), known, until)


def update_baseline(found: GateRun, options: BaselineOptions) -> str:
    """Record every failure of a run as known, and say so in a line; empty where none is asked."""
    if not options.update or options.path is None or found.known is None:
        return ""
    why = options.reason or "recorded when the gate was set up"
    results = found.recorded.run.results
    number = write_baseline(options.path, results, found.known, why, found.until)
    return f"{options.path}: {count(number, 'failure')} recorded; a run with --baseline passes now"


def _explain_command(recorded: RecordedRun, names: dict[str, str], subject: Subject) -> str:
    """The command that explains the first wrong pixel; standard input cannot be read again."""
    for cell in recorded.run.findings.failing:
        name, check = names[cell.scene], cell.check
        if check.worst is not None and check.wrong and name != "-":
            words = [name, "--pixel", check.worst.column, check.worst.row]
            return shlex.join(["minirt", "explain", *map(str, words), *subject.arguments()])
    return ""


def _required(require: str, chosen: tuple[str, ...]) -> tuple[str, ...]:
    """Quantities that must be given: each must be judged, too."""
    required = chosen_quantities(require) if require else ()
    unjudged = [name for name in required if name not in chosen]
    if unjudged:
        raise InputError(
            "required, but not judged", where="--require", got=", ".join(unjudged),
            expected="only what --quantities names, or no --quantities",
        )  # fmt: skip
    return required


def _known_failures(options: BaselineOptions) -> Baseline | None:
    """The baseline of an earlier run; an empty one where a file is to be created."""
    today = date.today()
    if options.path is None:
        if options.update:
            raise InputError("no baseline to update", expected="--baseline FILE")
        return None
    if options.update and not options.path.exists():
        return Baseline((), today)
    return read_baseline(options.path, today)


def _until(text: str) -> date:
    if not text:
        return date.today() + timedelta(days=_DAYS)
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise InputError(
            "not a date", where="--until", got=repr(text)[:80], expected="as 2027-01-31"
        ) from None
