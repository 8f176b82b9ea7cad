"""A Dask scheduler's workers: the only file that knows Dask."""

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
from reference.jobs.remote_worker import Begin, Refused, TooManyDeaths

#: Workers that may die of a job before it is called crashed.
MOST_DEATHS = 3
#: Seconds for the scheduler to answer, and for a first worker, or another one, to come.
_CONNECTING, _PATIENCE = 10.0, 60.0
_ADDRESS = re.compile(r"(tcp|tls)://(\[[0-9A-Fa-f:.]+\]|[^\s/:@\[\]]+):\d{1,5}")
_EXPECTED = "tcp://HOST:PORT, as dask scheduler prints it"
_EXPECTED_TLS = "certificates in Dask's configuration: distributed.comm.tls"


class DaskCluster(Cluster):
    """The workers of a Dask scheduler. Use as a context manager.

    A worker that dies has its jobs run again elsewhere. Dask itself blames every job that waited
    at a dead worker; what counts here is only that a job had begun there, which its worker notes
    at the scheduler beforehand.

    Parameters
    ----------
    address : str
        Of the scheduler, as ``tcp://HOST:PORT``.
    patience : float
        Seconds without any worker after which nobody is waited for any more.

    Raises
    ------
    InputError
        No such address, or nobody answers there.
    """

    def __init__(self, address: str, patience: float = _PATIENCE) -> None:
        self._address, self._patience = address, patience
        self._client = _connected(address)
        self._notes = f"minirt {uuid4().hex}"
        self._lost: Counter[str] = Counter()
        self._alone_since: float | None = None
        super().__init__(self._client.get_executor(pure=False))

    def __exit__(self, *error: object) -> None:
        super().__exit__(*error)
        with suppress(Exception):  # the scheduler may be gone, or hang
            self._executor.shutdown(wait=False)
            if (scheduler := self._client.scheduler) is not None:
                note = {"keys": [self._notes], "value": {}}
                self._client.sync(scheduler.set_metadata, **note, callback_timeout=_CONNECTING)
        self._client.close(timeout=_CONNECTING)

    def _width(self) -> int:
        return sum(self._threads().values())

    def _begin(self, label: str) -> Begin:
        return _Noted((self._notes, label))

    def _look(self) -> None:
        if self._threads():
            self._alone_since = None
            return
        now = time.monotonic()
        self._alone_since = self._alone_since or now
        if now - self._alone_since >= self._patience:
            raise ReferenceError(
                "no worker is there to do the jobs", where=self._address,
                got=f"none within {self._patience:g} s", expected=f"dask worker {self._address}",
            )  # fmt: skip

    def _died(self, error: Exception, label: str) -> Outcome | None:
        if self._client.status != "running":
            raise ReferenceError("the connection to the scheduler is lost", where=self._address)
        if isinstance(error, KilledWorker):
            died = self._client.get_metadata([self._notes, label], default=[])
            return Outcome("crashed", None, _deaths(died)) if len(died) >= MOST_DEATHS else None
        # An answer may be lost with its worker on the way here, which Dask tells in many ways.
        self._lost[label] += 1
        if self._lost[label] < MOST_DEATHS:
            return None
        raise Refused(
            "workers cannot take jobs", where=self._address,
            got=f"{type(error).__name__}: {error}"[:300], expected="the same minirt everywhere",
        )  # fmt: skip

    def _threads(self) -> dict[str, int]:
        """Jobs that each worker does at the same time, by its address."""
        try:
            found: dict[str, int] = self._client.nthreads(callback_timeout=_PATIENCE)
        except Exception as error:
            raise ReferenceError(
                "the scheduler is gone", where=self._address, got=f"{type(error).__name__}: {error}"
            ) from None
        return found


@dataclass(frozen=True)
class _Noted:
    """Notes at the scheduler on which workers one job has begun. A `Begin`."""

    place: tuple[str, ...]

    def __call__(self) -> str:
        client, here = get_client(), str(get_worker().address)
        begun = client.get_metadata(list(self.place), default=[])
        if len(begun) >= MOST_DEATHS:
            raise TooManyDeaths(_deaths(begun))
        client.set_metadata(list(self.place), [*begun, here])
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
    for name in ("distributed", "distributed.client"):  # what they log, our own errors say
        logging.getLogger(name).setLevel(logging.CRITICAL)
    dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 TiB"})
    try:
        asyncio.run(asyncio.wait_for(_greeted(address), _CONNECTING))
        with warnings.catch_warnings(action="ignore"):  # who runs what is asked by ourselves
            return Client(address, timeout=_CONNECTING, set_as_default=False)
    except Exception as error:  # whatever answers there may be no scheduler
        got = " ".join(str(error).split())[:200] or f"nothing within {_CONNECTING:g} s"
        raise InputError(
            "no scheduler answers", where=address, got=got,
            expected=_EXPECTED_TLS if address.startswith("tls") else _EXPECTED,
        ) from None  # fmt: skip


async def _greeted(address: str) -> None:
    """Say hello to a scheduler. A client would wait for ever for somebody who never answers."""
    security = Security().get_connection_args("client")
    async with rpc(address, connection_args=security) as somebody:
        kind = (await somebody.identity())["type"]
    if kind != "Scheduler":
        raise ValueError(f"a {kind}")
