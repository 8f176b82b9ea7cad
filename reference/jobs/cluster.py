"""Run jobs on the workers of any executor of `concurrent.futures`, also on other machines.

A job and its outcome are sent as bytes together with the mesh files of their scenes. A worker with
another version of minirt refuses. Outcomes arrive in the order in which jobs end.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Self
from uuid import uuid4

from minirt.errors import ReferenceError
from reference.jobs.identity import identity
from reference.jobs.isolate import Outcome
from reference.jobs.payload import from_payload, to_payload
from reference.jobs.remote_worker import IncompatibleWorker, OnStart, perform, this_machine

#: Seconds between two checks whether any worker is left.
_CHECK_SECONDS = 1.0

#: A function and its arguments, all of them picklable.
Job = tuple[Callable[..., Any], tuple[Any, ...]]


class _Task(NamedTuple):
    """A job to be sent: its number, a unique label, and its payload."""

    number: int
    label: str
    payload: bytes


class Cluster:
    """Workers behind an executor. Use as a context manager; leaving it cancels what waits.

    Parameters
    ----------
    executor : Executor
        Of `concurrent.futures`; the caller shuts it down.
    workers : int
        Jobs that it runs at the same time.
    """

    def __init__(self, executor: Executor, workers: int = 1) -> None:
        self._executor, self._workers = executor, workers
        self._folders = count()

    def __enter__(self) -> Self:
        self._scratch = TemporaryDirectory(prefix="minirt-")
        return self

    def __exit__(self, *_: object) -> None:
        self._scratch.cleanup()

    def outcomes(self, jobs: Iterable[Job]) -> Generator[tuple[int, Outcome]]:
        """Run jobs; yield the number and the outcome of each one as it ends.

        A job is submitted when a worker is free: one that waited at a worker would be blamed for
        that worker's death, and idle workers would not get it. When the generator is closed, jobs
        that have not started are cancelled.

        Raises
        ------
        IncompatibleWorker
            A worker runs another minirt.
        ReferenceError
            No worker is left.
        """
        waiting: dict[Future[bytes], _Task] = {}
        tasks = (_Task(k, uuid4().hex, to_payload(job)) for k, job in enumerate(jobs))
        try:
            while True:
                self._fill(waiting, tasks)
                if not waiting:
                    return
                ended, _ = wait(waiting, _CHECK_SECONDS, FIRST_COMPLETED)
                if not ended:
                    self._check_workers()
                for future in ended:
                    task = waiting.pop(future)
                    outcome = self._outcome(future, task)
                    if outcome is None:
                        waiting[self._submit(task)] = task
                    else:
                        yield task.number, outcome
        finally:
            for future in waiting:
                future.cancel()

    def _fill(self, waiting: dict[Future[bytes], _Task], tasks: Iterator[_Task]) -> None:
        while len(waiting) < max(1, self._capacity()):
            task = next(tasks, None)
            if task is None:
                return
            waiting[self._submit(task)] = task

    def _submit(self, task: _Task) -> Future[bytes]:
        try:
            on_start = self._on_start(task.label)
            return self._executor.submit(perform, identity(), task.payload, on_start)
        except RuntimeError as error:  # one of several processes died, and none is left
            raise ReferenceError("the executor takes no more jobs", got=str(error)) from None

    def _outcome(self, future: Future[bytes], task: _Task) -> Outcome | None:
        """How a job ended; None if it has to run again."""
        try:
            answer = future.result()
        except Exception as error:  # a CancelledError among them
            return self._lost(error, task.label)
        outcome: Outcome = from_payload(answer, self._folder())
        if isinstance(outcome.value, IncompatibleWorker):
            raise outcome.value
        return outcome

    def _folder(self) -> Path:
        return Path(self._scratch.name) / str(next(self._folders))

    def _capacity(self) -> int:
        """The number of jobs that can run at the same time now."""
        return self._workers

    def _on_start(self, label: str) -> OnStart:
        """What a worker calls when it starts one job."""
        return this_machine

    def _check_workers(self) -> None:
        """Check that a worker is left, or may still come.

        Raises
        ------
        ReferenceError
        """

    def _lost(self, error: Exception, label: str) -> Outcome | None:
        """How a job ended whose outcome did not arrive; None if it has to run again."""
        return Outcome("crashed", None, f"its worker died: {type(error).__name__}: {error}")


def in_order(ended: Iterable[tuple[int, Outcome]]) -> Iterator[Outcome]:
    """Outcomes in the order of their jobs, each as soon as those before it are known."""
    kept: dict[int, Outcome] = {}
    numbers = count()
    wanted = next(numbers)
    for number, outcome in ended:
        kept[number] = outcome
        while wanted in kept:
            yield kept.pop(wanted)
            wanted = next(numbers)
