"""A PostgreSQL server of one's own, on the loopback, with a password; Debian's packages."""

from __future__ import annotations

import contextlib
import os
import pwd
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

USER, PASSWORD = "owner", "hush-hush"
_NUMBERS = count()


@dataclass(frozen=True)
class Server:
    """A running server."""

    port: int

    def url(self, database: str, password: str = PASSWORD) -> str:
        return f"postgresql://{USER}:{password}@127.0.0.1:{self.port}/{database}"

    def fresh(self) -> str:
        """The URL of a new, empty database."""
        import psycopg

        name = f"history{next(_NUMBERS)}"
        with psycopg.connect(self.url("postgres"), autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE {name}".encode())
        return self.url(name)


def programs() -> Path:
    """The folder of the server's programs. A missing server fails the tests that need it."""
    found = shutil.which("initdb")
    folders = sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True)
    folders += [Path(found).resolve().parent] if found else []
    assert folders, "no PostgreSQL here; .ci/system-packages PYTHON test brings it"
    return folders[0]


@contextlib.contextmanager
def running() -> Iterator[Server]:
    """A server that is gone, with all its data, when the block ends."""
    as_whom = _not_root()
    folder = Path(tempfile.mkdtemp(prefix="minirt-pg-"))
    try:
        if as_whom:
            os.chown(folder, as_whom["user"], as_whom["group"])
        data, secret = folder / "data", folder / "secret"
        secret.write_text(PASSWORD, encoding="utf-8")
        secret.chmod(0o644)
        tools = programs()
        subprocess.run(
            [tools / "initdb", "-D", data, "-U", USER, "-A", "scram-sha-256", "--pwfile", secret,
             "--no-sync", "-E", "UTF8", "--locale", "C"],
            check=True, capture_output=True, cwd=folder, **as_whom,
        )  # fmt: skip
        port = _free_port()
        server = subprocess.Popen(
            [tools / "postgres", "-D", data, "-p", str(port), "-c", "fsync=off",
             "-c", "listen_addresses=127.0.0.1", "-c", "unix_socket_directories="],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=folder, **as_whom,
        )  # fmt: skip
        try:
            _wait(Server(port), server)
            yield Server(port)
        finally:
            server.terminate()
            server.wait(30)
    finally:
        shutil.rmtree(folder)


def _wait(server: Server, process: subprocess.Popen[bytes]) -> None:
    """Until it answers."""
    import psycopg

    end = time.monotonic() + 60
    while True:
        assert process.poll() is None, "the server ended"
        try:
            psycopg.connect(server.url("postgres")).close()
            return
        except psycopg.OperationalError:
            assert time.monotonic() < end, "the server does not answer"
            time.sleep(0.05)


def _not_root() -> dict[str, Any]:
    """The server refuses to run as root: whom to be instead, for `subprocess`."""
    if os.getuid() != 0:
        return {}
    for name in ("postgres", "nobody"):
        with contextlib.suppress(KeyError):
            entry = pwd.getpwnam(name)
            return {"user": entry.pw_uid, "group": entry.pw_gid, "extra_groups": []}
    raise AssertionError("nobody to run the server as")


def _free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port: int = listener.getsockname()[1]
        return port
