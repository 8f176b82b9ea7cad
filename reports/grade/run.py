"""Grade a class: every submission on its own, in child processes, whatever the others do."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from converters.atomic import atomic_folder
from minirt.errors import InputError, MinirtError, ReferenceError
from reference.cache import usual_folder
from reference.jobs.cluster import Cluster, Job
from reference.jobs.identity import PACKAGES, source_digest
from reference.jobs.isolate import Workers
from reference.jobs.program import sandbox_missing
from reference.jobs.scratch_folders import remove
from reports.gate.subject import GRACE
from reports.grade.assignment import Sheet
from reports.grade.closer import Closer, look_closer
from reports.grade.copies import find_copies
from reports.grade.handed import Handed, read_handed
from reports.grade.judge import Desk, SheetResult, judge_sheet, prepare, without_frame
from reports.grade.record import (
    ClassRecord,
    Student,
    folder_name,
    kept_student,
    shown_name,
    write_json,
)
from reports.grade.rubric import Rubric
from reports.grade.score import Speaking, days_late, marks_of
from reports.grade.student_files import write_student
from reports.grade.submission import Opened, build, digest_of, open_submission
from reports.results.words import count, listed
from reports.run import made_folder

#: Failing scenes of a student that are explained: the first, and the next of another stage.
_EXPLAINED = 2
#: Students whom a remark names.
_NAMED = 10
#: Seconds for what is ours to do with one submission, or with one of its scenes.
_PATIENCE = 300.0

#: Called with the numbers of students done and of all.
Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class _Office:
    """Where students are graded: the desk, the processes, the folder, what is known beforehand."""

    desk: Desk
    workers: Workers
    out: Path
    speaking: Speaking
    times: Mapping[str, datetime]


def grade_class(
    students: Mapping[str, Path],
    desk: Desk,
    out: Path,
    jobs: int = 2,
    times: Mapping[str, datetime] | None = None,
    progress: Progress | None = None,
    cluster: Cluster | None = None,
) -> ClassRecord:
    """Grade every submission, and leave each student's files behind as soon as they are known.

    A run that was ended in the middle goes on where it was: what an earlier run graded under the
    same rubric, of the same submission, by the same minirt, is taken over.

    Parameters
    ----------
    students : mapping of str to Path
        Submissions by student.
    desk : Desk
    out : Path
        Made where it is not there.
    jobs : int
        Child processes, and submissions in work at a time.
    times : mapping of str to datetime, optional
        When they were handed in.
    progress : callable, optional
    cluster : Cluster, optional
        Whose workers grade a student each in place of this machine, with their own cache.

    Raises
    ------
    InputError
        A part of the rubric that no pixel speaks of, or a folder that cannot be written.
    ReferenceError
        minirt itself failed, or a program was handed in and there is no sandbox.
    """
    for name in ("students", "staff/state"):
        made_folder(out / name)
    with Workers(jobs) as workers:
        speaking = _prepared(desk, workers)
        office = _Office(desk, workers, out, speaking, times or {})
        if cluster is None:
            graded, crashed = list(_graded(office, students, jobs, progress)), list[str]()
        else:
            graded, crashed = _graded_on(cluster, office, students, progress)
    rubric = desk.assignment.rubric
    remarks = list(_remarks(rubric, graded, sorted(office.times.keys() - students.keys())))
    if crashed:
        remarks.append(f"not graded, for it crashed; another run tries again: {_some(crashed)}")
    return ClassRecord(
        title=rubric.title, of=rubric.points, students=tuple(graded),
        copies=find_copies(graded), remarks=tuple(remarks),
    )  # fmt: skip


def _graded(
    office: _Office, students: Mapping[str, Path], jobs: int, progress: Progress | None
) -> Iterator[Student]:
    with ThreadPoolExecutor(jobs) as clerks:
        started = [
            clerks.submit(_grade, office, name, path) for name, path in sorted(students.items())
        ]
        try:
            for k, future in enumerate(started, start=1):
                yield future.result()
                if progress is not None:
                    progress(k, len(started))
        finally:
            clerks.shutdown(wait=False, cancel_futures=True)


def _graded_on(
    cluster: Cluster, office: _Office, students: Mapping[str, Path], progress: Progress | None
) -> tuple[list[Student], list[str]]:
    """Every student, and the names of those whose job crashed; who will be refused, here."""
    found: dict[str, Student] = {}
    crashed: list[str] = []
    sent: list[_File] = []

    def jobs() -> Iterator[Job]:
        for name, path in sorted(students.items()):
            file = _file_of(office, name, path)
            handed = None if file.kept() else read_handed(path)
            if handed is None:
                found[name] = _grade(office, name, path)
                continue
            sent.append(file)
            yield _grade_away, (office.desk, office.speaking, file, handed)

    for number, outcome in cluster.outcomes(jobs()):
        file = sent[number]
        if isinstance(outcome.value, MinirtError):
            raise outcome.value
        if outcome.state == "done":
            found[file.name] = file.keep(*outcome.value)
        else:
            found[file.name] = _lost(office, file, outcome.reason)
            crashed.append(file.name)
        if progress is not None:
            progress(len(found), len(students))
    return [found[name] for name in sorted(students)], crashed


def _prepared(desk: Desk, workers: Workers) -> Speaking:
    """minirt's own answers, computed once, and the parts that each scene speaks of."""
    sheets = desk.assignment.sheets
    started = [workers.submit(None, prepare, desk, sheet) for sheet in sheets]
    speaking = {}
    for sheet, job in zip(sheets, started, strict=True):
        outcome = job.outcome()
        if outcome.state != "done":
            raise ReferenceError("minirt itself failed", where=sheet.scene.name, got=outcome.reason)
        speaking[sheet.scene.name, sheet.number] = outcome.value
    for k, part in enumerate(desk.assignment.rubric.part):
        if not any(spoken[k] for (_, number), spoken in speaking.items() if number == 0):
            raise InputError("no pixel of its scenes speaks of a part", where=part.name)
    return speaking


@dataclass(frozen=True)
class _File:
    """One student's: when and under which hash it was handed in, and where the record goes."""

    name: str
    submitted: datetime | None
    key: str
    state: Path
    target: Path

    def kept(self) -> Student | None:
        """What an earlier run has found, if nothing changed."""
        return kept_student(self.state, self.key) if self.target.is_dir() else None

    def keep(self, student: Student, files: Mapping[str, bytes]) -> Student:
        """Leave behind what was found elsewhere."""
        with atomic_folder(self.target) as staging:
            for name, content in files.items():
                (staging / name).write_bytes(content)
        write_json(student, self.state)
        return student


def _file_of(office: _Office, name: str, path: Path) -> _File:
    folder = folder_name(name)
    submitted = office.times.get(name)
    return _File(
        name, submitted, _key(office.desk, path, name, submitted),
        office.out / "staff" / "state" / f"{folder}.json", office.out / "students" / folder,
    )  # fmt: skip


def _grade(office: _Office, name: str, path: Path) -> Student:
    """One student; what an earlier run has found, if nothing changed."""
    file = _file_of(office, name, path)
    student = file.kept()
    if student is None:
        student = _marked(office, file, path)
        write_json(student, file.state)
    return student


def _marked(office: _Office, file: _File, path: Path) -> Student:
    """One student, whose own files are left behind."""
    with _room() as room:
        opened, message = _opened(office, path, room)
        results = _judged(office, opened, room) if opened is not None else ()
        closer = _closer(office, opened, room, results) if opened is not None else ()
        student = _student(office, file, opened, message, results, closer)
        with atomic_folder(file.target) as staging:
            places = {sheet.scene.name: place_of(room, sheet) for sheet in _public(office)}
            write_student(student, office.desk.assignment.rubric.title, places, staging)
    return student


def _student(
    office: _Office,
    file: _File,
    opened: Opened | None,
    message: str,
    results: tuple[SheetResult, ...] = (),
    closer: tuple[Closer, ...] = (),
) -> Student:
    assignment = office.desk.assignment
    late = days_late(assignment.rubric.late, file.submitted)
    return Student(
        name=shown_name(file.name), folder=folder_name(file.name), key=file.key, message=message,
        kind="nothing" if opened is None else "program" if opened.is_program else "frames",
        submitted=file.submitted.isoformat() if file.submitted else None,
        marks=marks_of(assignment, office.speaking, results, late),
        results=results, closer=closer,
    )  # fmt: skip


def _grade_away(
    desk: Desk, speaking: Speaking, file: _File, handed: Handed
) -> tuple[Student, dict[str, bytes]]:
    """One student on a worker, with what the worker has; the record, and the student's files."""
    here = replace(desk, cache=replace(desk.cache, folder=usual_folder()))
    with _room() as room, Workers(1) as workers:
        office = _Office(here, workers, room, speaking, {})
        path = handed.put(_made(room / "handed-in"))
        student = _marked(office, replace(file, target=_made(room / "files") / "own"), path)
        own = room / "files" / "own"
        return student, {each.name: each.read_bytes() for each in sorted(own.iterdir())}


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder


def _lost(office: _Office, file: _File, reason: str) -> Student:
    """A student whose job crashed: no record is kept, so that another run tries again."""
    student = _student(office, file, None, f"crashed: {reason}")
    with atomic_folder(file.target) as staging:
        write_student(student, office.desk.assignment.rubric.title, {}, staging)
    return student


def _opened(office: _Office, path: Path, room: Path) -> tuple[Opened | None, str]:
    """The submission's files, built where they are to be; or why there is nothing to grade."""
    desk = office.desk
    folder = room / "submission"
    folder.mkdir()
    rubric = desk.assignment.rubric
    scenes = [sheet.scene.name for sheet in _public(office)]
    outcome = office.workers.submit(
        _PATIENCE, open_submission, path.absolute(), folder, scenes, rubric
    ).outcome()
    if outcome.state != "done":
        said = str(outcome.value) if isinstance(outcome.value, MinirtError) else outcome.reason
        return None, said.replace(f"{path.absolute()}", path.name).replace(
            f"{folder}", "submission"
        )
    opened: Opened = outcome.value
    if not opened.is_program:
        return opened, ""
    reason = sandbox_missing() if desk.sandbox else None
    if reason:
        raise ReferenceError(
            "no sandbox for the programs that were handed in", where=shown_name(path.name),
            got=reason, expected="bubblewrap, or --no-sandbox where every submission is trusted",
        )  # fmt: skip
    patience = rubric.limits.build_seconds + GRACE
    built = office.workers.submit(patience, build, opened, rubric.limits, desk.sandbox).outcome()
    fault = built.value if built.state == "done" else f"the build: {built.reason}"
    return (None, fault) if fault else (opened, "")


def _judged(office: _Office, opened: Opened, room: Path) -> tuple[SheetResult, ...]:
    """Every scene; of one that a worker did not survive, how it ended."""
    desk = office.desk
    sheets = [s for s in desk.assignment.sheets if s.public or opened.is_program]
    patience = desk.assignment.rubric.limits.seconds + GRACE
    started = [
        office.workers.submit(patience, judge_sheet, desk, sheet, opened, place_of(room, sheet))
        for sheet in sheets
    ]
    results = []
    for sheet, job in zip(sheets, started, strict=True):
        outcome = job.outcome()
        if outcome.state == "done":
            results.append(outcome.value)
        else:
            results.append(without_frame(sheet, opened, outcome))
    return tuple(results)


def _public(office: _Office) -> list[Sheet]:
    return [sheet for sheet in office.desk.assignment.sheets if sheet.public]


def place_of(room: Path, sheet: Sheet) -> Path:
    """Where a scene's pictures and frame wait."""
    return room / "sheets" / f"{sheet.number}-{sheet.scene.name}"


def _closer(
    office: _Office, opened: Opened, room: Path, results: Sequence[SheetResult]
) -> tuple[Closer, ...]:
    """The first failing public scenes, one a stage, explained."""
    sheets = {sheet.scene.name: sheet for sheet in _public(office)}
    wrong: dict[str, SheetResult] = {}
    for result in results:
        if result.number == 0 and result.wrong:
            wrong.setdefault(result.stage, result)
    started = [
        office.workers.submit(
            _PATIENCE, look_closer, office.desk, sheets[result.scene], opened,
            place_of(room, sheets[result.scene]), result,
        )
        for result in list(wrong.values())[:_EXPLAINED]
    ]  # fmt: skip
    ended = [job.outcome() for job in started]
    return tuple(outcome.value for outcome in ended if outcome.state == "done")


def _remarks(
    rubric: Rubric, students: Sequence[Student], strangers: Sequence[str]
) -> Iterator[str]:
    if rubric.late is not None:
        unknown = [student.name for student in students if student.submitted is None]
        if len(unknown) == len(students):
            yield "no time is known of any submission, so none is late: --times takes a table"
        elif unknown:
            number = f"{len(unknown)} of {count(len(students), 'submission')}"
            yield f"no time is known of {number}, on time therefore: {_some(unknown)}"
    if strangers:
        yield f"times of nobody who has handed in: {_some(strangers)}"
    if rubric.hidden is not None and any(s.kind == "frames" for s in students):
        frames = sum(s.kind == "frames" for s in students)
        hold = count(frames, "submission holds", "submissions hold")
        yield f"{hold} frames, which earn nothing on hidden scenes"


def _some(names: Sequence[str]) -> str:
    """Names in a sentence, not more than a few of them."""
    few = [shown_name(name) for name in names[:_NAMED]]
    more = len(names) - len(few)
    return listed([*few, count(more, "other")] if more else few)


def _key(desk: Desk, path: Path, name: str, submitted: datetime | None) -> str:
    digest = hashlib.sha256()
    program = (np.__version__, source_digest(*PACKAGES))
    for part in (*program, desk.assignment.sha256, name, digest_of(path), submitted, desk.sandbox):
        digest.update(str(part).encode(errors="surrogateescape") + b"\0")
    return digest.hexdigest()


@contextmanager
def _room() -> Iterator[Path]:
    """A folder for one submission, which goes with all that a program left in it."""
    room = Path(mkdtemp(prefix="minirt-")).resolve()
    try:
        yield room
    finally:
        remove(room)
