"""The process's standard streams and signals, in whatever state they were inherited."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import NoReturn, TextIO


def prepare() -> None:
    """Put the null device where a standard stream is closed; end in order on SIGTERM.

    Python has no object for a closed stream, and the next file to be opened would get its number
    and with it whatever a library prints. On SIGTERM the default would leave temporary files.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115 - stays open
    signal.signal(signal.SIGTERM, _terminated)


def discard_output(stream: TextIO) -> None:
    """Discard what is still to be written to a stream."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    with suppress(OSError):
        os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def discard_unwritable_output() -> None:
    """Discard the output of streams that cannot be written, such as a file on a full disk."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            discard_output(stream)


def _terminated(*_: object) -> NoReturn:
    sys.exit(128 + signal.SIGTERM)
