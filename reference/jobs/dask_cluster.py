"""Run jobs on the workers of a Dask scheduler: the only file that imports Dask."""

from __future__ import annotations

import asyncio
import logging
import re
import time
import warnings
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from uuid import uuid4

import dask
from distributed import Client, KilledWorker, Security, get_client, get_worker, rpc

from minirt.errors import InputError, ReferenceError
from reference.jobs.cluster import Cluster
from reference.jobs.isolate import Outcome
from reference.jobs.remote_worker import IncompatibleWorker, OnStart, TooManyDeaths

#: Number of workers that died of a job after which the job counts as crashed.
MOST_DEATHS = 3
#: Seconds to wait for the scheduler to answer, and for a worker to connect.
_CONNECTING, _PATIENCE = 10.0, 60.0
_ADDRESS = re.compile(r"(tcp|tls)://(\[[0-9A-Fa-f:.]+\]|[^\s/:@\[\]]+):\d{1,5}")
_EXPECTED = "tcp://HOST:PORT, as dask scheduler prints it"
_EXPECTED_TLS = "certificates in Dask's configuration: distributed.comm.tls"


class DaskCluster(Cluster):
    """The workers of a Dask scheduler. Use as a context manager.

    The jobs of a worker that dies run again on another one. Dask blames every job that waited at a
    dead worker; here only a job that had started there counts, which the worker records at the
    scheduler beforehand.

    Parameters
    ----------
    address : str
        Of the scheduler, as ``tcp://HOST:PORT``.
    patience : float
        Seconds without any worker after which the run is given up.

    Raises
    ------
    InputError
        The address is not valid, or no scheduler answers there.
    """

    def __init__(self, address: str, patience: float = _PATIENCE) -> None:
        self._address, self._patience = address, patience
        self._client = _connected(address)
        self._key = f"minirt {uuid4().hex}"
        self._losses: Counter[str] = Counter()
        self._no_worker_since: float | None = None
        super().__init__(self._client.get_executor(pure=False))

    def __exit__(self, *error: object) -> None:
        super().__exit__(*error)
        with suppress(Exception):  # the scheduler may be gone, or hang
            self._executor.shutdown(wait=False)
            if (scheduler := self._client.scheduler) is not None:
                note = {"keys": [self._key], "value": {}}
                self._client.sync(scheduler.set_metadata, **note, callback_timeout=_CONNECTING)
        self._client.close(timeout=_CONNECTING)

    def _capacity(self) -> int:
        return sum(self._threads().values())

    def _on_start(self, label: str) -> OnStart:
        return _RecordStart((self._key, label))

    def _check_workers(self) -> None:
        if self._threads():
            self._no_worker_since = None
            return
        now = time.monotonic()
        self._no_worker_since = self._no_worker_since or now
        if now - self._no_worker_since >= self._patience:
            raise ReferenceError(
                "no worker is there to do the jobs", where=self._address,
                got=f"none within {self._patience:g} s", expected=f"dask worker {self._address}",
            )  # fmt: skip

    def _lost(self, error: Exception, label: str) -> Outcome | None:
        if self._client.status != "running":
            raise ReferenceError("the connection to the scheduler is lost", where=self._address)
        if isinstance(error, KilledWorker):
            died = self._client.get_metadata([self._key, label], default=[])
            return Outcome("crashed", None, _deaths(died)) if len(died) >= MOST_DEATHS else None
        # An outcome may be lost together with its worker; Dask reports that in many ways.
        self._losses[label] += 1
        if self._losses[label] < MOST_DEATHS:
            return None
        raise IncompatibleWorker(
            "workers cannot take jobs", where=self._address,
            got=f"{type(error).__name__}: {error}"[:300], expected="the same minirt everywhere",
        )  # fmt: skip

    def _threads(self) -> dict[str, int]:
        """Number of jobs that each worker runs at the same time, by its address."""
        try:
            found: dict[str, int] = self._client.nthreads(callback_timeout=_PATIENCE)
        except Exception as error:
            raise ReferenceError(
                "the scheduler is gone", where=self._address, got=f"{type(error).__name__}: {error}"
            ) from None
        return found


@dataclass(frozen=True)
class _RecordStart:
    """Records at the scheduler the workers on which one job has started. An `OnStart`."""

    key: tuple[str, ...]

    def __call__(self) -> str:
        client, here = get_client(), str(get_worker().address)
        started = client.get_metadata(list(self.key), default=[])
        if len(started) >= MOST_DEATHS:
            raise TooManyDeaths(_deaths(started))
        client.set_metadata(list(self.key), [*started, here])
        return here


def _deaths(workers: list[str]) -> str:
    return f"{len(workers)} workers died of it: {', '.join(workers)}"


def _connected(address: str) -> Client:
    """A client of the scheduler at an address."""
    if not _ADDRESS.fullmatch(address):
        raise InputError(
            "not the address of a scheduler", where="--cluster", got=repr(address)[:80],
            expected=_EXPECTED,
        )  # fmt: skip
    for name in ("distributed", "distributed.client"):  # our own errors report what they log
        logging.getLogger(name).setLevel(logging.CRITICAL)
    dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 TiB"})
    try:
        asyncio.run(asyncio.wait_for(_greeted(address), _CONNECTING))
        with warnings.catch_warnings(action="ignore"):  # the versions are compared by `perform`
            return Client(address, timeout=_CONNECTING, set_as_default=False)
    except Exception as error:  # whatever answers there may be no scheduler
        got = " ".join(str(error).split())[:200] or f"nothing within {_CONNECTING:g} s"
        raise InputError(
            "no scheduler answers", where=address, got=got,
            expected=_EXPECTED_TLS if address.startswith("tls") else _EXPECTED,
        ) from None  # fmt: skip


async def _greeted(address: str) -> None:
    """Check that a scheduler answers: a client would wait for ever if there is none."""
    security = Security().get_connection_args("client")
    async with rpc(address, connection_args=security) as server:
        kind = (await server.identity())["type"]
    if kind != "Scheduler":
        raise ValueError(f"a {kind}")
