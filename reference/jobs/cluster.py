"""Jobs handed to any executor: whole, since its workers may be on other machines.

A job and its answer travel as bytes, with the meshes of their scenes; a worker that runs another
minirt does none. Answers come as they are ready.
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
from reference.identity import identity
from reference.jobs.isolate import Outcome
from reference.jobs.parcel import packed, unpacked
from reference.jobs.remote_worker import Begin, Refused, perform, this_machine

#: Seconds between two looks at whether anybody is left to do the jobs.
_LOOK = 1.0

#: A function and its arguments, all of them picklable.
Job = tuple[Callable[..., Any], tuple[Any, ...]]


class _Order(NamedTuple):
    """A job on its way: its number, a name that no other job has, and itself in a parcel."""

    number: int
    label: str
    job: bytes


class Cluster:
    """Workers behind an executor. Use as a context manager; leaving it cancels what waits.

    Parameters
    ----------
    executor : Executor
        Of `concurrent.futures`; whoever made it shuts it down.
    workers : int
        Jobs that it does at the same time.
    """

    def __init__(self, executor: Executor, workers: int = 1) -> None:
        self._executor, self._workers = executor, workers
        self._rooms = count()

    def __enter__(self) -> Self:
        self._scratch = TemporaryDirectory(prefix="minirt-")
        return self

    def __exit__(self, *_: object) -> None:
        self._scratch.cleanup()

    def outcomes(self, jobs: Iterable[Job]) -> Generator[tuple[int, Outcome]]:
        """Do jobs; yield each one's number and how it ended, as they end.

        A job is drawn when a worker is free: one that waited at a worker's door would be blamed for
        its death, and idle ones would not get it. Those that have not begun are cancelled when
        nobody asks any further.

        Raises
        ------
        Refused
            A worker runs another minirt.
        ReferenceError
            Nobody is left to do the jobs.
        """
        waiting: dict[Future[bytes], _Order] = {}
        orders = (_Order(k, uuid4().hex, packed(job)) for k, job in enumerate(jobs))
        try:
            while True:
                self._fill(waiting, orders)
                if not waiting:
                    return
                ended, _ = wait(waiting, _LOOK, FIRST_COMPLETED)
                if not ended:
                    self._look()
                for future in ended:
                    order = waiting.pop(future)
                    outcome = self._outcome(future, order)
                    if outcome is None:
                        waiting[self._submit(order)] = order
                    else:
                        yield order.number, outcome
        finally:
            for future in waiting:
                future.cancel()

    def _fill(self, waiting: dict[Future[bytes], _Order], orders: Iterator[_Order]) -> None:
        while len(waiting) < max(1, self._width()):
            order = next(orders, None)
            if order is None:
                return
            waiting[self._submit(order)] = order

    def _submit(self, order: _Order) -> Future[bytes]:
        try:
            begin = self._begin(order.label)
            return self._executor.submit(perform, identity(), order.job, begin)
        except RuntimeError as error:  # one of several processes died, and none is left
            raise ReferenceError("the executor takes no more jobs", got=str(error)) from None

    def _outcome(self, future: Future[bytes], order: _Order) -> Outcome | None:
        """How a job ended; None where it is to be done again."""
        try:
            answer = future.result()
        except Exception as error:  # a CancelledError among them
            return self._died(error, order.label)
        outcome: Outcome = unpacked(answer, self._room())
        if isinstance(outcome.value, Refused):
            raise outcome.value
        return outcome

    def _room(self) -> Path:
        return Path(self._scratch.name) / str(next(self._rooms))

    def _width(self) -> int:
        """Jobs that are done at the same time, now."""
        return self._workers

    def _begin(self, label: str) -> Begin:
        """What notes that one job begins on a worker."""
        return this_machine

    def _look(self) -> None:
        """See whether anybody is left to do the jobs.

        Raises
        ------
        ReferenceError
        """

    def _died(self, error: Exception, label: str) -> Outcome | None:
        """How a job ended that got no answer; None where it is to be done again."""
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
